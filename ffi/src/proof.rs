//! Certificates.

use crate::boundary::{Growing, plain};

/// Which bound a certificate rests on.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_bound {
    /// Graham 1969: L + ceil((W - L) / m).
    Graham = 0,
    /// Long path: L + ceil((W - paths) / (m - j)), with j paths peeled.
    LongPath = 1,
    /// Nodes in several pools.
    SeveralPools = 2,
}

/// A bound on the response time of a job that has its pools to itself.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_certificate {
    /// RED_CERTIFICATE_INIT sets it.
    pub struct_size: u32,
    /// RED_CERTIFICATE_INIT sets it.
    pub abi_version: u32,
    /// One of red_bound.
    pub bound: u32,
    /// Of RED_BOUND_LONG_PATH: j.
    pub paths: u32,
    /// Lanes of the task's pool; the largest number where it uses several.
    pub lanes: u32,
    /// 1: the bound is met. 0: not.
    pub fits: u32,
    /// 1: memory cannot make a ready node wait. 0: it can, and the bound is not sufficient.
    pub memory_holds: u32,
    /// 0.
    pub reserved: u32,
    /// W: sum of all costs.
    pub work_ns: u64,
    /// L: cost of the critical path.
    pub critical_path_ns: u64,
    /// The bound's value.
    pub response_ns: u64,
    /// What it must not exceed: min(deadline, period).
    pub limit_ns: u64,
    /// limit_ns less response_ns.
    pub margin_ns: i64,
}
plain!(red_certificate {
    struct_size: u32,
    abi_version: u32,
    bound: u32,
    paths: u32,
    lanes: u32,
    fits: u32,
    memory_holds: u32,
    reserved: u32,
    work_ns: u64,
    critical_path_ns: u64,
    response_ns: u64,
    limit_ns: u64,
    margin_ns: i64,
});
impl Growing for red_certificate {
    const LEAST: usize = 72;
}

impl From<red_core::Certificate> for red_certificate {
    fn from(proof: red_core::Certificate) -> Self {
        let (bound, paths) = match proof.bound {
            red_core::Bound::LongPath { paths } => (red_bound::LongPath, paths.into()),
            red_core::Bound::SeveralPools => (red_bound::SeveralPools, 0),
            _ => (red_bound::Graham, 0),
        };
        Self {
            struct_size: 0,
            abi_version: 0,
            bound: bound as u32,
            paths,
            lanes: proof.lanes.into(),
            fits: proof.fits().into(),
            memory_holds: proof.memory_holds.into(),
            reserved: 0,
            work_ns: proof.work.as_nanos(),
            critical_path_ns: proof.critical_path.as_nanos(),
            response_ns: proof.response.as_nanos(),
            limit_ns: proof.limit.as_nanos(),
            margin_ns: proof.margin().as_nanos(),
        }
    }
}
