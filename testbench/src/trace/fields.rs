//! The seven numbers of a fragment: their names, their order and their ranges, the same in both forms.

use pellucid_machine::pixel::{Fragment, Z_FAR, rgba};
use pellucid_sim::Label;

use pellucid_machine::pixel::{MAX_SIDE, Screen};

/// The fields in the order of both forms.
pub(super) const NAMES: [&str; 7] = ["x", "y", "z", "r", "g", "b", "a"];

/// The largest value of each field in such a frame; the smallest is 0.
pub(super) fn largest(info: Screen) -> [u32; 7] {
    [info.width.saturating_sub(1), info.height.saturating_sub(1), Z_FAR, 255, 255, 255, 255]
}

/// The fragment of seven values in range.
pub(super) fn fragment(values: [u32; 7]) -> Fragment {
    let [x, y, z, r, g, b, a] = values;
    Fragment { x, y, z, rgba: rgba(r as u8, g as u8, b as u8, a as u8), label: Label::NONE }
}

/// The seven values of a fragment.
pub(super) fn values(fragment: Fragment) -> [u32; 7] {
    let [r, g, b, a] = fragment.rgba.to_be_bytes().map(u32::from);
    [fragment.x, fragment.y, fragment.z, r, g, b, a]
}

/// Whether every value is in range, without a branch per field.
pub(super) fn in_range(values: &[u32; 7], largest: &[u32; 7]) -> bool {
    let mut fits = true;
    for (value, largest) in values.iter().zip(largest) {
        fits &= value <= largest;
    }
    fits
}

/// Checks every value and names the first that is out of range.
pub(super) fn check(values: &[u32; 7], largest: &[u32; 7]) -> Result<(), String> {
    if in_range(values, largest) {
        return Ok(());
    }
    for ((name, value), largest) in NAMES.iter().zip(values).zip(largest) {
        if value > largest {
            return Err(problem(name, &value.to_string(), 0, *largest));
        }
    }
    Ok(())
}

/// Checks the size of a frame.
pub(super) fn check_frame(info: Screen) -> Result<(), String> {
    for (name, side) in [("width", info.width), ("height", info.height)] {
        if side == 0 || side > MAX_SIDE {
            return Err(problem(name, &side.to_string(), 1, MAX_SIDE));
        }
    }
    if info.background > 0xff_ffff {
        return Err(problem("background", &info.background.to_string(), 0, 0xff_ffff));
    }
    Ok(())
}

/// The sentence for a value out of its range.
pub(super) fn problem(name: &str, found: &str, smallest: u32, largest: u32) -> String {
    format!("{name} is {found}, expected an integer from {smallest} to {largest}")
}
