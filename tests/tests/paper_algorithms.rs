//! Errors of the paper's algorithms, as counterexamples: sections 4.3 to 4.6. What the rule does as written stands in the
//! test; beside it, what the scheduler makes of the same case.

use crate::counterexamples::{dag, schedule};
use red_core::{Config, Duration, Estimator, Gate, Node, Reassign, Shed, Wcet};
use red_sim::{Drawn, Execution, Lab, Options, Report, Row, simulate_in};
use red_workload::model::Workload;
use red_workload::plan::plan;
use red_workload::policy::Policy;
use red_workload::{Format, parse};

const MS: u64 = 1_000_000;
/// A second of tasks on a pool.
fn run(lanes: u32, tasks: &str, policy: Policy) -> Report {
    configured(lanes, tasks, policy, policy.config())
}

fn read(lanes: u32, tasks: &str) -> Workload {
    let head =
        format!("[[pool]]\nname = 'gpu'\nlanes = {lanes}\n[[sensor]]\nname = 'front'\nperiod = '1s'\n");
    parse((head + tasks).as_bytes(), Format::Toml, "case.toml").unwrap_or_else(|e| panic!("{e}"))
}

fn configured(lanes: u32, tasks: &str, policy: Policy, config: Config) -> Report {
    let workload = read(lanes, tasks);
    let (horizon_ns, execution) = (1_000 * MS, Execution::Wcet);
    let world = Drawn { workload: &workload, execution, seed: 1 };
    let options = Options { policy, horizon_ns, seed: 1, execution, preempt: false, schedule: true };
    simulate_in(&world, &workload, config, &options).unwrap_or_else(|e| panic!("{e}"))
}

/// gamma of DynamicMerge; without merging nothing is within it.
fn gamma_ms() -> u64 {
    Config::RED.merge_skew.map_or(0, |gamma| gamma.as_nanos() / MS)
}

/// A job of one node.
fn node(name: &str, at_ms: u64, wcet_ms: u64, deadline_ms: u64) -> String {
    format!(
        "[[task]]\nname = '{name}'\nonce = true\noffset = '{at_ms}ms'\ndeadline = '{deadline_ms}ms'\n\
         node = [{{ name = 'n', wcet = '{wcet_ms}ms' }}]\n"
    )
}

/// A job that encodes the front camera's frame in 10 ms, and decodes in 1.
fn stage(name: &str, at_ms: u64, deadline_ms: u64) -> String {
    format!(
        "[[task]]\nname = '{name}'\nonce = true\noffset = '{at_ms}ms'\ndeadline = '{deadline_ms}ms'\n[[task.node]]\n\
         name = 's'\nmimonet = {{ weights = 'w', frame = 'front', encoder = {{ wcet = '10ms' }}, \
         decoders = [{{ name = 'd', wcet = '1ms' }}] }}\n"
    )
}

fn row<'a>(report: &'a Report, task: &str, node: &str) -> &'a Row {
    let rows = report.schedule.as_ref().expect("a schedule");
    rows.iter().find(|row| row.task == task && row.node == node).expect("it ran")
}

fn on_time(report: &Report, task: &str) -> bool {
    report.tasks.iter().any(|found| found.name == task && found.on_time == 1)
}

#[test]
fn the_merge_predicate_is_not_transitive() {
    let merges = |a: u64, b: u64| a.abs_diff(b) <= gamma_ms();
    assert!(merges(0, 80) && merges(80, 160) && !merges(0, 160));
    // Our window begins at its first member. A lane that is taken until 170 ms has all three wait.
    let tasks = [node("busy", 0, 170, 200), stage("a", 0, 900), stage("b", 80, 900), stage("c", 160, 900)];
    // ProactiveDrop would have given them up by then.
    let report = configured(1, &tasks.concat(), Policy::Red, Config { shed: Shed::Never, ..Config::RED });
    let start = |task| row(&report, task, "s.encoder").start_ns;
    assert_eq!(start("a"), start("b"));
    assert_ne!(start("b"), start("c"), "within gamma of b, and not of the unit's first");
}

