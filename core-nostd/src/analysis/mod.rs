//! Admission: what can be said before a task runs. Takes WCET and contention, never an estimate.

pub(crate) mod certificate;
pub(crate) mod response_time;

pub use certificate::{Bound, Certificate};
pub use response_time::response_time;
