//! Tests for a task that lives in one cluster: A0 and PREFIX.
//!
//! *Background.* Let job J be unfinished. Its critical chain goes back from an unfinished node to the predecessor that ended
//! last, to a source. While a node of it waits, all m lanes are busy: work-conserving dispatch. Over y = R - L + 1 of such
//! waiting m y of work is done, by J's other nodes, by jobs that go before it, and by nodes that had started and cannot be
//! stopped.
//! *Rule A0.* If m y > own(y) + I(R, y), no job of the task responds later than R.
//! *Rule PREFIX.* The same over windows that begin A before the release, when last a lane did nothing that goes before J: there
//! at most m - 1 tasks carry work in. It has to hold for every A >= 0.
//! *Why it holds.* The first instant at which any job passes its bound leads to a contradiction; no step looks at a schedule at
//! WCET, so it holds for every execution time below. Limited carry-in: Baruah 2006, Guan 2008; non-preemptive EDF on one lane:
//! Jeffay, Stanat, Martel 1991.

use crate::interference::{Keys, Looked, Other, Window};
use crate::shape::Part;
use std::iter::repeat_n;

/// How a bound of J's own work beside its critical chain is had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variant {
    /// Any critical path between the shortest and the longest.
    A,
    /// The part of it that falls into the waiting.
    B,
}

/// A response time that a test proves, with what a verifier needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Proved {
    pub(crate) response: i128,
    pub(crate) keys: Keys,
    pub(crate) variant: Variant,
    /// Of PREFIX: begins of the segments that A is divided into, the first 0.
    pub(crate) segments: Option<Vec<i128>>,
}

/// A task in its cluster.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Single<'a> {
    pub(crate) looked: Looked<'a>,
    /// Of the graph that is looked at.
    pub(crate) part: &'a Part,
    /// Other jobs of the task, whatever their graph.
    pub(crate) this: Other<'a>,
}

/// Rounds of a search for A0, and evaluations of the demand in one for PREFIX, at most: giving up is sound.
const ROUNDS: usize = 200;
const EVALUATIONS: usize = 8_192;
/// Windows that a list goes to, at most: longer ones are a load so close to all lanes that sums grow beyond 128 bits.
const LONGEST: i128 = 1 << 60;
/// Fixed point of utilisations.
const SCALE: i128 = 1 << 32;

