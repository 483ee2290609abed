//! Every graph of up to five nodes, its edges going forward, with every choice of costs from a small set: each deadline
//! rule against the formulas of the specification, as the plan of `red_tests` has them, and what must hold of any rule.

use red_core::{
    Caps, Dag, DeadlineRule, Duration, LevelShare, Levels, Node, NodeId, SubDeadlines, Wcet, shares,
};
use red_tests::plan::{PlanNode, TaskPlan, plan};
use red_traces::RULES;
use red_workload::model::{self, Arrival, Body, Part, Pool, PoolKind, Task, Work, Workload};

type Few = Caps<1, 5, 1>;

const COSTS: [u64; 3] = [0, 1, 3];
/// Below, about and above what five nodes take.
const DEADLINES: [u64; 3] = [1, 7, 20];
const LANES: u8 = 2;

/// Sub-deadline and key of each node.
type Assigned = Vec<(i64, i64)>;

/// What is judged: the core's rules, or those with a bug.
type Assign = fn(&Dag<Few>, DeadlineRule, u64) -> Assigned;

fn of_core(dag: &Dag<Few>, rule: DeadlineRule, deadline: u64) -> Assigned {
    let due = SubDeadlines::assign(&Levels::of(dag), rule, Duration::from_nanos(deadline), &[LANES]);
    dag.nodes().map(|node| (due.sub_deadline(node), due.key(node))).collect()
}

/// A bug: each level's share is rounded down alone, so that time is lost.
fn level_by_level(dag: &Dag<Few>, rule: DeadlineRule, deadline: u64) -> Assigned {
    if rule != DeadlineRule::LevelSum || dag.work() == 0 {
        return of_core(dag, rule, deadline);
    }
    let levels = Levels::of(dag);
    let shares = level_shares(dag, rule, deadline);
    let end =
        |height: usize| -> u64 { shares[..=height].iter().map(|l| deadline * l.cost / dag.work()).sum() };
    dag.nodes().map(|node| end(levels.height(node)).cast_signed()).map(|due| (due, due)).collect()
}

/// A bug: latest finish forgets the cost of the last node of a path.
fn short_tails(dag: &Dag<Few>, rule: DeadlineRule, deadline: u64) -> Assigned {
    let levels = Levels::of(dag);
    let of = |node: NodeId| {
        let tail = dag.successors(node).iter().map(|i| levels.tail(NodeId::new(i as u8))).max().unwrap_or(0);
        deadline.cast_signed() - tail.cast_signed()
    };
    match rule {
        DeadlineRule::LatestFinish => dag.nodes().map(|node| (of(node), of(node))).collect(),
        _ => of_core(dag, rule, deadline),
    }
}

fn level_shares(dag: &Dag<Few>, rule: DeadlineRule, deadline: u64) -> Vec<LevelShare> {
    let levels = Levels::of(dag);
    shares(&levels, rule, Duration::from_nanos(deadline), &[LANES]).as_ref()[..levels.count()].to_vec()
}

/// One graph, as the core has it and as the oracle has it.
struct Case {
    dag: Dag<Few>,
    workload: Workload,
    edges: Vec<(u8, u8)>,
}

impl Case {
    fn new(edges: &[(u8, u8)], costs: &[u64]) -> Self {
        let mut dag = Dag::new();
        for cost in costs {
            dag.add_node(Node::new(Wcet::from_nanos(*cost))).expect("five nodes fit");
        }
        for (from, to) in edges {
            dag.add_edge(NodeId::new(*from), NodeId::new(*to)).expect("it goes forward");
        }
        Self { dag, workload: workload(edges, costs), edges: edges.to_vec() }
    }

    fn costs(&self) -> Vec<u64> {
        self.dag.nodes().map(|node| self.dag.node(node).map_or(0, Node::cost)).collect()
    }

    /// The first thing that is wrong with what `assign` makes of this graph.
    fn judge(&mut self, assign: Assign, deadline: u64) -> Result<(), String> {
        self.workload.tasks[0].deadline_ns = deadline;
        let expected = plan(&self.workload, &self.workload.tasks[0]);
        for rule in RULES {
            let found = assign(&self.dag, rule, deadline);
            let of_plan: Assigned =
                expected.nodes.iter().map(|node| from_plan(node, rule, deadline)).collect();
            let wrong = |what: &str| {
                let (edges, costs) = (&self.edges, self.costs());
                Err(format!(
                    "{rule:?}, D {deadline}, {costs:?}, {edges:?}: {what}: {found:?}, not {of_plan:?}"
                ))
            };
            if found != of_plan {
                return wrong("differs");
            }
            if !self.holds(rule, deadline, &found) {
                return wrong("breaks what every rule keeps");
            }
            if rule.is_level() && !self.levels_hold(rule, deadline, &expected) {
                return wrong("its level shares are wrong");
            }
        }
        Ok(())
    }

    /// Nobody is due before a predecessor, or later than the job; a path's last node is due with the job.
    fn holds(&self, rule: DeadlineRule, deadline: u64, found: &Assigned) -> bool {
        let costs = self.costs();
        let is_ordered = |(from, to): &(u8, u8)| {
            let (from, to) = (usize::from(*from), usize::from(*to));
            let ((due, key), (next_due, next_key)) = (found[from], found[to]);
            // For progress reports only: a node that costs nothing may come first.
            let reports = rule == DeadlineRule::PathProportional && costs[to] == 0;
            let gap = if rule == DeadlineRule::LatestStart { costs[from].cast_signed() } else { 0 };
            reports || due <= next_due && key + gap <= next_key
        };
        let ends_in_time = |(node, (due, _)): (NodeId, &(i64, i64))| {
            let is_last = self.dag.successors(node).is_empty() && !rule.is_level();
            *due <= deadline.cast_signed() && (!is_last || *due == deadline.cast_signed())
        };
        self.edges.iter().all(is_ordered) && self.dag.nodes().zip(found).all(ends_in_time)
    }

