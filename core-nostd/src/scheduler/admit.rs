//! What a graph must satisfy to be admitted, and what can be proved about it.

use super::Scheduler;
use super::tasks::{AddTaskError, Timing};
use crate::analysis::{Certificate, response_time};
use crate::capacity::{Capacity, Empty};
use crate::config::Admission;
use crate::graph::{Levels, Role};
use crate::time::{Bytes, Duration};

impl<C: Capacity> Scheduler<C> {
    /// Refuses a graph that could never run here, and one that does not fit where that is enforced.
    pub(super) fn admit(&self, levels: &Levels<'_, C>, timing: &Timing) -> Result<Certificate, AddTaskError> {
        let dag = levels.dag;
        if dag.is_empty() {
            return Err(AddTaskError::Empty);
        }
        for place in levels.places() {
            let node = dag.at(place);
            if node.pool.index() >= usize::from(self.pool_count) {
                return Err(AddTaskError::UnknownPool);
            }
            let mut needed = node.memory.0;
            if let Role::SharedEncoder(frame) = node.role {
                let period = frame.sensor.map(|sensor| self.sensors.as_ref().get(sensor.index()));
                if matches!(period, Some(None | Some(&Duration::ZERO))) {
                    return Err(AddTaskError::UnknownSensor);
                }
                let readers = dag.out(place).iter().map(|reader| dag.at(reader));
                let beside =
                    readers.filter(|reader| reader.role == Role::Decoder && reader.pool == node.pool);
                needed = needed.saturating_add(beside.map(|reader| reader.memory.0).max().unwrap_or(0));
            }
            if needed > self.pools[node.pool.index()].budget {
                return Err(AddTaskError::Memory);
            }
        }
        let proof = self.prove(levels, timing);
        let refused = self.config.admission == Admission::Enforce && !proof.fits();
        if refused { Err(AddTaskError::Unschedulable) } else { Ok(proof) }
    }

    pub(super) fn prove(&self, levels: &Levels<'_, C>, timing: &Timing) -> Certificate {
        let mut budgets = <C::Pools<Option<Bytes>>>::EMPTY;
        (0..C::POOLS).for_each(|p| budgets[p] = self.pools[p].limited.then_some(Bytes(self.pools[p].budget)));
        let limit = timing.period.map_or(timing.deadline, |t| t.min(timing.deadline));
        response_time(levels, limit, self.lanes_by_pool().as_ref(), budgets.as_ref())
    }

    pub(super) fn lanes_by_pool(&self) -> C::Pools<u8> {
        let mut lanes = <C::Pools<u8>>::EMPTY;
        (0..C::POOLS).for_each(|p| lanes[p] = self.pools[p].lanes.count_ones() as u8);
        lanes
    }
}
