//! Where arguments lie: one after another, each with room around it that nobody may write.

use crate::ground::Ground;

const CANARY: u8 = 0xC3;
/// Between two arguments.
const GAP: usize = 64;

pub(crate) struct Desk<'a> {
    ground: &'a mut Ground,
    end: usize,
    /// Inputs of the call so far, with their lengths.
    inputs: Vec<(usize, usize)>,
}

impl<'a> Desk<'a> {
    pub(crate) const fn new(ground: &'a mut Ground) -> Self {
        Self { ground, end: 0, inputs: Vec::new() }
    }

    pub(crate) fn clear(&mut self) {
        self.end = 0;
        self.inputs.clear();
        self.ground.reset(0, CANARY);
        let _before = self.place(0);
    }

    /// Room for so many bytes, aligned for everything.
    pub(crate) fn place(&mut self, bytes: usize) -> usize {
        let at = self.end;
        self.end = at + bytes.next_multiple_of(GAP) + GAP;
        self.ground.activate(self.end);
        self.ground.fill(at..self.end, CANARY);
        at
    }

    /// An input.
    pub(crate) fn input(&mut self, bytes: &[u8]) -> usize {
        let at = self.place(bytes.len());
        self.ground.write(at, bytes);
        self.inputs.push((at, bytes.len()));
        at
    }

    /// An input that so many bytes may be written over.
    pub(crate) fn shared(&self, which: usize, bytes: usize) -> Option<usize> {
        let mut large = self.inputs.iter().filter(|(_, len)| *len >= bytes);
        large.nth(which % self.inputs.len().max(1)).map(|(at, _)| *at)
    }

    pub(crate) fn write(&mut self, at: usize, bytes: &[u8]) {
        self.ground.write(at, bytes);
    }

    pub(crate) fn expect(&mut self, at: usize, bytes: &[u8]) {
        self.ground.expect(at, bytes);
    }

    /// The last input is written over.
    pub(crate) fn expect_last(&mut self, bytes: &[u8]) {
        let at = self.inputs.last().map_or(0, |(at, _)| *at);
        self.ground.expect(at, bytes);
    }

    pub(crate) fn pointer<T>(&self, at: usize) -> *mut T {
        self.ground.pointer(at)
    }

    pub(crate) fn word(&self, at: usize) -> u64 {
        self.ground.word(at)
    }

    /// The last argument, as if the library had written it.
    pub(crate) fn poke_last(&self) {
        self.ground.poke(self.end - 2 * GAP, &[!CANARY]);
    }

    pub(crate) fn difference(&self) -> Option<usize> {
        self.ground.difference()
    }
}
