//! Set-up calls as words: how many follow the head is known from its kind, and the answer's come after those. They are
//! rare, so nothing is squeezed into the head, and what is not exactly as it would be written is refused.

use super::Head;
use super::codes::{ADMIT, COMMIT, POOL, SENSOR, code, kind, result, tag};
use super::figures::bits;
use crate::entry::{Answer, Call};
use crate::tape::Chunk;
use red_core::{
    Bound, Bytes, Certificate, Contention, Duration, Frame, Node, NodeId, PoolId, Ppm, Role, SensorId,
    TaskId, Wcet,
};

/// Words of a call at most.
const MOST: usize = 5;
/// Words of a certificate.
const PROOF: usize = 5;

/// A set-up call in words.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Told {
    kind: u64,
    words: [u64; MOST],
}

impl Told {
    /// `None`: it sets nothing up.
    pub(crate) fn of(call: &Call) -> Option<Self> {
        let (kind, words) = match *call {
            Call::AddPool { lanes, memory } => {
                let [is_limited, bytes] = option(memory.map(|bytes| bytes.0));
                (kind::POOL, [lanes.into(), is_limited, bytes, 0, 0])
            }
            Call::DispatchAhead(pool) => (kind::AHEAD, [pool.index() as u64, 0, 0, 0, 0]),
            Call::ObserveUse(pool, used) => (kind::USE, [pool.index() as u64, used.0.into(), 0, 0, 0]),
            Call::LosePool(pool) => (kind::LOST, [pool.index() as u64, 0, 0, 0, 0]),
            Call::AddSensor(period) => (kind::SENSOR, [period.as_nanos(), 0, 0, 0, 0]),
            Call::Node { place, node } => (kind::NODE, node_words(place, &node)),
            Call::Edges { from, group, to } => {
                (kind::EDGES, [from.index() as u64 | u64::from(group) << 8, to, 0, 0, 0])
            }
            Call::AddTask { deadline, period, value, floor: [m, k] } => {
                let [is_periodic, period] = option(period.map(Duration::as_nanos));
                let worth = u64::from(value) | u64::from(m) << 32 | u64::from(k) << 40;
                (kind::TASK, [deadline.as_nanos(), is_periodic, period, worth, 0])
            }
            Call::Commit { task, revision } => {
                (kind::COMMIT, [u64::from(task.to_bits()) | u64::from(revision) << 32, 0, 0, 0, 0])
            }
            _ => return None,
        };
        Some(Self { kind, words })
    }

    /// Its kind and its words.
    pub(crate) fn words(&self) -> impl Iterator<Item = u64> {
        [self.kind].into_iter().chain(self.words.into_iter().take(length(self.kind)))
    }

    /// The call. `None`: none is like that.
    fn call(&self) -> Option<Call> {
        let [first, second, third, fourth, _] = self.words;
        let call = match self.kind {
            kind::POOL => Call::AddPool { lanes: first as u8, memory: optional(second, third).map(Bytes) },
            kind::AHEAD => Call::DispatchAhead(PoolId::new(first as u8)),
            kind::USE => Call::ObserveUse(PoolId::new(first as u8), Ppm(second as u32)),
            kind::LOST => Call::LosePool(PoolId::new(first as u8)),
            kind::SENSOR => Call::AddSensor(Duration::from_nanos(first)),
            kind::NODE => node(&self.words),
            kind::EDGES => {
                Call::Edges { from: NodeId::new(first as u8), group: (first >> 8) as u8, to: second }
            }
            kind::TASK => Call::AddTask {
                deadline: Duration::from_nanos(first),
                period: optional(second, third).map(Duration::from_nanos),
                value: fourth as u32,
                floor: [(fourth >> 32) as u8, (fourth >> 40) as u8],
            },
            kind::COMMIT => {
                Call::Commit { task: TaskId::from_bits(first as u32), revision: (first >> 32) as u32 }
            }
            _ => return None,
        };
        // Bits that have no meaning are not passed over.
        (Self::of(&call) == Some(*self)).then_some(call)
    }

    const fn head(&self, code: u64) -> Head {
        Head { other: self.kind, ..Head::new(tag::SET_UP, code) }
    }
}

/// Words that follow a head of this kind, before those of the answer.
const fn length(kind: u64) -> usize {
    match kind {
        kind::SENSOR | kind::COMMIT | kind::AHEAD | kind::LOST => 1,
        kind::EDGES | kind::USE => 2,
        kind::POOL => 3,
        kind::TASK => 4,
        _ => MOST,
    }
}

/// Writes an entry, so long after the one before.
pub(super) fn put(call: &Call, answer: &Answer, step: u64, out: &mut Chunk) {
    // No other call comes here: `Recorder` makes the pairs.
    let Some(told) = Told::of(call) else { return };
    let (code, id) = match *answer {
        Answer::Pool(answer) => (code(answer, &POOL), answer.ok().map(|pool| pool.index() as u64)),
        Answer::Sensor(answer) => (code(answer, &SENSOR), answer.ok().map(|sensor| sensor.index() as u64)),
        Answer::Task(answer) => (code(answer, &ADMIT), answer.ok().map(|task| task.to_bits().into())),
        Answer::Committed(answer) => (code(answer, &COMMIT), None),
        Answer::Done(yes) => (yes.into(), None),
        _ => (0, None),
    };
    out.head(told.head(code).word(step), 1);
    told.words().skip(1).chain(id).for_each(|word| out.more(word));
    if let Answer::Committed(Ok(proof)) = answer {
        proof_words(proof).into_iter().for_each(|word| out.more(word));
    }
}

