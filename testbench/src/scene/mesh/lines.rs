//! A text by its lines, whatever ends them, each of bounded length.

use std::io::{self, BufRead};

/// Bytes that no line reaches.
pub(super) const MOST_LINE: usize = 1 << 21;

/// A text that is read line by line.
pub(super) struct Lines<'a> {
    reader: &'a mut dyn BufRead,
    /// The line that was read last.
    text: Vec<u8>,
    number: usize,
    /// How many lines after it are joined to it.
    joined: usize,
    /// Whether a line feed after a carriage return belongs to it, once there has been one.
    pairs: Option<bool>,
}

impl<'a> Lines<'a> {
    /// Nothing read yet.
    pub fn new(reader: &'a mut dyn BufRead) -> Lines<'a> {
        Lines { reader, text: vec![], number: 0, joined: 0, pairs: None }
    }

    /// The number, from 1, of the line that was read last.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The line that was read last, without its end.
    pub fn text(&self) -> &[u8] {
        &self.text
    }

    /// What comes after the line that was read last.
    pub fn rest(&mut self) -> &mut dyn BufRead {
        self.reader
    }

    /// Reads a line, which ends at a line feed, a carriage return, or both. Whether there is one.
    ///
    /// # Errors
    /// That of the reader, and [`io::ErrorKind::FileTooLarge`] for a line of [`MOST_LINE`] bytes.
    pub fn read(&mut self) -> io::Result<bool> {
        self.text.clear();
        self.number += 1 + std::mem::take(&mut self.joined);
        self.read_on()
    }

    /// Reads on behind the line that was read last. Whether there is anything.
    fn read_on(&mut self) -> io::Result<bool> {
        let mut any = false;
        loop {
            let bytes = match self.reader.fill_buf() {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                bytes => bytes?,
            };
            if bytes.is_empty() {
                return Ok(any);
            }
            any = true;
            let end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let length = end.unwrap_or(bytes.len());
            if self.text.len() + length >= MOST_LINE {
                let what = format!("is longer than {} bytes", MOST_LINE - 1);
                return Err(io::Error::new(io::ErrorKind::FileTooLarge, what));
            }
            self.text.extend_from_slice(&bytes[..length]);
            let ending = end.map(|end| bytes[end]);
            self.reader.consume(length + usize::from(end.is_some()));
            match ending {
                Some(b'\r') => return self.end_pair(),
                Some(_) => return Ok(true),
                None => {}
            }
        }
    }

    /// Reads the line feed that belongs to a carriage return.
    fn end_pair(&mut self) -> io::Result<bool> {
        if self.pairs != Some(false) {
            let there = self.reader.fill_buf()?.first() == Some(&b'\n');
            if there {
                self.reader.consume(1);
            }
            self.pairs = self.pairs.or(Some(there));
        }
        Ok(true)
    }

    /// Reads a line, and the ones after it as long as it ends in a backslash that is in no comment. Whether there is one.
    ///
    /// # Errors
    /// As [`Lines::read`].
    pub fn read_joined(&mut self) -> io::Result<bool> {
        if !self.read()? {
            return Ok(false);
        }
        while let Some(before) = self.text.trim_ascii_end().strip_suffix(b"\\")
            && !is_comment(before)
        {
            self.text.truncate(before.len());
            self.text.push(b' ');
            self.read_on()?;
            self.joined += 1;
        }
        Ok(true)
    }
}

/// Whether a line that starts so goes on as a comment: a word of it starts with `#`.
fn is_comment(text: &[u8]) -> bool {
    text.split(u8::is_ascii_whitespace).any(|word| word.starts_with(b"#"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number and the text of each line.
    fn lines(text: &str, joined: bool) -> Vec<(usize, String)> {
        let mut reader = text.as_bytes();
        let mut lines = Lines::new(&mut reader);
        let mut found = vec![];
        while if joined { lines.read_joined() } else { lines.read() }.unwrap() {
            found.push((lines.number(), String::from_utf8(lines.text().to_vec()).unwrap()));
        }
        found
    }

    #[test]
    fn a_line_ends_at_a_line_feed_a_carriage_return_or_both() {
        for text in ["a\n\nb\n", "a\r\rb\r", "a\r\n\r\nb\r\n", "a\n\nb"] {
            let expected = [(1, "a"), (2, ""), (3, "b")].map(|(n, text)| (n, text.to_owned()));
            assert_eq!(lines(text, false), expected, "{text:?}");
        }
    }

    #[test]
    fn a_backslash_joins_the_next_line_but_not_to_a_comment() {
        let text = "f 1 \\\n2 \\ \n3\n# a\\\ng a#b\\\nc\nd # e\\\nf\\";
        let expected = [(1, "f 1  2  3"), (4, "# a\\"), (5, "g a#b c"), (7, "d # e\\"), (8, "f ")];
        assert_eq!(lines(text, true), expected.map(|(n, text)| (n, text.to_owned())));
    }

    #[test]
    fn a_line_without_end_is_an_error_and_not_held() {
        let mut endless = io::BufReader::new(io::repeat(b'a'));
        let mut lines = Lines::new(&mut endless);
        let error = lines.read().unwrap_err();
        assert_eq!(error.to_string(), "is longer than 2097151 bytes");
        assert!(lines.text().len() < MOST_LINE);
    }
}
