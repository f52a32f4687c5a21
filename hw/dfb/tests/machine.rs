//! The Dynamic Fragment Buffer against the golden model.

use pellucid_dfb::architecture::ARCHITECTURE;
use pellucid_machine_properties::machine_properties;

machine_properties!(&ARCHITECTURE);
