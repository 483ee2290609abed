//! What a graph says of itself.

use std::io;

use red_core::{
    Bytes, Capacity, Dag, DeadlineRule, Duration, Levels, NodeId, SubDeadlines, response_time, shares,
};

use crate::host::Host;
use crate::text::node;
use crate::words::certificate;

impl<C: Capacity> Host<'_, C> {
    pub(crate) fn ask(&mut self, dag: &Dag<C>, deadline: Duration) -> io::Result<()> {
        let (rule, lanes, levels) = (self.core.config().rule, &self.lanes, Levels::of(dag));
        let (work, path) = (dag.work(), levels.critical_path());
        writeln!(self.out, "graph {} {} {work} {path}", dag.len(), levels.count())?;
        let due = SubDeadlines::assign(&levels, rule, deadline, lanes);
        for id in dag.nodes() {
            let of = dag.node(id).map_or_else(String::new, node);
            let successors: String = dag.successors(id).iter().map(|to| format!(" {to}")).collect();
            let (number, height, tail) = (NodeId::index(id), levels.height(id), levels.tail(id));
            let (sub, key) = (due.sub_deadline(id), due.key(id));
            writeln!(self.out, "has {number} {of} before{successors} at {height} {tail} {sub} {key}")?;
        }
        for rule in [DeadlineRule::LevelSum, DeadlineRule::LevelGraham] {
            let shares = shares(&levels, rule, deadline, lanes);
            for level in shares.as_ref().iter().take(levels.count()) {
                writeln!(self.out, "level {} {} {} {}", level.cost, level.graham, level.share, level.end)?;
            }
        }
        let budgets: Vec<_> = [self.script.config.memory]
            .into_iter()
            .chain(self.script.pools.iter().map(|(_, memory)| *memory))
            .take(lanes.len())
            .collect::<Vec<Option<Bytes>>>();
        let proof = response_time(&levels, deadline, lanes, &budgets);
        writeln!(self.out, "alone {}", certificate(&proof))
    }
}
