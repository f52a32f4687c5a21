//! Accumulation against the golden model.

use pellucid_accumulate::architecture::ARCHITECTURE;
use pellucid_machine_properties::machine_properties;

machine_properties!(&ARCHITECTURE);
