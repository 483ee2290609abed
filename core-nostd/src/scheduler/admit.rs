//! What a graph must satisfy to be admitted, and what can be proved about it.

use super::Scheduler;
use super::tasks::{AddTaskError, Timing};
use crate::analysis::{Bound, Certificate, response_time};
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
        let limit = timing.period().map_or(timing.deadline, |t| t.min(timing.deadline));
        let lanes = self.lanes_by_pool();
        let proof = response_time(levels, limit, lanes.as_ref(), budgets.as_ref());
        let is_ahead = self.pools.as_ref().iter().any(|pool| pool.ahead);
        if is_ahead { self.held_lanes(levels, proof, lanes) } else { proof }
    }

    /// The certificate where lanes may wait: each node adds the longest of its predecessors to the work of its pool.
    fn held_lanes(&self, levels: &Levels<'_, C>, mut proof: Certificate, lanes: C::Pools<u8>) -> Certificate {
        let (mut held, mut before) = (<C::Pools<u64>>::EMPTY, <C::Nodes<u64>>::EMPTY);
        for place in levels.places() {
            let node = levels.dag.at(place);
            let pool = node.pool.index();
            let own = if self.pools[pool].ahead { before[place] } else { 0 };
            held[pool] = held[pool].saturating_add(own);
            let same = |after: &usize| levels.dag.at(*after).pool == node.pool;
            let after = levels.dag.out(place).iter().filter(same);
            after.for_each(|after| before[after] = before[after].max(node.cost()));
        }
        let share = |pool: usize| held[pool].div_ceil(lanes[pool].max(1).into());
        let more = (0..C::POOLS).map(share).fold(0, u64::saturating_add);
        if more > 0 && matches!(proof.bound, Bound::LongPath { .. }) {
            // That counts on lanes that work.
            let rest = proof.work.as_nanos() - proof.critical_path.as_nanos();
            let graham = proof.critical_path.as_nanos() + rest.div_ceil(proof.lanes.max(1).into());
            (proof.bound, proof.response) = (Bound::Graham, Duration::from_nanos(graham));
        }
        proof.response = Duration::from_nanos(proof.response.as_nanos().saturating_add(more));
        proof
    }

    pub(super) fn lanes_by_pool(&self) -> C::Pools<u8> {
        let mut lanes = <C::Pools<u8>>::EMPTY;
        (0..C::POOLS).for_each(|p| lanes[p] = self.pools[p].lanes.count_ones() as u8);
        lanes
    }
}
