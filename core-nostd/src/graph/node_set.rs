//! A set of nodes, or of ranks: one bit each, in a few 64-bit words. Hot paths touch single words: a wide load
//! after a narrow store stalls the store buffer.

use crate::capacity::{Capacity, Empty};

/// A set of small integers below `C::NODES`.
#[derive(Clone, Copy, Debug)]
pub struct NodeSet<C: Capacity>(C::Words);

impl<C: Capacity> NodeSet<C> {
    const WORDS: usize = C::NODES.div_ceil(64);

    /// Adds `i`.
    pub fn insert(&mut self, i: usize) {
        self.0[i / 64] |= 1 << (i % 64);
    }

    /// Adds `i` where `is` holds, without a branch: for loops in which that cannot be predicted.
    pub(crate) fn insert_if(&mut self, i: usize, is: bool) {
        self.0[i / 64] |= u64::from(is) << (i % 64);
    }

    /// Takes `i` out.
    #[inline(always)]
    pub fn remove(&mut self, i: usize) {
        self.0[i / 64] &= !(1 << (i % 64));
    }

    /// Whether `i` is in.
    pub fn contains(&self, i: usize) -> bool {
        self.0[i / 64] >> (i % 64) & 1 != 0
    }

    /// Whether nothing is in.
    pub fn is_empty(&self) -> bool {
        self.0.as_ref().iter().all(|w| *w == 0)
    }

    /// How many are in.
    pub fn len(&self) -> usize {
        self.0.as_ref().iter().map(|w| w.count_ones() as usize).sum()
    }

    /// The smallest element that is also in `mask`.
    pub fn first_in(&self, mask: &Self) -> Option<usize> {
        (0..Self::WORDS).find_map(|w| bits(self.0[w] & mask.0[w]).next().map(|bit| w * 64 + bit))
    }

    /// The elements of both.
    pub fn and(&self, other: &Self) -> Self {
        self.by_words(other, |own, other| own & other)
    }

    /// The elements that are not in `other`.
    pub fn without(&self, other: &Self) -> Self {
        self.by_words(other, |own, other| own & !other)
    }

    /// Adds all of `other`.
    pub fn extend(&mut self, other: &Self) {
        *self = self.by_words(other, |own, other| own | other);
    }

    fn by_words(mut self, other: &Self, f: impl Fn(u64, u64) -> u64) -> Self {
        (0..Self::WORDS).for_each(|w| self.0[w] = f(self.0[w], other.0[w]));
        self
    }

    /// Calls `f` for each element, smallest first.
    #[inline(always)]
    pub fn each(&self, mut f: impl FnMut(usize)) {
        (0..Self::WORDS).for_each(|w| bits(self.0[w]).for_each(|bit| f(w * 64 + bit)));
    }

    /// The largest of the elements' values; 0 for the empty set.
    pub(crate) fn largest(&self, of: &C::Nodes<u64>) -> u64 {
        let mut largest = 0;
        self.each(|i| largest = largest.max(of[i]));
        largest
    }

    /// The elements, smallest first.
    pub fn iter(&self) -> impl Iterator<Item = usize> + use<C> {
        let mut rest = *self;
        core::iter::from_fn(move || {
            let i = rest.first_in(&rest)?;
            rest.remove(i);
            Some(i)
        })
    }
}

/// Numbers of the bits that are set, lowest first.
pub(crate) fn bits(mut mask: u64) -> impl Iterator<Item = usize> + Clone {
    core::iter::from_fn(move || {
        let bit = mask.trailing_zeros() as usize;
        (mask != 0).then(|| {
            mask &= mask - 1;
            bit
        })
    })
}

/// Of the bits that are set, some.
pub(crate) fn those(mask: u64, wanted: impl FnMut(&usize) -> bool) -> u64 {
    bits(mask).filter(wanted).fold(0, |set, bit| set | 1 << bit)
}

impl<C: Capacity> Empty for NodeSet<C> {
    const EMPTY: Self = Self(C::Words::EMPTY);
}
