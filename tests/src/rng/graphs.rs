//! Random nodes: layered or Erdos-Renyi graphs with stages, markers and atomic nodes in them.

use red_workload::model::{Body, Node, Part, Stage, Work};

use super::{Rng, Shape};

pub(super) const MIB: u64 = 1 << 20;

/// What the tasks of one workload share: weights, each with its encoder, and frames.
pub(super) struct Names {
    encoders: Vec<Part>,
    pools: usize,
    zero_costs: bool,
}

impl Names {
    pub(super) fn new(rng: &mut Rng, pools: usize) -> Self {
        let mut names = Self { encoders: Vec::new(), pools, zero_costs: false };
        for _ in 0..3 {
            let mut encoder = part(rng, &names);
            encoder.wcet_ns *= 3;
            names.encoders.push(encoder);
        }
        names
    }
}

/// The nodes of one task. Edges go from earlier to later nodes.
pub(super) fn nodes(rng: &mut Rng, shape: &Shape, names: &Names) -> Vec<Node> {
    let names = Names { encoders: names.encoders.clone(), pools: names.pools, zero_costs: shape.zero_costs };
    let count = if rng.chance(30) { rng.within(1, 3.min(shape.nodes)) } else { rng.within(1, shape.nodes) };
    let works = (0..count)
        .map(|_| if shape.stages && rng.chance(20) { stage(rng, &names) } else { plain(rng, &names) });
    let mut nodes: Vec<Node> = works
        .enumerate()
        .map(|(index, work)| Node { name: format!("n{index}"), after: Vec::new(), before: Vec::new(), work })
        .collect();
    let layered = rng.chance(50);
    let width = rng.within(1, 8) as usize;
    let density = rng.within(5, 40);
    for to in 1..nodes.len() {
        let from: Vec<usize> = if layered {
            let layer = to / width;
            (0..to).filter(|&from| from / width + 1 == layer).filter(|_| rng.chance(50)).collect()
        } else {
            (0..to).filter(|_| rng.chance(density)).collect()
        };
        for from in from {
            let reference = reference(rng, &nodes[from], 30);
            nodes[to].after.push(reference);
        }
    }
    nodes
}

/// One or two nodes that an event adds, between nodes of `base`.
pub(super) fn added_nodes(rng: &mut Rng, names: &Names, base: &[Node], round: u64) -> Vec<Node> {
    let mut added = Vec::new();
    for index in 0..rng.within(1, 2) {
        let work = if rng.chance(25) { stage(rng, names) } else { plain(rng, names) };
        let mut node =
            Node { name: format!("e{round}-{index}"), after: Vec::new(), before: Vec::new(), work };
        let split = rng.index(base.len());
        if split > 0 && rng.chance(80) {
            let from = rng.index(split);
            node.after.push(reference(rng, &base[from], 30));
        }
        if rng.chance(60) {
            node.before.push(reference(rng, &base[split], 70));
        }
        added.push(node);
    }
    added
}

/// The node, or in `percent` of the cases one decoder of a stage.
fn reference(rng: &mut Rng, node: &Node, percent: u64) -> String {
    match &node.work {
        Work::Stage(stage) if rng.chance(percent) => {
            let decoder = &stage.decoders[rng.index(stage.decoders.len())].0;
            format!("{}.{decoder}", node.name)
        }
        Work::Plain(_) | Work::Stage(_) => node.name.clone(),
    }
}

fn plain(rng: &mut Rng, names: &Names) -> Work {
    Work::Plain(part(rng, names))
}

fn stage(rng: &mut Rng, names: &Names) -> Work {
    let weights = rng.index(names.encoders.len());
    let mut encoder = names.encoders[weights].clone();
    // Who shares an encoder may give it another cost, a little or much smaller.
    if rng.chance(15) {
        encoder.wcet_ns += rng.within(1, 500) * 1_000;
    } else if rng.chance(15) {
        encoder.wcet_ns /= rng.within(2, 6);
    }
    let decoder = |rng: &mut Rng, index: u64| {
        let mut part = part(rng, names);
        if rng.chance(85) {
            part.pool = encoder.pool;
        }
        (format!("d{index}"), part)
    };
    let frame = if rng.chance(70) { "front" } else { "rear" };
    let count = rng.within(1, 3);
    let decoders = (0..count).map(|index| decoder(rng, index)).collect();
    Work::Stage(Stage { weights: format!("w{weights}"), frame: frame.to_owned(), encoder, decoders })
}

fn part(rng: &mut Rng, names: &Names) -> Part {
    let heavy = if rng.chance(10) { 4 } else { 1 };
    let wcet_ns = if names.zero_costs && rng.chance(8) {
        0
    } else if rng.chance(30) {
        // Round costs make completions coincide.
        rng.within(1, 4) * 500_000 * heavy
    } else {
        rng.within(50_000, 2_000_000) * heavy
    };
    let atomic = rng.chance(20);
    Part {
        wcet_ns,
        bcet_ns: wcet_ns / 2,
        body: Body::None,
        pool: rng.index(names.pools),
        memory_bytes: if rng.chance(30) { 0 } else { rng.within(1, 32) * MIB },
        atomic,
        contention_ns: if atomic { rng.within(0, 500) * 1_000 } else { 0 },
    }
}
