//! Decimal numbers, a machine word at a time.

/// Eight times the same byte.
const fn every(byte: u8) -> u64 {
    u64::from_ne_bytes([byte; 8])
}

/// The number at the start of `text` and its length, 1 to 8 digits; `None` without a digit. What follows eight
/// digits is for the caller to check.
///
/// The eight bytes are worked on at once: find the first that is no digit, shift the digits to the most
/// significant end so that zeros lead, then add them up in pairs, fours and eights.
pub(super) fn leading(text: &[u8; 8]) -> Option<(u32, usize)> {
    let word = u64::from_le_bytes(*text) ^ every(b'0');
    // A byte is a digit if it is now 0..=9: otherwise its own top bit is set, or becomes set by adding 0x76.
    // A carry out of a byte only reaches later bytes, and only from one that is no digit itself.
    let others = (word | word.wrapping_add(every(0x76))) & every(0x80);
    let length = others.trailing_zeros() / 8;
    if length == 0 {
        return None;
    }
    let digits = word << (64 - 8 * length);
    let pairs = digits.wrapping_mul(10).wrapping_add(digits >> 8);
    const PAIR: u64 = 0x0000_00ff_0000_00ff;
    let fours = (pairs & PAIR).wrapping_mul(100 + (1_000_000 << 32));
    let others = (pairs >> 16 & PAIR).wrapping_mul(1 + (10_000 << 32));
    Some(((fours.wrapping_add(others) >> 32) as u32, length as usize))
}

/// The value of plain decimal digits in `smallest..=largest`; `None` for anything else.
pub(super) fn integer(text: &[u8], smallest: u32, largest: u32) -> Option<u32> {
    if text.is_empty() {
        return None;
    }
    let mut value = 0_u32;
    for &byte in text {
        if !byte.is_ascii_digit() {
            return None;
        }
        value = value.saturating_mul(10).saturating_add(u32::from(byte - b'0'));
    }
    (smallest..=largest).contains(&value).then_some(value)
}

/// Appends a value in decimal.
pub(super) fn append(mut value: u32, text: &mut Vec<u8>) {
    let mut digits = [0; 10];
    let mut start = digits.len();
    loop {
        start -= 1;
        digits[start] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    text.extend_from_slice(&digits[start..]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_byte_but_a_digit_ends_a_number() {
        for byte in 0..=255_u8 {
            let expected = match byte {
                b'0'..=b'9' => Some((12_000_000 + u32::from(byte - b'0') * 100_000, 8)),
                _ => Some((12, 2)),
            };
            let text = [b'1', b'2', byte, b'0', b'0', b'0', b'0', b'0'];
            assert_eq!(leading(&text), expected, "byte {byte}");
        }
    }

    #[test]
    fn integers_are_digits_in_range() {
        assert_eq!(integer(b"007", 0, 7), Some(7));
        assert_eq!(integer(b"8", 0, 7), None);
        assert_eq!(integer(b"0", 1, 7), None);
        assert_eq!(integer(b"99999999999999999999", 0, 255), None);
        for text in [&b""[..], b"-1", b"+1", b"1.0", b"1e1", b"0x1", b"1 1"] {
            assert_eq!(integer(text, 0, 255), None);
        }
    }

    proptest! {
        #[test]
        fn a_word_gives_what_the_standard_library_parses(value in 0..100_000_000_u32, rest: [u8; 8]) {
            let text = value.to_string();
            let mut word = rest;
            word[..text.len()].copy_from_slice(text.as_bytes());
            let end = word.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(8);
            let expected: u32 = std::str::from_utf8(&word[..end]).unwrap().parse().unwrap();
            prop_assert_eq!(leading(&word), Some((expected, end)));
        }

        #[test]
        fn append_writes_what_the_standard_library_writes(value: u32) {
            let mut text = Vec::new();
            append(value, &mut text);
            prop_assert_eq!(text, value.to_string().into_bytes());
        }
    }
}
