//! A set of nodes, or of ranks: one bit each, in a few 64-bit words.
//!
//! Hot paths touch single words: a wide load after a narrow store stalls the store buffer.

use crate::capacity::{Capacity, Empty};

/// A set of small integers below `C::NODES`.
#[derive(Clone, Copy, Debug)]
pub struct NodeSet<C: Capacity>(C::Words);

impl<C: Capacity> NodeSet<C> {
    const WORDS: usize = C::NODES.div_ceil(64);

    /// The set of one element.
    pub fn only(i: usize) -> Self {
        let mut set = Self::EMPTY;
        set.insert(i);
        set
    }

    /// Adds `i`.
    #[inline(always)]
    pub fn insert(&mut self, i: usize) {
        self.0[i / 64] |= 1 << (i % 64);
    }

    /// Adds `i` where `is` holds, without a branch: for loops in which that cannot be predicted.
    #[inline(always)]
    pub(crate) fn insert_if(&mut self, i: usize, is: bool) {
        self.0[i / 64] |= u64::from(is) << (i % 64);
    }

    /// Takes `i` out.
    #[inline(always)]
    pub fn remove(&mut self, i: usize) {
        self.0[i / 64] &= !(1 << (i % 64));
    }

    /// Whether `i` is in.
    #[inline(always)]
    pub fn contains(&self, i: usize) -> bool {
        self.0[i / 64] >> (i % 64) & 1 != 0
    }

    /// Whether nothing is in.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.0.as_ref().iter().all(|w| *w == 0)
    }

    /// How many are in.
    pub fn len(&self) -> usize {
        self.0.as_ref().iter().map(|w| w.count_ones() as usize).sum()
    }

    /// The smallest element that is also in `mask`.
    #[inline(always)]
    pub fn first_in(&self, mask: &Self) -> Option<usize> {
        for w in 0..Self::WORDS {
            let bits = self.0[w] & mask.0[w];
            if bits != 0 {
                return Some(w * 64 + bits.trailing_zeros() as usize);
            }
        }
        None
    }

    /// Whether the two share an element.
    #[inline(always)]
    pub fn meets(&self, other: &Self) -> bool {
        (0..Self::WORDS).any(|w| self.0[w] & other.0[w] != 0)
    }

    /// The elements of both.
    pub fn and(&self, other: &Self) -> Self {
        let mut set = *self;
        for w in 0..Self::WORDS {
            set.0[w] &= other.0[w];
        }
        set
    }

    /// The elements that are not in `other`.
    pub fn without(&self, other: &Self) -> Self {
        let mut set = *self;
        for w in 0..Self::WORDS {
            set.0[w] &= !other.0[w];
        }
        set
    }

    /// Adds all of `other`.
    pub fn extend(&mut self, other: &Self) {
        for w in 0..Self::WORDS {
            self.0[w] |= other.0[w];
        }
    }

    /// Calls `f` for each element, smallest first.
    #[inline(always)]
    pub fn each(&self, mut f: impl FnMut(usize)) {
        for w in 0..Self::WORDS {
            let mut bits = self.0[w];
            while bits != 0 {
                f(w * 64 + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
    }

    /// The largest of the elements' values; 0 for the empty set.
    #[inline(always)]
    pub(crate) fn largest(&self, of: &C::Nodes<u64>) -> u64 {
        let mut largest = 0;
        self.each(|i| largest = largest.max(of[i]));
        largest
    }

    /// The elements, smallest first.
    pub fn iter(&self) -> impl Iterator<Item = usize> + use<C> {
        let words = self.0;
        let (mut w, mut bits) = (0, words[0]);
        core::iter::from_fn(move || {
            while bits == 0 {
                w += 1;
                if w >= Self::WORDS {
                    return None;
                }
                bits = words[w];
            }
            let i = w * 64 + bits.trailing_zeros() as usize;
            bits &= bits - 1;
            Some(i)
        })
    }
}

impl<C: Capacity> Empty for NodeSet<C> {
    const EMPTY: Self = Self(C::Words::EMPTY);
}
