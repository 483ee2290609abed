//! More work than the lanes can do: who gets what under each rule.

mod blocking;
pub(crate) mod broken;
mod claims;
mod d_over;
mod groups;
mod load;
mod measures;
mod others;
mod robust;
mod rules;

use crate::run::{PaperError, Run};
use crate::stat::Estimate;
use crate::table::{Cell, Column, Table};
use load::{Set, Shape, Times};
use rules::Rule;

const LANES: [u8; 3] = [1, 2, 4];
/// Mean work over lanes.
const LOADS: [f64; 5] = [1.1, 1.33, 1.5, 2.0, 3.0];

/// Where a set is from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    lanes: u8,
    load: f64,
    times: Times,
}

/// What a rule made of a set.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Value on time over its bound.
    value: f64,
    fairness: Option<f64>,
    floors: Option<f64>,
    /// Protected groups: whole, blocked, broken otherwise.
    groups: [u32; 3],
}

/// What the rows of a measure are about.
struct Measure {
    name: &'static str,
    shape: Shape,
    /// Parts and whole: shares are of sums over the sets of a seed.
    of: fn(&Sample) -> Option<(f64, f64)>,
}

impl Measure {
    const ALL: [Self; 9] = [
        Self { name: "one graph: jobs on time", shape: Shape::Lone, of: value },
        Self { name: "as a chain: jobs on time", shape: Shape::LoneChain, of: value },
        Self { name: "sets: value on time", shape: Shape::Values, of: value },
        Self { name: "sets: groups whole", shape: Shape::Values, of: whole },
        Self { name: "sets: broken groups blocked", shape: Shape::Values, of: blocked },
        Self { name: "with floors: value on time", shape: Shape::Floors, of: value },
        Self { name: "with floors: windows kept", shape: Shape::Floors, of: |s| Some((s.floors?, 1.0)) },
        Self { name: "equals, alike: least over greatest", shape: Shape::Alike, of: fairness },
        Self { name: "equals, any: least over greatest", shape: Shape::Equals, of: fairness },
    ];
}

fn value(sample: &Sample) -> Option<(f64, f64)> {
    Some((sample.value, 1.0))
}

fn whole(sample: &Sample) -> Option<(f64, f64)> {
    let [whole, blocked, broken] = sample.groups.map(f64::from);
    Some((whole, whole + blocked + broken))
}

fn blocked(sample: &Sample) -> Option<(f64, f64)> {
    let [_, blocked, broken] = sample.groups.map(f64::from);
    Some((blocked, blocked + broken))
}

fn fairness(sample: &Sample) -> Option<(f64, f64)> {
    Some((sample.fairness?, 1.0))
}

/// All that was run.
struct Results {
    seeds: u64,
    points: Vec<(Shape, Point, u64)>,
    samples: Vec<[Sample; Rule::ALL.len()]>,
}

impl Results {
    /// Of a measure, for a rule, at chosen points: by seed, parts and whole.
    fn sums(&self, measure: &Measure, rule: usize, is_chosen: impl Fn(&Point) -> bool) -> Vec<(f64, f64)> {
        let mut sums = vec![(0.0, 0.0); self.seeds as usize];
        for ((shape, point, seed), samples) in self.points.iter().zip(&self.samples) {
            if *shape == measure.shape && is_chosen(point) {
                let (part, whole) = (measure.of)(&samples[rule]).unwrap_or_default();
                let nth = *seed as usize - 1;
                let seeds = if is_certain(*shape, point) { 0..sums.len() } else { nth..nth + 1 };
                sums[seeds].iter_mut().for_each(|sum| *sum = (sum.0 + part, sum.1 + whole));
            }
        }
        sums
    }

    /// In percent, over seeds.
    fn percent(
        &self,
        measure: &Measure,
        rule: usize,
        is_chosen: impl Fn(&Point) -> bool,
    ) -> Option<Estimate> {
        let sums = self.sums(measure, rule, is_chosen);
        let shares = sums.iter().filter(|(_, whole)| *whole > 0.0).map(|(part, whole)| 100.0 * part / whole);
        Estimate::of(&shares.collect::<Vec<_>>())
    }

    fn row(&self, measure: &Measure, rule: usize) -> Vec<Cell> {
        let lanes = LANES.map(|lanes| self.percent(measure, rule, |point| point.lanes == lanes));
        let loads = LOADS.map(|load| self.percent(measure, rule, |point| point.load == load));
        let times = Times::ALL.map(|times| self.percent(measure, rule, |point| point.times == times));
        let names = [measure.name, Rule::ALL[rule].name()].map(Cell::from);
        names.into_iter().chain(lanes.into_iter().chain(loads).chain(times).map(Cell::from)).collect()
    }
}

/// Whether nothing is drawn, so that one run stands for those of all seeds.
fn is_certain(shape: Shape, point: &Point) -> bool {
    shape.is_alone() && point.times == Times::Wcet
}

fn points() -> Vec<Point> {
    let at =
        |lanes| LOADS.into_iter().flat_map(move |load| Times::ALL.map(|times| Point { lanes, load, times }));
    LANES.into_iter().flat_map(at).collect()
}