/// Reads what follows a head, given without its time. `None`: nobody wrote that.
pub(super) fn take<E>(
    head: u64,
    mut next: impl FnMut() -> Result<u64, E>,
) -> Result<Option<(Call, Answer)>, E> {
    let (code, kind) = (head >> 4 & 15, head >> 14 & 63);
    let mut told = Told { kind, words: [0; MOST] };
    if kind > kind::USE || told.head(code).word(0) != head {
        return Ok(None);
    }
    for word in told.words.iter_mut().take(length(kind)) {
        *word = next()?;
    }
    let is_ok = code == 0;
    let answer = match kind {
        kind::POOL => {
            let pool = if is_ok { byte(next()?) } else { Some(0) };
            pool.zip(result(code, &POOL)).map(|(id, r)| Answer::Pool(r.map(|()| PoolId::new(id))))
        }
        kind::SENSOR => {
            let sensor = if is_ok { byte(next()?) } else { Some(0) };
            sensor.zip(result(code, &SENSOR)).map(|(id, r)| Answer::Sensor(r.map(|()| SensorId::new(id))))
        }
        kind::TASK => {
            let task = if is_ok { bits(next()?) } else { Some(0) };
            task.zip(result(code, &ADMIT)).map(|(id, r)| Answer::Task(r.map(|()| TaskId::from_bits(id))))
        }
        kind::COMMIT if is_ok => {
            let mut words = [0; PROOF];
            for word in &mut words {
                *word = next()?;
            }
            proof(words).map(|proof| Answer::Committed(Ok(proof)))
        }
        kind::AHEAD | kind::LOST | kind::USE => (code < 2).then_some(Answer::Done(code == 1)),
        kind::COMMIT => result(code, &COMMIT).and_then(Result::err).map(|e| Answer::Committed(Err(e))),
        _ => is_ok.then_some(Answer::Nothing),
    };
    Ok(told.call().zip(answer))
}

fn option(value: Option<u64>) -> [u64; 2] {
    [value.is_some().into(), value.unwrap_or(0)]
}

fn optional(is_some: u64, value: u64) -> Option<u64> {
    (is_some != 0).then_some(value)
}

fn byte(word: u64) -> Option<u8> {
    u8::try_from(word).ok()
}

/// What is short is in the last word: place, pool, role in two bits, whether it is atomic, whether it has a sensor, and
/// from bit 20 on sensor, weights and frame.
fn node_words(place: NodeId, node: &Node) -> [u64; MOST] {
    let (role, frame) = match node.role() {
        Role::Ordinary => (0, 0),
        Role::SharedEncoder(Frame { weights, frame, sensor }) => {
            let sensor = sensor.map_or(0, |sensor| 1 << 19 | (sensor.index() as u64) << 20);
            (1, sensor | u64::from(weights) << 28 | u64::from(frame) << 44)
        }
        Role::Decoder => (2, 0),
    };
    let place = place.index() as u64 | (node.pool().index() as u64) << 8;
    let short = place | role << 16 | u64::from(node.is_atomic()) << 18 | frame;
    // In a graph no cost saturates.
    let (wcet, contention) = (node.wcet().as_nanos(), node.cost() - node.wcet().as_nanos());
    [wcet, node.best().as_nanos(), contention, node.footprint().0, short]
}

fn node(&[wcet, best, contention, memory, short]: &[u64; MOST]) -> Call {
    let wcet = Wcet::from_nanos(wcet);
    let sensor = (short >> 19 & 1 != 0).then(|| SensorId::new((short >> 20) as u8));
    let frame = Frame { weights: (short >> 28) as u16, frame: (short >> 44) as u16, sensor };
    let node = match short >> 16 & 3 {
        0 => Node::new(wcet),
        1 => Node::shared_encoder(wcet, frame),
        _ => Node::decoder(wcet),
    };
    let pool = PoolId::new((short >> 8) as u8);
    let node = node.best_case(Duration::from_nanos(best)).memory(Bytes(memory)).in_pool(pool);
    let atomic = node.atomic(Contention::from_nanos(contention));
    Call::Node { place: NodeId::new(short as u8), node: if short >> 18 & 1 == 0 { node } else { atomic } }
}

/// The first has the bound in two bits, its paths, whether memory holds, and the lanes.
fn proof_words(proof: &Certificate) -> [u64; PROOF] {
    let bound = match proof.bound {
        Bound::Graham => 0,
        Bound::LongPath { paths } => 1 | u64::from(paths) << 2,
        Bound::SeveralPools => 2,
        // No reader takes it.
        _ => 3,
    };
    let first = bound | u64::from(proof.memory_holds) << 10 | u64::from(proof.lanes) << 11;
    let [work, path] = [proof.work, proof.critical_path].map(Duration::as_nanos);
    [first, work, path, proof.response.as_nanos(), proof.limit.as_nanos()]
}

fn proof(words: [u64; PROOF]) -> Option<Certificate> {
    let [first, times @ ..] = words;
    let [work, critical_path, response, limit] = times.map(Duration::from_nanos);
    let bound = match first & 3 {
        0 => Bound::Graham,
        1 => Bound::LongPath { paths: (first >> 2) as u8 },
        2 => Bound::SeveralPools,
        _ => return None,
    };
    let (lanes, memory_holds) = ((first >> 11) as u8, first >> 10 & 1 != 0);
    let proof = Certificate { bound, lanes, work, critical_path, response, limit, memory_holds };
    (proof_words(&proof) == words).then_some(proof)
}
