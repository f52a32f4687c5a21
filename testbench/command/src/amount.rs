//! Amounts as users write them: a number, perhaps with a unit.

/// What may stand behind a number, and its factor.
const UNITS: [(&str, f64); 7] = [
    ("", 1.0),
    ("KiB", 1024.0),
    ("MiB", 1_048_576.0),
    ("GiB", 1_073_741_824.0),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
];

/// The number that a text is, with the unit behind it.
pub(super) fn amount(text: &str) -> Option<f64> {
    let text = text.trim();
    let end = text.find(|c: char| c.is_ascii_alphabetic() && c != 'e').unwrap_or(text.len());
    let (digits, unit) = text.split_at(end);
    let factor = UNITS.iter().find(|(name, _)| *name == unit)?.1;
    let value: f64 = digits.trim().replace('_', "").parse().ok()?;
    value.is_finite().then_some(value * factor)
}

/// A number of bytes.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    let bytes =
        amount(text).filter(|bytes| *bytes >= 0.0 && *bytes < 1e18).map(|bytes| bytes as u64);
    bytes.ok_or_else(|| {
        "expected bytes, and perhaps KiB, MiB, GiB, k, M or G, as `1 MiB`".to_string()
    })
}
