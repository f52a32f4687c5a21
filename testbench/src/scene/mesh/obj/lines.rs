//! A text by its lines, for messages that name one.

use std::io::{self, BufRead, Read};

/// The words of each line.
pub(super) fn words(bytes: &[u8]) -> impl Iterator<Item = Vec<&str>> {
    bytes
        .split(|&byte| byte == b'\n')
        .map(|line| str::from_utf8(line).unwrap_or("").split_whitespace().collect())
}

/// A text that knows how far it has been read.
pub(super) struct Tracked<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Tracked<'a> {
    /// Nothing read yet.
    pub fn new(bytes: &'a [u8]) -> Tracked<'a> {
        Tracked { bytes, at: 0 }
    }

    /// The line, from 1, that was read last.
    pub fn line(&self) -> usize {
        let read = &self.bytes[..self.at];
        read.split_inclusive(|&byte| byte == b'\n').count()
    }
}

impl Read for Tracked<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = (&self.bytes[self.at..]).read(buffer)?;
        self.at += read;
        Ok(read)
    }
}

impl BufRead for Tracked<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        Ok(&self.bytes[self.at..])
    }

    fn consume(&mut self, amount: usize) {
        self.at += amount;
    }
}
