//! Choices, drawn from the fuzzer's bytes. Every sequence of bytes is one of choices; where they end, each is 0.

pub(crate) struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    pub(crate) const fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    /// One of `count`, at least one.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        usize::from(self.byte()) % count
    }

    pub(crate) fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// True in about `n` of 256.
    pub(crate) fn chance(&mut self, n: u8) -> bool {
        self.byte() > 255 - n
    }

    /// Any number: mostly small, often next to a power of two, sometimes all its bits.
    pub(crate) fn number(&mut self) -> u64 {
        match self.byte() % 16 {
            0..=8 => self.byte().into(),
            9..=11 => 1 << (self.byte() % 64),
            12 | 13 => (1 << (self.byte() % 64)) - 1,
            14 => u64::MAX - u64::from(self.byte() % 2),
            _ => u64::from_le_bytes([(); 8].map(|()| self.byte())),
        }
    }
}