/// A set under all rules.
fn samples(
    shape: Shape,
    Point { lanes, load, times }: Point,
    seed: u64,
) -> Option<[Sample; Rule::ALL.len()]> {
    let set = Set::draw(shape, lanes, load, times, seed);
    let bound = if shape.is_alone() { measures::capacity(&set) } else { measures::bound(&set) };
    let protected = if shape == Shape::Values { groups::protected(&set)? } else { Vec::new() };
    let mut samples = [Sample { value: 0.0, fairness: None, floors: None, groups: [0; 3] }; Rule::ALL.len()];
    for (rule, sample) in Rule::ALL.iter().zip(&mut samples) {
        let ends = rule.run(&set)?;
        let mut groups = [0; 3];
        for group in &protected {
            groups[groups::fate(&set, group, &ends) as usize] += 1;
        }
        *sample = Sample {
            value: measures::value(&set, &ends) / bound,
            fairness: measures::fairness(&ends),
            floors: measures::floors(&set, &ends),
            groups,
        };
    }
    Some(samples)
}

fn results(run: &Run<'_>, points: &[Point]) -> Result<Results, PaperError> {
    let mut cells = Vec::new();
    for shape in Shape::ALL {
        for point in points {
            let seeds = if is_certain(shape, point) { 1 } else { run.seeds };
            cells.extend((1..=seeds).map(|seed| (shape, *point, seed)));
        }
    }
    let samples =
        run.each(&cells, |(shape, point, seed)| samples(*shape, *point, *seed).ok_or(PaperError::Capacity))?;
    Ok(Results { seeds: run.seeds, points: cells, samples })
}

pub(crate) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    table(run, &points())
}

fn table(run: &Run<'_>, points: &[Point]) -> Result<Table, PaperError> {
    let results = results(run, points)?;
    let rules = || 0..Rule::ALL.len();
    let rows = Measure::ALL.iter().flat_map(|measure| rules().map(|rule| results.row(measure, rule)));
    let percent = |name| Column::numbers(name, "%", 1);
    Ok(Table {
        name: "overload",
        title: "More work than the lanes can do",
        source: "not in the paper",
        about: about(&results),
        columns: vec![
            Column::words("what"),
            Column::words("rule"),
            percent("1 lane"),
            percent("2"),
            percent("4"),
            percent("load 1.1"),
            percent("1.33"),
            percent("1.5"),
            percent("2"),
            percent("3"),
            percent("at WCET"),
            percent("uniform"),
            percent("bimodal"),
        ],
        rows: rows.collect(),
        claims: claims::of(&results),
    })
}

fn about(results: &Results) -> Vec<String> {
    let seeds = results.seeds;
    let groups = |lanes: u8| -> f64 {
        results
            .sums(&Measure::ALL[claims::WHOLE], 0, |point| point.lanes == lanes)
            .iter()
            .map(|sum| sum.1)
            .sum()
    };
    let of_lanes = LANES.map(|lanes| groups(lanes).to_string());
    vec![
        format!(
            "Seeds 1 to {seeds}, one set of each kind for each seed, number of lanes, load and kind of execution times: {} sets, \
             each under every rule; means with 95 % intervals over the seeds. Load is mean work over lanes; nodes take their \
             WCET, or uniformly half of it to all of it, or half of it and one time in five all. Nobody is taken off a lane.",
            results.samples.len(),
        ),
        format!(
            "One graph: 2 ms; then 9, after which 3, 4 and 5 side by side; 14 beside all these; then 3; deadline 66 ms, {} jobs. As \
             a chain: the same nodes one after the other. At WCET nothing is drawn: one run.",
            load::LONE_JOBS,
        ),
        format!(
            "Sets: {} to {} tasks of {} to {} nodes of {} to {} ms, chains or branches side by side; UUniFast; deadlines are the time \
             that a job takes alone and {} to {} of its period, or of that time where that is longer; values 1 to {}, \
             log-uniform; releases within {} s. With floors: half of the tasks have one of at least m of any k, k to 5. \
             Equals: {} to {} tasks of one value; alike: of one graph, period and deadline too.",
            load::TASKS.0,
            load::TASKS.1,
            load::NODES.0,
            load::NODES.1,
            load::COST_US.0 / 1_000,
            load::COST_US.1 / 1_000,
            load::SLACK.0,
            load::SLACK.1,
            load::MOST_VALUE,
            load::HORIZON_NS / 1_000_000_000,
            load::EQUALS.0,
            load::EQUALS.1,
        ),
        "Value on time is over the most that fits: the jobs of most value for what they will take, until the lanes' time is full, \
         the last in part. No scheduler can have more, and none may be able to have as much. Jobs of one graph are over the \
         lanes' time in jobs of mean work, since nobody knows before which take less."
            .to_owned(),
        format!(
            "Groups: tasks from some value up that are all on time when they are alone, by the keys of redrt with no rule for \
             overload, with deadlines shorter by the longest node of the others; {} of them on {} lanes. Whole: {} % of each task's jobs are on time among the \
             others. Blocked: broken, and every node of lower value on a lane before the first missed job ended had started while \
             the group could wait; `broken-groups` has them by name. Least over greatest: shares of jobs on time of the task with the least and the \
             greatest.",
            of_lanes.join(", "),
            LANES.map(|lanes| lanes.to_string()).join(", "),
            groups::WHOLE_PERCENT,
        ),
        "Of the literature, in a simulator of their own that keeps lanes busy as ours does: highest value first; highest value \
         for the work that is left first; Robust EDF (Buttazzo and Stankovic 1993), with work over lanes in its guarantee, and \
         rejected jobs that come back; D-over (Koren and Shasha 1995) on the work of jobs, which decides where a lane comes \
         free, counts work over lanes on several, and leaves lanes over to who waits. All know the mean times, and give up a job \
         once its longest path at best case is too long."
            .to_owned(),
    ]
}

#[cfg(test)]
mod tests;