impl Single<'_> {
    /// Work of J itself off its critical chain, while that chain waits `y`.
    fn own(&self, y: i128) -> i128 {
        let shape = self.looked.shape;
        let off = self.part.work - shape.longest;
        let spread = shape.longest - shape.shortest;
        let average = if y <= off { off } else { (off + spread) * y / (y + spread) };
        let hidden = (y - self.part.beyond(y)).max(0);
        average.min(self.part.capped(y) - hidden)
    }

    /// J's own work, and the measure that others' work falls into.
    fn own_part(&self, variant: Variant, response: i128) -> (i128, i128) {
        let shape = self.looked.shape;
        let y = response - shape.longest + 1;
        match variant {
            Variant::A => (self.part.work - shape.longest, response - shape.shortest + 1),
            Variant::B => (self.own(y), y),
        }
    }

    /// Other jobs of J's task that overlap it, where deadlines exceed periods: (all of their work, what goes before J).
    fn siblings(&self, response: i128, cap: i128) -> (i128, i128) {
        let Other { period: Some(period), part, bound } = self.this else { return (0, 0) };
        let first_key = part.groups.iter().map(|(key, _)| *key).min().unwrap_or(0);
        let (mut any, mut high) = (0, 0);
        let mut j = 1;
        while bound - j * period > 0 || response - j * period > 0 {
            let earlier = part.f((bound - j * period).min(cap));
            let later = part.f((response - j * period).min(cap));
            any += earlier + later;
            high += earlier;
            if j * period <= self.looked.shape.last_key - first_key {
                high += later;
            }
            j += 1;
        }
        (any, high)
    }

    /// The largest nodes of J's own task that may run as those of later jobs.
    fn own_low(&self) -> i128 {
        let jobs = self.this.at_once() - 1;
        let count = usize::try_from(self.looked.lanes - 1).unwrap_or(0);
        let costs = self.this.part.nodes.iter().flat_map(|(_, cost)| repeat_n(*cost, jobs));
        costs.take(count).sum()
    }

    /// The right side of A0.
    fn demand(&self, keys: Keys, variant: Variant, response: i128) -> i128 {
        let looked = &self.looked;
        let (own, cap) = self.own_part(variant, response);
        let w = Window { win: response, cap };
        let sum = |keys| looked.others.iter().map(|other| looked.carried(other, w, 0, keys)).sum::<i128>();
        let (any, high) = self.siblings(response, cap);
        let all = sum(Keys::Any) + any;
        match keys {
            Keys::Any => own + all,
            Keys::Key => {
                let before = sum(Keys::Key) + high;
                let low = looked.first() + looked.later(response, cap, self.own_low());
                own + before + (all - before).min(low)
            }
        }
    }

    /// The least response time that A0 proves, if that is within `limit`.
    pub(crate) fn a0(&self, keys: Keys, variant: Variant, limit: i128) -> Option<i128> {
        let longest = self.looked.shape.longest;
        let (mut wait, mut last_step) = (0, None);
        for _ in 0..ROUNDS {
            if longest + wait > limit {
                return None;
            }
            let needed = self.demand(keys, variant, longest + wait) / self.looked.lanes;
            if needed <= wait {
                return Some(longest + wait);
            }
            wait = self.looked.next_wait(self.part, wait, needed, &mut last_step);
        }
        None
    }

    /// The right side of PREFIX, what runs at the window's begin apart, for windows that begin `before` the release.
    fn prefix_demand(
        &self,
        keys: Keys,
        variant: Variant,
        response: i128,
        before: i128,
        first_at: i128,
    ) -> i128 {
        let looked = &self.looked;
        let (own, cap) = self.own_part(variant, response);
        let w = Window { win: before + response, cap: before + cap };
        let mut inside = 0;
        let mut carried = Vec::new();
        for other in looked.others {
            let released = looked.inside(other, w, before, keys);
            inside += released;
            carried.push((looked.carried(other, w, before, keys) - released).max(0));
        }
        // Of J's own task the earlier jobs.
        if let Some(period) = self.this.period {
            let z = Some(before - period);
            let released = self.this.inside(w, z, None);
            inside += released;
            carried.push((self.this.carried(w, z, None) - released).max(0));
        }
        carried.sort_unstable_by(|a, b| b.cmp(a));
        let low = |lanes: i128| match keys {
            Keys::Any => 0,
            Keys::Key => looked.pick(lanes, -1 - first_at),
        };
        let (mut sum, mut most) = (0, low(looked.lanes));
        for (lane, work) in (1..looked.lanes).zip(&carried) {
            sum += work;
            most = most.max(sum + low(looked.lanes - lane));
        }
        let later = match keys {
            Keys::Any => 0,
            Keys::Key => looked.later(response, cap, 0),
        };
        own + inside + most + later
    }

    /// From where on windows are so long that utilisation decides: the least A that satisfies the closing inequality.
    fn closing(&self, keys: Keys, variant: Variant, response: i128) -> Option<i128> {
        let looked = &self.looked;
        let mut utilisation = 0;
        let (mut constant, cap) = self.own_part(variant, response);
        if keys == Keys::Key {
            constant += looked.first() + looked.later(response, cap, 0);
        }
        for other in looked.others.iter().copied().chain([self.this]) {
            let work = other.part.work;
            constant += 2 * work;
            if let Some(period) = other.period {
                utilisation += ceil(work * SCALE, period);
                constant += ceil(work * (other.bound + response), period);
            }
        }
        let y = response - looked.shape.longest + 1;
        let (slack, needed) = (looked.lanes * SCALE - utilisation, (constant - looked.lanes * y) * SCALE);
        let end = (slack > 0).then(|| if needed < 0 { 0 } else { needed / slack + 1 });
        end.filter(|end| *end <= LONGEST)
    }

    /// The least response time that PREFIX proves, if that is within `limit`.
    pub(crate) fn prefix(&self, keys: Keys, variant: Variant, limit: i128) -> Option<(i128, Vec<i128>)> {
        let longest = self.looked.shape.longest;
        let mut left = EVALUATIONS;
        let (mut wait, mut last_step) = (0, None);
        // Where the last list could not go on: most waits that are too short are too short there.
        let mut at = 0;
        while longest + wait <= limit {
            let mut list = List { single: self, keys, variant, response: longest + wait, left: &mut left };
            let mut missing = list.missing(at, at).ok()?;
            if missing.is_none() {
                match list.segments().ok()?? {
                    Ok(segments) => return Some((longest + wait, segments)),
                    Err(stopped) => (at, missing) = (stopped.0, Some(stopped.1)),
                }
            }
            let needed = missing?.max(wait + 1);
            wait = self.looked.next_wait(self.part, wait, needed, &mut last_step);
        }
        None
    }

    /// The least response time that any test proves.
    pub(crate) fn best(&self, limit: i128, has_prefix: bool) -> Option<Proved> {
        let mut best: Option<Proved> = None;
        for keys in [Keys::Key, Keys::Any] {
            for variant in [Variant::B, Variant::A] {
                let within = best.as_ref().map_or(limit, |best| best.response - 1);
                if let Some(response) = self.a0(keys, variant, within) {
                    best = Some(Proved { response, keys, variant, segments: None });
                }
            }
        }
        if has_prefix {
            for keys in [Keys::Key, Keys::Any] {
                for variant in [Variant::B, Variant::A] {
                    let within = best.as_ref().map_or(limit, |best| best.response - 1);
                    if let Some((response, segments)) = self.prefix(keys, variant, within) {
                        best = Some(Proved { response, keys, variant, segments: Some(segments) });
                    }
                }
            }
        }
        best
    }
}

