//! A window that moves over a file: the bytes that the parser has not used yet, in one piece.
//!
//! Unlike a `BufReader`, it reads on while there are still bytes in it, so that a line or a record is never
//! cut in two. Its memory is constant.

use std::io::{self, Read};

/// Bytes in the window when it is full: it holds any line or record that a reader accepts.
pub(super) const WINDOW_BYTES: usize = 1 << 18;

pub(super) struct Window<R> {
    reader: R,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    at_end: bool,
    used: u64,
}

impl<R: Read> Window<R> {
    pub(super) fn new(reader: R) -> Window<R> {
        let buffer = vec![0; WINDOW_BYTES];
        Window { reader, buffer, start: 0, end: 0, at_end: false, used: 0 }
    }

    /// How many bytes have been used.
    pub(super) fn used(&self) -> u64 {
        self.used
    }

    /// The bytes read and not used yet.
    pub(super) fn bytes(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// The first `length` of the `count` bytes that were used last.
    pub(super) fn before(&self, count: usize, length: usize) -> &[u8] {
        let start = self.start - count;
        &self.buffer[start..start + length]
    }

    /// Takes the first `count` bytes as used.
    pub(super) fn consume(&mut self, count: usize) {
        let count = count.min(self.end - self.start);
        self.start += count;
        self.used += count as u64;
    }

    /// Reads until at least `count` bytes (at most [`WINDOW_BYTES`]) are there, or the file ends.
    pub(super) fn want(&mut self, count: usize) -> io::Result<()> {
        if self.end - self.start >= count || self.at_end {
            return Ok(());
        }
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        while self.end < self.buffer.len() {
            match self.reader.read(&mut self.buffer[self.end..]) {
                Ok(0) => {
                    self.at_end = true;
                    break;
                }
                Ok(count) => self.end += count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}
