//! A file read through a window that holds one record: memory does not grow with the file.

use std::io::Read;
use std::path::Path;

use crate::formats::error::FormatError;

/// Bytes read at once.
const STEP: usize = 1 << 18;

/// The part of a source that is looked at, and where it is.
pub struct Window<'a, R> {
    source: R,
    file: &'a Path,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    offset: u64,
    exhausted: bool,
}

impl<'a, R: Read> Window<'a, R> {
    /// At the beginning of `source`; `file` names it in messages.
    #[must_use]
    pub fn new(file: &'a Path, source: R) -> Self {
        Self {
            source,
            file,
            buffer: vec![],
            start: 0,
            end: 0,
            offset: 0,
            exhausted: false,
        }
    }

    /// Offset of the window's first byte in the file.
    #[must_use]
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// What is in the window.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// Reads on until the window holds `count` bytes or the file is over; returns what it holds.
    ///
    /// # Errors
    /// [`FormatError`] when the source cannot be read.
    pub fn fill(&mut self, count: usize) -> Result<&[u8], FormatError> {
        while self.end - self.start < count && !self.exhausted {
            self.make_room();
            match self.source.read(&mut self.buffer[self.end..]) {
                Ok(0) => self.exhausted = true,
                Ok(read) => self.end += read,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) => return Err(FormatError::unreadable(self.file, &e)),
            }
        }
        Ok(self.bytes())
    }

    fn make_room(&mut self) {
        if self.start > 0 && self.start >= self.end - self.start {
            self.buffer.copy_within(self.start..self.end, 0);
            (self.start, self.end) = (0, self.end - self.start);
        }
        if self.buffer.len() - self.end < STEP {
            self.buffer.resize(self.end + STEP, 0);
        }
    }

    /// Moves the window's beginning on by at most what it holds.
    pub fn advance(&mut self, count: usize) {
        let count = count.min(self.end - self.start);
        self.start += count;
        self.offset += count as u64;
    }

    /// Passes over `count` bytes without keeping them; returns how many there were.
    ///
    /// # Errors
    /// [`FormatError`] when the source cannot be read.
    pub fn skip(&mut self, count: u64) -> Result<u64, FormatError> {
        let mut left = count;
        while left > 0 && !self.fill(1)?.is_empty() {
            let step = usize::try_from(left)
                .unwrap_or(usize::MAX)
                .min(self.end - self.start);
            self.advance(step);
            left -= step as u64;
        }
        Ok(count - left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_passes_once() {
        let data: Vec<u8> = (0..3_000_000u32).map(|k| (k % 251) as u8).collect();
        let mut window = Window::new(Path::new("a"), data.as_slice());
        let mut seen = 0;
        while !window.fill(1000).expect("readable").is_empty() {
            let held = window.bytes().len().min(997);
            assert_eq!(&window.bytes()[..held], &data[seen..seen + held]);
            window.advance(held);
            seen += held;
            assert_eq!(window.offset(), seen as u64);
        }
        assert_eq!(seen, data.len());
        assert!(window.buffer.len() <= 4 * STEP, "{}", window.buffer.len());
    }

    #[test]
    fn a_skip_ends_at_the_end() {
        let data = vec![7; 600_000];
        let mut window = Window::new(Path::new("a"), data.as_slice());
        assert_eq!(window.skip(500_000).expect("readable"), 500_000);
        assert_eq!(window.skip(500_000).expect("readable"), 100_000);
    }
}
