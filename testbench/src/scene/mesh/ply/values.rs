//! The numbers of a PLY one after the other, whatever their form.

use super::header::{Element, Encoding, Property, Scalar};
use crate::scene::SceneError;
use crate::scene::mesh::lines::Lines;
use crate::scene::mesh::reading::{Reading, line_error, read_error};
use std::io::ErrorKind;

/// The body of a file.
pub(super) struct Values<'a, 'b> {
    lines: &'a mut Lines<'b>,
    encoding: Encoding,
    /// What of the line at hand has been used, if there is text.
    used: usize,
}

impl<'a, 'b> Values<'a, 'b> {
    /// What comes after the header.
    pub fn new(lines: &'a mut Lines<'b>, encoding: Encoding) -> Values<'a, 'b> {
        let used = lines.text().len();
        Values { lines, encoding, used }
    }

    /// The line that was read last, if there are lines.
    pub fn line(&self) -> Option<usize> {
        (self.encoding == Encoding::Ascii).then(|| self.lines.number())
    }

    /// Begins an element: it starts in a line of its own.
    pub fn begin(&mut self, file: &Reading, element: &Element) -> Result<(), SceneError> {
        if self.encoding == Encoding::Ascii {
            self.next_line(file, element)?;
        }
        Ok(())
    }

    /// Ends an element: nothing is left of its line.
    pub fn end(&mut self, file: &Reading, element: &Element) -> Result<(), SceneError> {
        let rest = self.lines.text()[self.used..].trim_ascii();
        if self.encoding == Encoding::Ascii && !rest.is_empty() {
            let rest: String = String::from_utf8_lossy(rest).chars().take(60).collect();
            let what = format!("`{rest}` is left over after an element `{}`", element.name);
            return Err(file.bad(self.line(), what));
        }
        Ok(())
    }

    /// Reads a number of that type.
    pub fn number(
        &mut self,
        file: &Reading,
        element: &Element,
        property: &Property,
        scalar: Scalar,
    ) -> Result<f64, SceneError> {
        let big = match self.encoding {
            Encoding::Ascii => return self.word(file, element, property),
            Encoding::BigEndian => true,
            Encoding::LittleEndian => false,
        };
        Ok(match scalar {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.bytes(file, element, big)?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.bytes(file, element, big)?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.bytes(file, element, big)?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.bytes(file, element, big)?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.bytes(file, element, big)?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.bytes(file, element, big)?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.bytes(file, element, big)?)),
            Scalar::F64 => f64::from_le_bytes(self.bytes(file, element, big)?),
        })
    }

    /// Reads how many items a list has; 1 if the property is no list.
    pub fn count(
        &mut self,
        file: &Reading,
        element: &Element,
        property: &Property,
    ) -> Result<u64, SceneError> {
        let Some(scalar) = property.count else {
            return Ok(1);
        };
        let count = self.number(file, element, property, scalar)?;
        if count >= 0.0 && count.fract() == 0.0 && count <= f64::from(u32::MAX) {
            return Ok(count as u64);
        }
        let (name, list) = (&element.name, &property.name);
        let what = format!(
            "the list `{list}` of an element `{name}` has {count} items, expected 0 or more"
        );
        Err(file.bad(self.line(), what))
    }

    /// Reads the items of a list, or a number, and forgets them.
    pub fn skip(
        &mut self,
        file: &Reading,
        element: &Element,
        property: &Property,
    ) -> Result<(), SceneError> {
        for _ in 0..self.count(file, element, property)? {
            self.number(file, element, property, property.scalar)?;
        }
        Ok(())
    }

    /// Reads an element: of its properties those with a field into that field, and forgets the others.
    pub fn element(
        &mut self,
        file: &Reading,
        element: &Element,
        fields: &[Option<usize>],
        found: &mut [f64],
    ) -> Result<(), SceneError> {
        self.begin(file, element)?;
        for (property, field) in element.properties.iter().zip(fields) {
            match field.filter(|_| property.count.is_none()) {
                Some(field) => {
                    found[field] = self.number(file, element, property, property.scalar)?
                }
                None => self.skip(file, element, property)?,
            }
        }
        self.end(file, element)
    }

    fn next_line(&mut self, file: &Reading, element: &Element) -> Result<(), SceneError> {
        loop {
            let more =
                self.lines.read().map_err(|e| line_error(file.path, self.lines.number(), e))?;
            if !more {
                return Err(self.ends_early(file, element));
            }
            self.used = 0;
            if !self.lines.text().trim_ascii().is_empty() {
                return Ok(());
            }
        }
    }

    /// The number that the next word is; it may stand in the next line.
    fn word(
        &mut self,
        file: &Reading,
        element: &Element,
        property: &Property,
    ) -> Result<f64, SceneError> {
        while self.lines.text()[self.used..].trim_ascii_start().is_empty() {
            self.next_line(file, element)?;
        }
        let text = self.lines.text();
        let rest = text[self.used..].trim_ascii_start();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let word = &rest[..length];
        self.used = text.len() - rest.len() + length;
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        number.ok_or_else(|| {
            let word: String = String::from_utf8_lossy(word).chars().take(60).collect();
            let (name, property) = (&element.name, &property.name);
            let what = format!(
                "found `{word}`, expected a number for `{property}` of an element `{name}`"
            );
            file.bad(self.line(), what)
        })
    }

    /// The next bytes, in the order of a little-endian number.
    fn bytes<const N: usize>(
        &mut self,
        file: &Reading,
        element: &Element,
        big: bool,
    ) -> Result<[u8; N], SceneError> {
        let mut bytes = [0; N];
        let mut filled = 0;
        let reader = self.lines.rest();
        while filled < N {
            let found = match reader.fill_buf() {
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                found => found.map_err(|error| read_error(file.path, error))?,
            };
            if found.is_empty() {
                return Err(self.ends_early(file, element));
            }
            let count = found.len().min(N - filled);
            bytes[filled..filled + count].copy_from_slice(&found[..count]);
            reader.consume(count);
            filled += count;
        }
        if big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn ends_early(&self, file: &Reading, element: &Element) -> SceneError {
        let Element { name, count, .. } = element;
        let what =
            format!("the file ends early: the header declares {count} of the element `{name}`");
        file.bad(self.line(), what)
    }
}
