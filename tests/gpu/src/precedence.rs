//! Precedence by stamps of the device's own clock, in random graphs on four streams.

use crate::runs::{self, Ran, Robot};
use crate::{Bench, Failure, Figures, kernels};
use red_core::{Dag, Node, PoolId, Wcet};
use red_cuda::Arguments;

const GRAPHS: u64 = 40;
const JOBS: usize = 25;
const PERIOD_NS: u64 = 3_000_000;
const STREAMS: u8 = 4;
/// Most nodes of a graph.
const NODES: u64 = 9;
/// Begin and end, of eight bytes each.
const STAMP: usize = 16;

/// A graph, and how long its kernels take; `None` of nodes on the CPU.
struct Graph {
    dag: Dag<Robot>,
    takes_ns: Vec<Option<u64>>,
    edges: Vec<(usize, usize)>,
}

fn random(seed: u64) -> Result<Graph, Failure> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut below = |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % n
    };
    let (mut dag, mut edges) = (Dag::new(), Vec::new());
    let mut takes_ns = Vec::new();
    let mut ids = Vec::new();
    for to in 0..(2 + below(NODES - 1)) as usize {
        let on_cpu = below(8) == 0;
        takes_ns.push((!on_cpu).then(|| 20_000 + 1_000 * below(180)));
        let node = Node::new(Wcet::from_millis(1)).in_pool(PoolId::new(on_cpu.into()));
        ids.push(dag.add_node(node).map_err(|error| error.to_string())?);
        for from in 0..to {
            if below(3) == 0 {
                dag.add_edge(ids[from], ids[to]).map_err(|error| error.to_string())?;
                edges.push((from, to));
            }
        }
    }
    Ok(Graph { dag, takes_ns, edges })
}

/// When each node of each job began and ended, where it is on the device.
type Stamps = Vec<Vec<Option<(u64, u64)>>>;

fn stamped(bench: &Bench, graph: &Graph) -> Result<(Ran, Stamps), Failure> {
    let nodes = graph.takes_ns.len();
    let places = bench.device.buffer(JOBS * nodes * STAMP)?;
    let mut seen = bench.device.pinned(JOBS * nodes * STAMP)?;
    let stream = bench.device.stream(0)?;
    stream.clear(&places)?;
    bench.device.synchronize()?;
    let module = kernels(bench)?;
    let ran = runs::jobs(bench, &graph.dag, STREAMS, (JOBS, PERIOD_NS), |_| {
        let stamp = module.kernel(c"stamp", [1; 3], [1; 3])?;
        let (mut arguments, address, takes_ns) =
            (Arguments::new(2), places.address(), graph.takes_ns.clone());
        Ok(Box::new(move |work, stream| {
            let (job, node) = (work.job as usize, work.node.index());
            arguments.set(0, address + ((job * nodes + node) * STAMP) as u64);
            arguments.set(1, takes_ns[node].unwrap_or(0));
            Ok(stream.launch(&stamp, &mut arguments)?)
        }))
    })?;
    stream.download(&places, &mut seen)?;
    bench.device.synchronize()?;
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte));
    let stamp = |(at, bytes): (usize, &[u8])| {
        graph.takes_ns[at % nodes].map(|_| (number(&bytes[..8]), number(&bytes[8..])))
    };
    let stamps: Vec<_> = seen.bytes().chunks_exact(STAMP).enumerate().map(stamp).collect();
    Ok((ran, stamps.chunks_exact(nodes).map(<[_]>::to_vec).collect()))
}

/// How many edges between kernels there were.
fn judge(graph: &Graph, stamps: &Stamps) -> Result<usize, Failure> {
    let mut held = 0;
    for (job, stamps) in stamps.iter().enumerate() {
        if let Some(node) =
            stamps.iter().position(|stamp| matches!(stamp, Some((begin, end)) if *begin == 0 || end < begin))
        {
            return Err(format!("job {job}: the kernel of node {node} did not run to its end").into());
        }
        for (from, to) in &graph.edges {
            let (Some((_, end)), Some((begin, _))) = (stamps[*from], stamps[*to]) else { continue };
            if begin < end {
                let early = end - begin;
                return Err(
                    format!("job {job}: node {to} begins {early} ns before the end of node {from}").into()
                );
            }
            held += 1;
        }
    }
    Ok(held)
}

pub(crate) fn check(bench: &Bench) -> Result<Figures, Failure> {
    let (mut edges, mut ahead, mut issued, mut avoided) = (0, 0, 0, 0);
    let mut denied = None;
    for seed in 1..=GRAPHS {
        let graph = random(seed)?;
        let (ran, stamps) = stamped(bench, &graph)?;
        if ran.ends.given_up > 0 {
            return Err(format!("graph {seed}: {} of {JOBS} jobs were given up", ran.ends.given_up).into());
        }
        edges += judge(&graph, &stamps).map_err(|why| format!("graph {seed}, {why}"))?;
        ahead += ran.ahead;
        issued += ran.streams.event_waits_issued;
        avoided += ran.streams.event_waits_avoided;
        denied = ran.denied;
    }
    if ahead == 0 || issued == 0 {
        return Err("nothing was submitted ahead, or no stream waited for another: nothing was shown".into());
    }
    let mut figures = vec![
        format!("{} graphs, {edges} edges between kernels: each held", GRAPHS as usize * JOBS),
        format!("{ahead} submissions ahead, {issued} event waits issued, {avoided} avoided"),
    ];
    figures.extend(denied.map(|why| format!("best effort: {why}")));
    Ok(figures)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_that_begins_early_and_one_that_does_not_end_are_seen() {
        let graph = Graph { dag: Dag::new(), takes_ns: vec![Some(1); 2], edges: vec![(0, 1)] };
        let judged = |second| judge(&graph, &vec![vec![Some((5, 9)), second]]).map_err(|why| why.to_string());
        assert_eq!(judged(Some((9, 12))), Ok(1));
        assert_eq!(judged(Some((8, 12))), Err("job 0: node 1 begins 1 ns before the end of node 0".into()));
        assert_eq!(judged(Some((9, 0))), Err("job 0: the kernel of node 1 did not run to its end".into()));
    }
}