#[test]
fn a_unit_that_waits_for_a_member_within_gamma_misses_a_deadline_of_30_ms() {
    let (u, v) = (0, 90);
    assert!(v - u <= gamma_ms(), "the rule merges the two");
    assert!(u64::max(u, v) + 11 > 30, "and the unit begins when its last member is there");
    let report = run(1, &[stage("u", u, 30), stage("v", v, 30)].concat(), Policy::Red);
    assert_eq!(row(&report, "u", "s.encoder").start_ns, 0, "a unit is formed of members that are ready");
    assert!(on_time(&report, "u") && on_time(&report, "v"));
}

#[test]
fn lowest_urgency_first_drops_the_job_that_could_still_make_it() {
    // At the drop, 30 ms, `late` is past its deadline of 26 ms, so its urgency is 1; `fresh` has 36 ms for 10 ms of work.
    let tasks = [node("busy", 0, 32, 900), node("late", 16, 10, 10), node("fresh", 26, 10, 40)].concat();
    let report = run(1, &tasks, Policy::Red);
    let shed: Vec<_> = report.sheds.iter().flatten().map(|shed| (&*shed.task, shed.reason)).collect();
    assert_eq!(shed, [("fresh", "urgency")]);
    assert!(!on_time(&report, "late") && !on_time(&report, "fresh"), "one is dropped, the other misses");
    let ours = run(1, &tasks, Policy::Redrt);
    assert!(on_time(&ours, "fresh"), "the dead job goes first");
}

#[test]
fn urgency_by_absolute_deadlines_stays_at_zero() {
    // S_i = d_i - t with d_i an instant (Definition 4) and t the time since the release. At 515 ms `tight` has 10 of its 20 ms
    // left, and `calm` 87 of its 100. By instants both score next to nothing, and `tight` less, since it came last.
    let score = |due: f64, elapsed: f64| (1.0 - (due - elapsed) / due).clamp(0.0, 1.0);
    let (drop, calm, tight) = (515.0, (502.0, 100.0), (505.0, 20.0));
    let absolute = |(release, deadline): (f64, f64)| score(release + deadline, drop - release);
    let relative = |(release, deadline): (f64, f64)| score(deadline, drop - release);
    assert!(absolute(tight) < absolute(calm) && absolute(calm) < 0.03);
    assert!(relative(calm) < relative(tight) && relative(tight) > 0.4);
    // The scheduler scores by the time since the release: the less urgent goes, at every time of day.
    for at in [0, 500] {
        let tasks = [node("busy", at, 60, 900), node("calm", at + 2, 10, 100), node("tight", at + 5, 1, 20)];
        let report = run(1, &tasks.concat(), Policy::Red);
        let first = report.sheds.iter().flatten().next().map(|shed| (&*shed.task, shed.at_ns / MS - at));
        assert_eq!(first, Some(("calm", 15)));
    }
}

#[test]
fn smallest_d_np_first_misses_what_edf_meets() {
    // D_np is WCET plus contention: the shortest atomic node first, whenever it is due.
    let (short, long) = ((2, 100), (5, 6));
    let both = dag(&[short.0, long.0], &[]);
    let by = |keys: [u64; 2]| schedule(&both, 1, |node| keys[node.index()] as i64, false);
    assert_eq!(by([short.0, long.0]), [2, 7], "by D_np the long one ends at 7 and was due at 6");
    assert_eq!(by([short.1, long.1]), [7, 5], "by deadlines both are in time");
    let tasks = [node("short", 0, short.0, short.1), node("long", 0, long.0, long.1)].concat();
    for policy in [Policy::Edf, Policy::Redrt] {
        let report = run(1, &tasks, policy);
        assert!(on_time(&report, "short") && on_time(&report, "long"), "{policy}");
    }
}

