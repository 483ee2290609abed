//! What a graph must satisfy to be admitted, and what can be proved about it.

use super::Scheduler;
use super::tasks::AddTaskError;
use crate::analysis::Certificate;
use crate::analysis::response_time::bound_by_levels;
use crate::capacity::{Capacity, Empty};
use crate::graph::{Dag, Levels, Node, Role};
use crate::time::{Bytes, Duration};

impl<C: Capacity> Scheduler<C> {
    pub(super) fn prove(
        &self,
        dag: &Dag<C>,
        levels: &Levels<C>,
        deadline: Duration,
        period: Option<Duration>,
    ) -> Certificate {
        let mut budgets = <C::Pools<Option<Bytes>>>::EMPTY;
        for p in 0..usize::from(self.pool_count) {
            budgets[p] = self.pools[p].limited.then_some(Bytes(self.pools[p].budget));
        }
        let limit = period.map_or(deadline, |t| t.min(deadline));
        bound_by_levels(dag, levels, limit, &self.lanes_by_pool(), budgets.as_ref())
    }

    pub(super) fn lanes_by_pool(&self) -> [u8; 32] {
        let mut lanes = [1; 32];
        for (p, m) in lanes.iter_mut().enumerate().take(usize::from(self.pool_count)) {
            *m = self.pools[p].lanes.count_ones() as u8;
        }
        lanes
    }

    pub(super) fn check_graph(&self, dag: &Dag<C>) -> Result<(), AddTaskError> {
        if dag.is_empty() {
            return Err(AddTaskError::Empty);
        }
        let budget = |node: &Node| self.pools[node.pool.index()].budget;
        for id in dag.nodes() {
            let node = dag.at(id.index());
            if node.pool.index() >= usize::from(self.pool_count) {
                return Err(AddTaskError::UnknownPool);
            }
            let mut with_decoder = node.memory.0;
            if matches!(node.role, Role::SharedEncoder(_)) {
                dag.out(id.index()).each(|d| {
                    let decoder = dag.at(d);
                    if decoder.role == Role::Decoder && decoder.pool == node.pool {
                        with_decoder = with_decoder.max(node.memory.0.saturating_add(decoder.memory.0));
                    }
                });
            }
            if with_decoder > budget(node) {
                return Err(AddTaskError::Memory);
            }
        }
        Ok(())
    }
}
