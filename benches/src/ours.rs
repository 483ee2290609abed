//! RED as a contestant: the core driven as a host drives it.

mod abi;
mod frame;
mod lanes;
mod one_lane;
mod recorded;

use red_core::{BestCase, Capacity, Config, Dag, Duration, Node, PoolId, Scheduler, TaskId, Timing, Wcet};

use crate::graphs::{Body, Graph};
use crate::handoff::HOPS;
use crate::machine::Machine;
use crate::measure::Runner;
use crate::not_run::NotRun;
use crate::peers::Setup;

/// Without estimator: nothing that is observed steers what this configuration does.
const BARE: Config = Config { best_case: BestCase::Declared, ..Config::REDRT };

/// Worst-case execution time of every node. Equal costs make the keys follow the heights, as the peers' do.
const WCET: Wcet = Wcet::from_nanos(100_000);

/// Far enough away for every graph here, one node after the other.
const DEADLINE: Duration = Duration::from_secs(1);

/// Calls `$build` with the capacity for the graph of `$setup`: the next power of two, as `Caps` advises.
macro_rules! fitted {
    ($build:ident, $setup:expr, lanes $lanes:literal, events $events:literal $(, $more:expr)*) => {
        match $setup.graph.nodes() {
            256 => $build::<red_core::Caps<1, 256, 1, $lanes, 1, 4, $events>>($setup $(, $more)*),
            66 => $build::<red_core::Caps<1, 128, 1, $lanes, 1, 2, $events>>($setup $(, $more)*),
            6 => $build::<red_core::Caps<1, 8, 1, $lanes, 1, 1, $events>>($setup $(, $more)*),
            nodes => Err(NotRun::Failed(format!("no capacity is fitted to {nodes} nodes"))),
        }
    };
}

/// One lane, the record off, no estimator.
pub(crate) fn bare(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    use one_lane::build;
    fitted!(build, setup, lanes 1, events 0, BARE)
}

/// One lane; every execution is observed and every event recorded, and taken after each run.
pub(crate) fn observed(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    use one_lane::build;
    fitted!(build, setup, lanes 1, events 1024, Config::REDRT)
}

/// One lane through the recorder, with a tape.
pub(crate) fn recorded(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    use recorded::build;
    fitted!(build, setup, lanes 1, events 0, true)
}

/// The same run without a tape.
pub(crate) fn not_recorded(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    use recorded::build;
    fitted!(build, setup, lanes 1, events 0, false)
}

/// One lane of the largest class of the C ABI, called from Rust.
pub(crate) fn from_rust(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    abi::from_rust(setup)
}

/// The same calls through the C ABI.
pub(crate) fn through_abi(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    abi::linked(setup)
}

/// The same calls of the shared library, as it ships.
pub(crate) fn through_library(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    abi::loaded(setup)
}

/// Two lanes under one lock.
pub(crate) fn two_lanes(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    fn build<C: Capacity>(setup: &Setup<'_>) -> Result<Runner, NotRun> {
        let dag = dag::<C>(setup.graph, |_| PoolId::new(0))?;
        lanes::build(setup.machine, setup.body, Scheduler::new(Config::REDRT.with_lanes(2)), &dag)
    }
    fitted!(build, setup, lanes 2, events 0)
}

/// One lane that another thread releases frames to.
pub(crate) fn from_outside(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    use frame::build;
    fitted!(build, setup, lanes 1, events 0)
}

/// A chain whose nodes are in the pools of two lanes by turns: every node is a hand-off, through the lock.
pub(crate) fn hand_off(machine: &'static Machine) -> Result<Runner, NotRun> {
    type Chain = red_core::Caps<1, HOPS, 1, 2, 2>;
    let dag = dag::<Chain>(&Graph::chain(HOPS), |node| PoolId::new(1 - node as u8 % 2))?;
    let mut scheduler = Scheduler::new(BARE);
    scheduler.add_pool(1, None).map_err(failed)?;
    lanes::build(machine, Body::EMPTY, scheduler, &dag)
}

/// What a host would report and stop at.
pub(crate) fn failed(error: impl std::error::Error) -> NotRun {
    NotRun::Failed(format!("RED: {error}"))
}

/// The graph as the core has it.
pub(crate) fn dag<C: Capacity>(graph: &Graph, pool_of: impl Fn(usize) -> PoolId) -> Result<Dag<C>, NotRun> {
    let mut dag = Dag::new();
    let nodes = (0..graph.nodes()).map(|node| dag.add_node(Node::new(WCET).in_pool(pool_of(node))));
    let ids = nodes.collect::<Result<Vec<_>, _>>().map_err(failed)?;
    for (from, list) in graph.successors.iter().enumerate() {
        for &to in list {
            dag.add_edge(ids[from], ids[to as usize]).map_err(failed)?;
        }
    }
    Ok(dag)
}

/// Admits a graph.
pub(crate) fn admit<C: Capacity>(scheduler: &mut Scheduler<C>, dag: &Dag<C>) -> Result<TaskId, NotRun> {
    scheduler.add_task(dag, Timing::new(DEADLINE)).map_err(failed)
}

#[cfg(test)]
mod tests;