#[test]
fn algorithm_2_leaves_all_lanes_but_one_idle() {
    // It executes the task that it picked before it picks the next: two nodes of 10 take 20, on two lanes, too.
    let (cost, deadline) = (10, 15);
    let picked_one_by_one = dag(&[cost, cost], &[(0, 1)]);
    let picked_by_lanes = dag(&[cost, cost], &[]);
    let last_end = |graph| schedule(graph, 2, |_| 0, false).into_iter().max();
    assert_eq!(last_end(&picked_one_by_one), Some(20));
    assert!(last_end(&picked_one_by_one) > Some(deadline) && last_end(&picked_by_lanes) <= Some(deadline));
    let report = run(2, &[node("a", 0, cost, deadline), node("b", 0, cost, deadline)].concat(), Policy::Red);
    assert!(on_time(&report, "a") && on_time(&report, "b"));
}

#[test]
fn barriers_across_dags_make_one_late_for_the_other() {
    // Two graphs as one, as levels "across DAGs" are: 1 before 1, due at 3, and 10 alone.
    let both = dag(&[1, 1, 10], &[(0, 1)]);
    let order = |node: red_core::NodeId| node.index() as i64;
    assert_eq!(schedule(&both, 2, order, true)[1], 11, "its second level waits for the other graph's first");
    assert_eq!(schedule(&both, 2, order, false)[1], 2);
}

#[test]
fn a_residual_budget_below_zero_turns_the_order_round() {
    assert_eq!(
        Config::RED_IDA.reassign,
        Reassign::OnDispatch,
        "what is left of the deadline is shared out again"
    );
    // `p` of 5 ms has a deadline of 2, and `y` of 1 comes after it; `x` of 3 is at the first level. When p ends -3 ms are left,
    // shared out by level sums: x is due 2.25 ms ago, and y, behind it, 3 ms ago. So y goes first.
    let (now, budget) = (5_000, 2_000 - 5_000);
    let due = |prefix: i64| now + budget * prefix / 4;
    let (x, y) = (due(3), due(4));
    assert!(y < x);
    let rest = dag(&[3, 1], &[]);
    let by = |keys: [i64; 2]| schedule(&rest, 1, |node| keys[node.index()], false);
    assert_eq!(by([x, y]), [4, 1], "the level that was due last is first");
    // Of a late job each node is due at the deadline, and its levels stay in their order.
    assert_eq!(by([2_000, 2_000]), [3, 4]);
    let tasks = "[[task]]\nname = 'late'\nonce = true\ndeadline = '2ms'\nnode = [{ name = 'p', wcet = '5ms' }, \
                 { name = 'x', wcet = '3ms' }, { name = 'y', wcet = '1ms', after = ['p'] }]\n";
    let config = Config { gate: Gate::Precedence, shed: Shed::Never, ..Config::RED_IDA };
    let report = configured(1, tasks, Policy::RedIda, config);
    let start = |node| row(&report, "late", node).start_ns / MS;
    assert_eq!([start("x"), start("y")], [5, 8]);
}

#[test]
fn a_mean_of_eight_is_no_bound() {
    // Every second job takes 8 ms and the others 2, and 6 are allowed.
    let observed = [2, 8, 2, 8, 2, 8, 2, 8];
    let mut window = Estimator::new(&Node::new(Wcet::from_millis(8)));
    observed.iter().for_each(|ms| window.push(Duration::from_millis(*ms)));
    let mean = window.mean().map_or(0, |mean| mean.as_nanos() / MS);
    let job = |ms| node("job", 0, ms, 6);
    let fits = |ms| plan::<Lab>(&read(1, &job(ms))).unwrap_or_else(|e| panic!("{e}")).admission.fits;
    assert!(fits(mean) && !fits(8), "a test by the mean says yes, and one by the WCET no");
    let late = observed.iter().filter(|ms| !on_time(&run(1, &job(**ms), Policy::Redrt), "job")).count();
    assert_eq!(late, 4, "half of the jobs");
}
