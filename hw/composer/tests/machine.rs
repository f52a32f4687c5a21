//! The image composition machine against the golden model, with single pixels as primitives. Triangles are tried in
//! `tests.rs`.

use pellucid_composer::architecture::ARCHITECTURE;
use pellucid_machine_properties::machine_properties;

machine_properties!(&ARCHITECTURE);
