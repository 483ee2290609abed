//! Streams to measure the nodes of CUDA pools on.

use super::runner::{OnStream, Runner};
use crate::session::SessionError;
use crate::session::cuda::{CudaPools, is_cuda};
use red_bodies::plugin::Host as PluginHost;
use red_workload::Source;
use red_workload::build::Numbered;
use red_workload::model::MAX_LANES;
use std::sync::Arc;

/// Streams of a pool, at least, to see how far its nodes run beside each other.
const FEWEST: u32 = 4;

/// The workload with as many lanes in CUDA pools as are measured.
pub(super) fn widened(source: &Source) -> Source {
    let mut wide = source.clone();
    for pool in 0..wide.workload.pools.len() {
        let others: u32 = wide.workload.pools.iter().map(|pool| pool.lanes).sum();
        let of_pool = wide.workload.pools[pool].lanes;
        if is_cuda(&source.workload, pool) {
            let room = MAX_LANES.saturating_sub(others - of_pool);
            wide.workload.pools[pool].lanes = of_pool.max(FEWEST.min(room));
        }
    }
    wide
}

/// Who runs the nodes of each stream, in the order of the pools.
///
/// # Errors
/// [`SessionError`]: a body cannot run, or the driver refuses.
pub(super) fn runners(
    cuda: &CudaPools,
    source: &Source,
    nodes: &[Vec<Numbered>],
    host: &Arc<PluginHost>,
) -> Result<Vec<Runner>, SessionError> {
    let runner = |(_, bodies)| {
        let (device, stream) = cuda.stream()?;
        let on = OnStream::new(device, stream, bodies).map_err(|error| cuda.refused(error))?;
        Ok(Runner::Stream(on))
    };
    cuda.load(source, nodes, host, None)?.into_iter().map(runner).collect()
}