    fn levels_hold(&self, rule: DeadlineRule, deadline: u64, expected: &TaskPlan) -> bool {
        let shares = level_shares(&self.dag, rule, deadline);
        let is_as_planned = |(share, level): (&LevelShare, &red_tests::plan::Level)| {
            let share_holds = rule != DeadlineRule::LevelSum || share.share == level.share_ns;
            share.cost == level.cost_ns && share.graham == level.graham_ns && share_holds
        };
        shares.len() == expected.levels.len()
            && shares.iter().zip(&expected.levels).all(is_as_planned)
            && shares.iter().map(|level| level.share).sum::<u64>() == deadline
            && shares.last().is_some_and(|last| last.end == deadline)
            && shares.is_sorted_by_key(|level| level.end)
    }
}

fn from_plan(node: &PlanNode, rule: DeadlineRule, deadline: u64) -> (i64, i64) {
    let small = |ns: i128| i64::try_from(ns).expect("small numbers");
    let same = |ns: u64| (ns.cast_signed(), ns.cast_signed());
    match rule {
        DeadlineRule::EndToEnd => same(deadline),
        DeadlineRule::LevelSum => same(node.level_sum_ns),
        DeadlineRule::LevelGraham => same(node.level_graham_ns),
        DeadlineRule::PathProportional => same(node.path_proportional_ns),
        DeadlineRule::LatestFinish => (small(node.latest_finish_ns), small(node.latest_finish_ns)),
        DeadlineRule::LatestStart => (small(node.latest_finish_ns), small(node.latest_start_ns)),
    }
}

fn workload(edges: &[(u8, u8)], costs: &[u64]) -> Workload {
    let node = |(number, cost): (usize, &u64)| model::Node {
        name: format!("n{number}"),
        after: edges
            .iter()
            .filter(|(_, to)| usize::from(*to) == number)
            .map(|(from, _)| format!("n{from}"))
            .collect(),
        before: Vec::new(),
        work: Work::Plain(Part {
            wcet_ns: *cost,
            bcet_ns: 0,
            body: Body::None,
            pool: 0,
            memory_bytes: 0,
            atomic: false,
            contention_ns: 0,
        }),
    };
    let task = Task {
        name: "t".to_owned(),
        deadline_ns: 1,
        arrival: Arrival::Once,
        offset_ns: 0,
        value: 1,
        floor: None,
        nodes: costs.iter().enumerate().map(node).collect(),
    };
    let pool = Pool {
        name: "gpu".to_owned(),
        kind: PoolKind::Cpu,
        lanes: LANES.into(),
        memory_bytes: None,
        cpus: Vec::new(),
    };
    Workload { pools: vec![pool], sensors: Vec::new(), tasks: vec![task], events: Vec::new(), sync: None }
}

/// Judges every graph of up to `most` nodes; how many there are, or what is wrong with the first that is not right.
fn judge_all(assign: Assign, most: u8) -> Result<u64, String> {
    let mut cases = 0;
    for nodes in 1..=most {
        let pairs: Vec<(u8, u8)> = (1..nodes).flat_map(|to| (0..to).map(move |from| (from, to))).collect();
        for set in 0u32..1 << pairs.len() {
            let edges: Vec<_> = pairs
                .iter()
                .enumerate()
                .filter(|(bit, _)| set >> bit & 1 != 0)
                .map(|(_, pair)| *pair)
                .collect();
            for mut choice in 0..COSTS.len().pow(nodes.into()) {
                let mut cost = || {
                    let cost = COSTS[choice % COSTS.len()];
                    choice /= COSTS.len();
                    cost
                };
                let costs: Vec<u64> = (0..nodes).map(|_| cost()).collect();
                let mut case = Case::new(&edges, &costs);
                for deadline in DEADLINES {
                    case.judge(assign, deadline)?;
                    cases += 1;
                }
            }
        }
    }
    Ok(cases)
}

#[test]
fn every_rule_keeps_its_formula_on_every_graph_of_up_to_five_nodes() {
    let cases = judge_all(of_core, 5).unwrap_or_else(|wrong| panic!("{wrong}"));
    println!("{cases} graphs with costs and a deadline, {} rules each", RULES.len());
    let graphs = |nodes: u32| (1u64 << (nodes * (nodes - 1) / 2)) * 3u64.pow(nodes);
    assert_eq!(cases, (1..=5).map(graphs).sum::<u64>() * DEADLINES.len() as u64);
}

#[test]
fn shares_that_are_rounded_one_by_one_are_found() {
    let found = judge_all(level_by_level, 3);
    assert!(found.as_ref().is_err_and(|wrong| wrong.starts_with("LevelSum")), "{found:?}");
}

#[test]
fn a_tail_that_is_too_short_is_found() {
    let found = judge_all(short_tails, 3);
    assert!(found.as_ref().is_err_and(|wrong| wrong.starts_with("LatestFinish")), "{found:?}");
}
