//! Layer 1: graphs of nodes. A [`Dag`] is acyclic because `add_edge` refuses, not because someone checked.

pub(crate) mod dag;
pub(crate) mod levels;
pub(crate) mod node;
pub(crate) mod node_set;
pub(crate) mod refine;

pub use dag::{Dag, EdgeError, NodeError};
pub use levels::Levels;
pub use node::{Frame, Node, Role};
pub use node_set::NodeSet;
pub use refine::{RefineError, Refined, refine};
