//! Cycles in a graph of at most 256 vertices.

use std::array;

/// Vertices of a graph after refinement, all versions included.
const MAX_VERTICES: usize = 256;
const WORD_BITS: usize = u64::BITS as usize;
const WORDS: usize = MAX_VERTICES / WORD_BITS;

/// A set of vertices.
#[derive(Clone, Debug, Default)]
pub(super) struct VertexSet([u64; WORDS]);

impl VertexSet {
    pub(super) fn insert(&mut self, vertex: usize) {
        self.0[vertex / WORD_BITS] |= 1 << (vertex % WORD_BITS);
    }

    pub(super) fn remove(&mut self, vertex: usize) {
        self.0[vertex / WORD_BITS] &= !(1 << (vertex % WORD_BITS));
    }

    /// The members, ascending.
    pub(super) fn iter(&self) -> impl Iterator<Item = usize> {
        let mut rest = self.clone();
        std::iter::from_fn(move || {
            let first = rest.first()?;
            rest.remove(first);
            Some(first)
        })
    }

    fn contains(&self, vertex: usize) -> bool {
        self.0[vertex / WORD_BITS] & (1 << (vertex % WORD_BITS)) != 0
    }

    fn first(&self) -> Option<usize> {
        let word = self.0.iter().position(|bits| *bits != 0)?;
        Some(word * WORD_BITS + self.0[word].trailing_zeros() as usize)
    }

    fn intersection(&self, other: &Self) -> Self {
        Self(array::from_fn(|word| self.0[word] & other.0[word]))
    }

    fn difference(&self, other: &Self) -> Self {
        Self(array::from_fn(|word| self.0[word] & !other.0[word]))
    }
}

/// The vertices of a cycle in the order of its edges, if there is one.
///
/// A depth-first search without recursion. Each step takes or leaves one vertex, so the time grows with the
/// vertices and not with the edges.
pub(super) fn find_cycle(successors: &[VertexSet]) -> Option<Vec<usize>> {
    let mut visited = VertexSet::default();
    for start in 0..successors.len() {
        if visited.contains(start) {
            continue;
        }
        let mut path = vec![start];
        let mut on_path = VertexSet::default();
        while let Some(&vertex) = path.last() {
            visited.insert(vertex);
            on_path.insert(vertex);
            if let Some(closing) = successors[vertex].intersection(&on_path).first() {
                return Some(path.split_off(path.iter().position(|on| *on == closing)?));
            }
            match successors[vertex].difference(&visited).first() {
                Some(next) => path.push(next),
                None => {
                    on_path.remove(vertex);
                    path.pop();
                }
            }
        }
    }
    None
}

#[cfg(test)]
mod tests;
