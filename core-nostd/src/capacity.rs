//! Capacities: the only place with numbers. Everything that the executive stores has its place from the start;
//! [`Caps`] says how many places. Tables mask or clamp their index, so that an access compiles without a branch to
//! a panic; an index outside is a bug of this crate, and the debug build stops at it.

use core::ops::{Index, IndexMut};

/// A value of all-zero bits, so that a `static` of a whole scheduler lies in `.bss`.
pub trait Empty {
    /// Nothing.
    const EMPTY: Self;
}

macro_rules! empty {
    ($($t:ty = $zero:expr),*) => { $(impl $crate::capacity::Empty for $t { const EMPTY: Self = $zero; })* };
}
empty!(u8 = 0, u16 = 0, u32 = 0, u64 = 0, i64 = 0, u128 = 0, bool = false);

/// Defines a struct that is empty when all its fields are.
macro_rules! stored {
    ($(#[$meta:meta])* $vis:vis struct $name:ident $(<$g:ident: $bound:path>)? {
        $($(#[$field_meta:meta])* $field_vis:vis $field:ident: $t:ty,)*
    }) => {
        $(#[$meta])*
        $vis struct $name $(<$g: $bound>)? { $($(#[$field_meta])* $field_vis $field: $t,)* }
        impl $(<$g: $bound>)? $crate::capacity::Empty for $name $(<$g>)? {
            const EMPTY: Self = Self { $($field: <$t as $crate::capacity::Empty>::EMPTY,)* };
        }
    };
}

/// Defines numbers of one kind each: mixing two does not compile.
macro_rules! numbers {
    ($($(#[$meta:meta])* pub struct $name:ident($vis:vis $int:ty);)*) => { $(
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        $(#[$meta])* pub struct $name($vis $int);
        $crate::capacity::empty!($name = Self(0));
    )* };
}

/// Defines plain values. A struct is empty when all its fields are, an enum at its first variant.
macro_rules! values {
    (@empty struct $name:ident { $($(#[$meta:meta])* $vis:vis $field:ident: $t:ty,)* }) => {
        $crate::capacity::empty!($name = Self { $($field: <$t as $crate::capacity::Empty>::EMPTY,)* });
    };
    (@empty enum $name:ident { $(#[$meta:meta])* $first:ident $($more:tt)* }) => {
        $crate::capacity::empty!($name = Self::$first);
    };
    ($($(#[$meta:meta])* $vis:vis $kind:ident $name:ident $body:tt)*) => { $(
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        $(#[$meta])* $vis $kind $name $body
        $crate::capacity::values!(@empty $kind $name $body);
    )* };
}
pub(crate) use {empty, numbers, stored, values};

impl<T> Empty for Option<T> {
    const EMPTY: Self = None;
}

impl<T: Empty, const N: usize> Empty for [T; N] {
    const EMPTY: Self = [T::EMPTY; N];
}

/// An array whose index never panics: masked where the length is a power of two, else clamped to the last place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Table<T, const N: usize>([T; N]);

impl<T: Empty, const N: usize> Empty for Table<T, N> {
    const EMPTY: Self = Self(Empty::EMPTY);
}

impl<T, const N: usize> Table<T, N> {
    /// `i`, made one of the places.
    fn inside(i: usize) -> usize {
        debug_assert!(i < N, "index inside the capacity");
        if N.is_power_of_two() { i & (N - 1) } else { i.min(N - 1) }
    }
}

impl<T, const N: usize> Index<usize> for Table<T, N> {
    type Output = T;
    fn index(&self, i: usize) -> &T {
        const { assert!(N >= 1, "a capacity is at least 1") };
        &self.0[Self::inside(i)]
    }
}

impl<T, const N: usize> IndexMut<usize> for Table<T, N> {
    fn index_mut(&mut self, i: usize) -> &mut T {
        &mut self.0[Self::inside(i)]
    }
}

impl<T, const N: usize> AsRef<[T]> for Table<T, N> {
    fn as_ref(&self) -> &[T] {
        &self.0
    }
}

impl<T, const N: usize> AsMut<[T]> for Table<T, N> {
    fn as_mut(&mut self) -> &mut [T] {
        &mut self.0
    }
}

/// What every table can do.
pub trait Store<T>: Item + IndexMut<usize, Output = T> + AsRef<[T]> + AsMut<[T]> {}
impl<T: Item, const N: usize> Store<T> for Table<T, N> {}

/// What a table can hold.
pub trait Item: Copy + Empty + core::fmt::Debug + Send + Sync + 'static {}
impl<T: Copy + Empty + core::fmt::Debug + Send + Sync + 'static> Item for T {}

/// How many of everything; implemented by [`Caps`] alone.
pub trait Capacity: Copy + core::fmt::Debug + Send + Sync + 'static {
    /// Tasks.
    const TASKS: usize;
    /// Nodes of one task's graph, all versions together.
    const NODES: usize;
    /// Jobs in flight, all tasks together; at most 64.
    const JOBS: usize;
    /// Lanes over all pools; at most 32.
    const LANES: usize;
    /// Pools; at most 32.
    const POOLS: usize;
    /// Events that the record keeps until the host takes them; 0 switches the record off at compile time.
    const EVENTS: usize;
    /// One per task.
    type Tasks<T: Item>: Store<T>;
    /// One per node.
    type Nodes<T: Item>: Store<T>;
    /// One per job.
    type Jobs<T: Item>: Store<T>;
    /// One per lane.
    type Lanes<T: Item>: Store<T>;
    /// One per pool.
    type Pools<T: Item>: Store<T>;
    /// One word per 64 nodes.
    type Words: Store<u64>;
    /// The event ring.
    type Events<T: Item>: Item + AsRef<[T]> + AsMut<[T]>;
}

/// The capacities of one scheduler, in its type.
///
/// `WORDS` is `NODES.div_ceil(64)`: a set of nodes is that many 64-bit words. Powers of two are fastest.
///
/// ```
/// use red_core::{Caps, Scheduler};
/// type Robot = Caps<4, 16, 16>;                         // 4 tasks of 16 nodes, 16 jobs in flight, 4 lanes, 1 pool
/// type Lab = Caps<16, 256, 64, 32, 32, 4, 1024>;        // 32 lanes and pools, 4 words, 1,024 events
/// assert!(Scheduler::<Robot>::SIZE <= 12 * 1024);
/// assert!(Scheduler::<Lab>::SIZE > Scheduler::<Robot>::SIZE);
/// ```
///
/// A size that does not fit stops the build:
/// ```compile_fail
/// type TooMany = red_core::Caps<1, 65, 1>;              // 65 nodes need WORDS = 2
/// let scheduler = red_core::Scheduler::<TooMany>::new(red_core::Config::REDRT);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Caps<
    const TASKS: usize,
    const NODES: usize,
    const JOBS: usize,
    const LANES: usize = 4,
    const POOLS: usize = 1,
    const WORDS: usize = 1,
    const EVENTS: usize = 0,
>;

/// `n`, or no build.
const fn within(n: usize, most: usize, rule: &str) -> usize {
    assert!(n >= 1 && n <= most, "{}", rule);
    n
}

impl<
    const TASKS: usize,
    const NODES: usize,
    const JOBS: usize,
    const LANES: usize,
    const POOLS: usize,
    const WORDS: usize,
    const EVENTS: usize,
> Capacity for Caps<TASKS, NODES, JOBS, LANES, POOLS, WORDS, EVENTS>
{
    const TASKS: usize = within(TASKS, 255, "TASKS is 1 to 255");
    const NODES: usize = {
        assert!(WORDS == NODES.div_ceil(64), "WORDS is NODES.div_ceil(64)");
        within(NODES, 256, "NODES is 1 to 256")
    };
    const JOBS: usize = within(JOBS, 64, "JOBS is 1 to 64");
    const LANES: usize = within(LANES, 32, "LANES is 1 to 32");
    const POOLS: usize = within(POOLS, 32, "POOLS is 1 to 32");
    const EVENTS: usize = EVENTS;
    type Tasks<T: Item> = Table<T, TASKS>;
    type Nodes<T: Item> = Table<T, NODES>;
    type Jobs<T: Item> = Table<T, JOBS>;
    type Lanes<T: Item> = Table<T, LANES>;
    type Pools<T: Item> = Table<T, POOLS>;
    type Words = Table<u64, WORDS>;
    type Events<T: Item> = Table<T, EVENTS>;
}
