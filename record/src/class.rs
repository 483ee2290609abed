//! The capacities of hosts that set their schedulers up by calls. Capacities are types, so a program has to know those
//! of the logs that it replays: these few are enough. They are the classes of the C ABI; how many events a scheduler keeps
//! decides nothing, and another number there is the same class.

use crate::header::Header;
use red_core::{Capacity, Caps};

/// 4 tasks of 16 nodes, 16 jobs, 4 lanes in 2 pools.
pub type Small = Caps<4, 16, 16, 4, 2, 1, 64>;
/// 8 tasks of 64 nodes, 32 jobs, 8 lanes in 4 pools.
pub type Medium = Caps<8, 64, 32, 8, 4, 1, 256>;
/// 16 tasks of 256 nodes, 64 jobs, 32 lanes in 32 pools.
pub type Large = Caps<16, 256, 64, 32, 32, 4, 1024>;

/// What can be done with a scheduler of any class.
pub trait ForClass {
    /// What comes of it.
    type Output;

    /// Does it with this one.
    fn with<C: Capacity>(self) -> Self::Output;
}

macro_rules! classes {
    ($($class:ident)*) => {
        /// The capacities of all classes, as headers have them.
        pub const ALL: &[[usize; 5]] = &[$(Header::capacities_of::<$class>()),*];

        /// Does it with the class that has these capacities. `None`: no class has.
        pub fn with_class<F: ForClass>(capacities: [usize; 5], it: F) -> Option<F::Output> {
            $(if capacities == Header::capacities_of::<$class>() {
                return Some(it.with::<$class>());
            })*
            None
        }
    };
}
classes! { Small Medium Large }
