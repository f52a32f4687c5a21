//! What the tests of this architecture share.

use crate::config::{Config, Params};
use crate::window::Places;
use crate::{ahead, plays, shader, sort, window};
use pellucid_machine::params::Parameters;
pub use pellucid_test_util::*;

/// A machine for few pixels, whose memories are smaller than random numbers.
pub fn small_fbuffer(settings: &[(&str, &str)]) -> Config {
    let mut params = Params { size: 2, ..Params::default() };
    for (name, value) in settings {
        params.set(name, value).unwrap();
    }
    Config::new(screen(7, 5), params).unwrap()
}

/// A window over 2^`place_bits` places, or batches.
pub fn window(place_bits: u32, fragment_cycles: u32, windows: bool) -> window::Config {
    let places = Places::Counted(place_bits);
    window::Config {
        screen: screen(7, 5),
        places,
        fragment_cycles,
        windows,
        compacts: false,
        outside: false,
    }
}

/// Windows over the survivors that have 2^`place_bits` places.
pub fn compacting(place_bits: u32) -> window::Config {
    window::Config { compacts: true, ..window(place_bits, 1, true) }
}

/// Plays of so many passes, in windows or batches.
pub fn plays(passes: u32, windows: bool, background: bool) -> plays::Config {
    plays::Config { window: window(2, 1, windows), passes, background, sorts: false }
}

/// A sort of windows of 2^`place_bits` places, with 2^`lane_bits` lanes.
pub fn sort(place_bits: u32, lane_bits: u32) -> sort::Config {
    sort::Config { screen: screen(7, 5), place_bits, lane_bits }
}

/// The F-buffer outside of a machine with these settings.
pub fn ahead(settings: &[(&str, &str)], reads_in_flight: u32) -> ahead::Config {
    let settings = [settings, &[("buffer", "outside")]].concat();
    ahead::Config { reads_in_flight, ..small_fbuffer(&settings).ahead }
}

/// The machine's fragment program of that name.
pub fn shader(program: &str, targets: u32, bits: u32) -> shader::Config {
    let (targets, bits) = (targets.to_string(), bits.to_string());
    let settings =
        [("program", program), ("targets", &targets), ("component_bits", &bits), ("seed", "3")];
    small_fbuffer(&settings).shader
}
