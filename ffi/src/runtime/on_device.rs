//! Lanes that are streams of a CUDA device.

use super::bodies::{Bodies, Calls};
use red_core::PoolId;
use red_rt::cuda::{self, Cuda, CudaUnavailable, Device, Handlers, LANES};
use red_rt::utilisation::{self, Utilisation};
use std::path::Path;
use std::sync::Arc;

/// The CUDA device of a runtime.
#[derive(Clone)]
pub(crate) struct OnDevice {
    pub(crate) ordinal: i32,
    device: Device,
    /// Lanes that are streams of it, a bit each.
    pub(crate) lanes: u32,
    pub(crate) pools: Vec<PoolId>,
}

impl OnDevice {
    /// Loads the driver, and opens a device by its number.
    pub(super) fn open(ordinal: i32) -> Result<Self, CudaUnavailable> {
        Ok(Self { ordinal, device: cuda::open(ordinal)?, lanes: 0, pools: Vec::new() })
    }

    /// The streams, and what gives them their work: before lanes have threads.
    pub(super) fn streams(&self, bodies: &Arc<Bodies>) -> Result<(Cuda, Handlers), CudaUnavailable> {
        let cuda = Cuda::new(self.device.clone(), self.lanes)?;
        let is_stream = |lane: &usize| self.lanes >> lane & 1 != 0;
        let of_lane = |lane| (lane, Box::new(Calls::new(bodies.clone())) as Box<dyn cuda::Bodies>);
        let handlers = cuda.handlers((0..LANES).filter(is_stream).map(of_lane))?;
        Ok((cuda, handlers))
    }

    /// What knows how much the device is used, also by others, and the pools that it is told of. To be asked for before
    /// the run.
    pub(super) fn utilisation(self) -> Option<(Vec<PoolId>, Box<dyn Utilisation>)> {
        Some((self.pools, utilisation::of_device(&self.device, Path::new("/"))?))
    }
}
