//! The hardware: all architectures. Each is a crate of its own, made of the shared blocks.

use pellucid_machine::Architecture;
use pellucid_machine::architecture::SettingError;

/// All architectures; the first is the default.
pub static ARCHITECTURES: &[&Architecture] = &[
    &pellucid_tbuffer::architecture::ARCHITECTURE,
    &pellucid_rbuffer::architecture::ARCHITECTURE,
    &pellucid_mbuffer::architecture::ARCHITECTURE,
    &pellucid_composer::architecture::ARCHITECTURE,
    &pellucid_dfb::architecture::ARCHITECTURE,
    &pellucid_b3d::architecture::ARCHITECTURE,
    &pellucid_ppll::architecture::ARCHITECTURE,
    &pellucid_fbuffer::architecture::ARCHITECTURE,
    &pellucid_accumulate::architecture::ARCHITECTURE,
];

/// The architecture of that name.
///
/// # Errors
/// There is none; the nearest name is suggested.
pub fn architecture(name: &str) -> Result<&'static Architecture, SettingError> {
    Architecture::named(ARCHITECTURES, name)
}
