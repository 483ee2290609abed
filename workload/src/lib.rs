//! Workload files, metrics and the JSON of `redrt`.

pub mod model;