/// A response time that PREFIX may prove.
struct List<'a> {
    single: &'a Single<'a>,
    keys: Keys,
    variant: Variant,
    response: i128,
    /// Evaluations of the demand that may still be made.
    left: &'a mut usize,
}

/// No evaluation is left.
struct Spent;

/// Segments; or the A that they do not go beyond, and the waiting that it takes at least.
type Segments = Result<Vec<i128>, (i128, i128)>;

impl List<'_> {
    /// The waiting that it takes at least for A from `from` to `to` to be covered by the demand at its end; `None`: it is.
    fn missing(&mut self, from: i128, to: i128) -> Result<Option<i128>, Spent> {
        *self.left = self.left.checked_sub(1).ok_or(Spent)?;
        let looked = &self.single.looked;
        let y = self.response - looked.shape.longest + 1;
        let demand = self.single.prefix_demand(self.keys, self.variant, self.response, to, from);
        Ok((looked.lanes * (from + y) <= demand).then(|| demand / looked.lanes - from))
    }

    /// The segments; `None` where all lanes are loaded for ever.
    fn segments(&mut self) -> Result<Option<Segments>, Spent> {
        let Some(end) = self.single.closing(self.keys, self.variant, self.response) else { return Ok(None) };
        let mut segments = vec![0];
        loop {
            let from = segments[segments.len() - 1];
            if from >= end {
                return Ok(Some(Ok(segments)));
            }
            if let Some(missing) = self.missing(from, from)? {
                return Ok(Some(Err((from, missing))));
            }
            let (mut good, mut step) = (from, 1);
            while good + step < 2 * end.max(1) && self.missing(from, good + step)?.is_none() {
                good += step;
                step *= 2;
            }
            while step > 0 {
                if self.missing(from, good + step)?.is_none() {
                    good += step;
                }
                step /= 2;
            }
            segments.push(good + 1);
        }
    }
}

fn ceil(a: i128, b: i128) -> i128 {
    (a + b - 1).div_euclid(b)
}

#[cfg(test)]
mod tests;
