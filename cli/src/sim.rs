//! `redrt sim`: a workload in virtual time.

use crate::given_up;
use crate::kept;
use crate::options;
use crate::outcome::{Answer, Failure};
use crate::output;
use crate::progress;
use crate::table::{Table, time};
use red_core::Duration;
use red_sim::{Execution, Options, Report, simulate};
use red_workload::policy::Policy;
use std::path::PathBuf;

/// Simulates a workload: the scheduler of a run, in virtual time.
#[derive(clap::Args)]
#[command(after_help = "Same arguments, same output, to the byte.

Example:
  redrt sim examples/cruise.toml --policy red --horizon 10s --execution uniform:0.5..1.0")]
pub(crate) struct Args {
    /// Workload file, TOML or YAML.
    file: PathBuf,
    /// Policy.
    #[arg(long, value_name = "POLICY", default_value = Policy::default().name(), value_parser = options::policy())]
    policy: Policy,
    /// Simulated time.
    #[arg(long, value_name = "TIME", default_value = "60s", allow_hyphen_values = true, value_parser = options::horizon_ns)]
    horizon: u64,
    /// Seed of the execution times.
    #[arg(long, value_name = "N", default_value = "1", allow_hyphen_values = true, value_parser = options::seed)]
    seed: u64,
    /// Execution times: `wcet`, or `uniform:LOW..HIGH` as shares of the WCET.
    #[arg(long, value_name = "MODEL", default_value = "wcet")]
    execution: Execution,
    /// Let a waiting node of a smaller key take the lane of a running one.
    #[arg(long)]
    preempt: bool,
    /// List every sub-job that started and every job that was given up.
    #[arg(long)]
    schedule: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Simulates and reports.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    let workload = red_workload::load(&args.file)?;
    let options = Options {
        policy: args.policy,
        horizon_ns: args.horizon,
        seed: args.seed,
        execution: args.execution,
        preempt: args.preempt,
        schedule: args.schedule,
    };
    let report = progress::during("simulating", || simulate(&workload, &options))?;
    if args.json {
        output::json(&report)?;
    } else {
        output::line(&text(&report))?;
    }
    Ok(Answer::Yes)
}

fn text(report: &Report) -> String {
    let Report { policy, seed, horizon_ns, nodes_missed, units_dispatched, encoder_runs_saved, .. } = report;
    let parts = [
        format!("{policy}, {} of virtual time, seed {seed}", Duration::from_nanos(*horizon_ns)),
        tasks(report).to_string(),
        given_up::by_task(&report.tasks),
        kept::promises(&report.tasks),
        times(report).to_string(),
        pools(report).to_string(),
        format!(
            "{units_dispatched} units dispatched, {encoder_runs_saved} encoder runs saved, \
             {nodes_missed} nodes late"
        ),
    ];
    let rows = report.schedule.as_ref().map(|_| schedule(report).to_string());
    let sheds = report.sheds.as_ref().filter(|sheds| !sheds.is_empty()).map(|_| sheds(report).to_string());
    let parts = parts.into_iter().filter(|part| !part.is_empty());
    parts.chain(rows).chain(sheds).collect::<Vec<_>>().join("\n\n")
}

fn tasks(report: &Report) -> Table {
    let mut table =
        Table::new(&["task", "released", "completed", "on time", "missed", "of them given up", "QoE 1"]);
    for task in &report.tasks {
        let counts = [task.released, task.completed, task.on_time, task.missed, task.shed]
            .map(|count| count.to_string());
        let quality = task.qoe.get("1").copied().flatten();
        let quality = quality.map_or_else(|| "-".to_owned(), |score| format!("{score:.3}"));
        table.row([task.name.clone()].into_iter().chain(counts).chain([quality]));
    }
    table
}

fn times(report: &Report) -> Table {
    let mut table = Table::new(&["task", "response p50", "p99", "max", "max tardiness"]);
    for task in &report.tasks {
        let response = &task.response_ns;
        let times = [response.p50, response.p99, response.max, task.tardiness_ns.max].map(time);
        table.row([task.name.clone()].into_iter().chain(times));
    }
    table
}

fn pools(report: &Report) -> Table {
    let mut table = Table::new(&["pool", "lanes", "busy"]);
    for pool in &report.pools {
        let whole = u128::from(pool.lanes) * u128::from(report.horizon_ns);
        let share = (u128::from(pool.busy_ns) * 1_000).checked_div(whole).unwrap_or(0);
        table.row([pool.name.clone(), pool.lanes.to_string(), format!("{}.{} %", share / 10, share % 10)]);
    }
    table
}

fn schedule(report: &Report) -> Table {
    let mut table = Table::new(&["task/job/node", "pool", "lane", "start", "finish"]);
    for row in report.schedule.iter().flatten() {
        let lane = row.lane.map_or_else(|| "-".to_owned(), |lane| lane.to_string());
        let name = format!("{}/{}/{}", row.task, row.job, row.node);
        table.row([name, row.pool.clone(), lane, time(Some(row.start_ns)), time(Some(row.finish_ns))]);
    }
    table
}

fn sheds(report: &Report) -> Table {
    let mut table = Table::new(&["given up", "at", "reason"]);
    for shed in report.sheds.iter().flatten() {
        table.row([format!("{}/{}", shed.task, shed.job), time(Some(shed.at_ns)), shed.reason.to_owned()]);
    }
    table
}
