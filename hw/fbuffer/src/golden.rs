//! The golden model of fragment programs, in plain software. It runs a whole program on a fragment at once: of passes, windows
//! and F-buffers it knows nothing. It shares the text of programs with the hardware, and no line that carries one out.
//!
//! Shaded fragments are blended in the order in which they arrive, over the pixel's final opaque colour: what a graphics API
//! does with fragments that nobody has sorted.

use crate::program::{Input, Kind, Op, Operand, Program, TEMPORARIES};
use pellucid_machine::Arithmetic;
use pellucid_machine::arithmetic::{Layer, Shading, Unshaded};

/// The arithmetic of a machine that runs the program `kind`, drawn from `seed` if it is random, with so many targets and bits of
/// a component. Where fragments of a pixel share what is stored between passes, all but the last pass are run on the last of them.
pub fn arithmetic(
    kind: Kind,
    seed: u32,
    targets: u32,
    bits: u32,
    shares: bool,
    sorts: bool,
) -> Arithmetic {
    let name = match kind {
        Kind::Tint | Kind::Restore if sorts => return Arithmetic::BLEND,
        Kind::Glass if sorts => "exact blend of what `glass` shades",
        Kind::Sieve if sorts => "exact blend of what `sieve` leaves",
        Kind::Random if sorts => "exact blend of what a random program shades",
        _ if shares => "blend in arrival order, with one place for each pixel between passes",
        Kind::Tint | Kind::Restore => "blend in arrival order",
        Kind::Glass => "blend in arrival order of what `glass` shades",
        Kind::Sieve => "blend in arrival order of what `sieve` leaves",
        Kind::Random => "blend in arrival order of what a random program shades",
    };
    let of_kind = Kind::ALL.iter().position(|known| *known == kind).unwrap_or_default();
    let program =
        [(u64::from(seed), 32), (u64::from(shares), 24), (of_kind as u64, 16), (targets.into(), 8)];
    let program =
        program.iter().fold(bits.into(), |program, (value, shift)| program | value << shift);
    let shading = Some(Shading { program, colour: shaded });
    let colour = if sorts { sorted } else { in_order };
    // Any colour may come of a program and of the order.
    Arithmetic { name, colour: Some(colour), shading, error_bound: |_| 255 }
}

/// Layers over a colour, far to near, at equal depth in arrival order.
fn sorted(layers: &[Layer], below: u32) -> u32 {
    let mut layers = layers.to_vec();
    layers.sort_by_key(|layer| std::cmp::Reverse(layer.z));
    in_order(&layers, below)
}

/// Layers over a colour, in arrival order.
fn in_order(layers: &[Layer], below: u32) -> u32 {
    layers.iter().fold(below, |below, layer| {
        let [red, green, blue, alpha] = layer.rgba.to_be_bytes().map(u32::from);
        // Rounded to nearest; 255 is odd, so there is no tie.
        let over = |own: u32, under: u32| (2 * (alpha * own + (255 - alpha) * under) + 255) / 510;
        let [_, r, g, b] = below.to_be_bytes().map(u32::from);
        over(red, r) << 16 | over(green, g) << 8 | over(blue, b)
    })
}

/// The colour `0xRRGGBBAA` that the program numbered `number` gives a fragment, and the last one of its pixel; nothing if it
/// kills it.
fn shaded(number: u64, own: Unshaded, last: Unshaded) -> Option<u32> {
    let byte = |shift: u32| (number >> shift & 0xff) as u32;
    let kind = Kind::ALL[byte(16) as usize];
    let program = Program::new(kind, (number >> 32) as u32, byte(8));
    if byte(24) == 1 {
        run_shared(&program, byte(0), own, last)
    } else {
        run(&program, byte(0), own)
    }
}

/// The colour `0xRRGGBBAA` that a program gives a fragment, with components of so many bits; nothing if it kills it.
pub fn run(program: &Program, bits: u32, of: Unshaded) -> Option<u32> {
    run_shared(program, bits, of, of)
}

/// The same, where all passes before the last one are those of the pixel's last fragment.
fn run_shared(program: &Program, bits: u32, own: Unshaded, last: Unshaded) -> Option<u32> {
    let one = 1i128 << bits;
    // A number of `own` bits as a fraction of `one`, rounded down.
    let fraction = |number: u32, own: u32| i128::from(number) * one / (1i128 << own);
    let mut registers = [0i128; 32];
    let (before, after) = program.list().split_at(program.list().len() - 1);
    let before = before.iter().flat_map(|pass| pass.list()).map(|instruction| (instruction, last));
    let after = after.iter().flat_map(|pass| pass.list()).map(|instruction| (instruction, own));
    for (instruction, of) in before.chain(after) {
        let [red, green, blue, alpha] =
            of.rgba.to_be_bytes().map(|level| fraction(level.into(), 8));
        let number = |operand: Operand| match operand {
            Operand::Register(k) => registers[k as usize],
            Operand::Constant(k) => fraction(k, 8),
            Operand::Input(Input::X) => fraction(of.x % 16, 4),
            Operand::Input(Input::Y) => fraction(of.y % 16, 4),
            Operand::Input(Input::Z) => fraction(of.z, 24),
            Operand::Input(Input::Red) => red,
            Operand::Input(Input::Green) => green,
            Operand::Input(Input::Blue) => blue,
            Operand::Input(Input::Alpha) => alpha,
        };
        let [a, b, c] = [instruction.a, instruction.b, instruction.c].map(number);
        let result = match instruction.op {
            Op::Add => a + b,
            Op::Sub => a - b,
            Op::Mul => a * b / one,
            Op::Min => std::cmp::min(a, b),
            Op::Max => std::cmp::max(a, b),
            Op::Select if a < b => c,
            Op::Select => registers[instruction.to as usize],
            Op::Kill if a < b => return None,
            Op::Kill => continue,
        };
        registers[instruction.to as usize] = result.clamp(0, one - 1);
    }
    let level = |k: u32| (registers[(TEMPORARIES + k) as usize] * 256 / one) as u32;
    Some(level(0) << 24 | level(1) << 16 | level(2) << 8 | level(3).min(254))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_machine::pixel::rgba;

    #[test]
    fn a_tinted_fragment_keeps_its_colour() {
        for bits in [8, 16, 32] {
            let of = Unshaded { x: 3, y: 8, z: 99, rgba: rgba(0, 17, 255, 254) };
            assert_eq!(run(&Program::new(Kind::Tint, 0, 1), bits, of), Some(of.rgba));
        }
    }

    /// White in the middle of a pit, half through, at half of the depth: absorption 1 - 160/256 * 1/2.
    #[test]
    fn glass_by_hand() {
        let of = Unshaded { x: 24, y: 8, z: 1 << 23, rgba: rgba(255, 255, 255, 128) };
        // With 8 bits: 128 * 160 / 256 = 80; 255 - 80 = 175. Red and green 255 * 175 / 256 = 174.3; 175 * 175 / 256 = 119.6 and blue
        // 255 * 119 / 256 = 118.5. The pit's middle is half as bright: 87, 87, 59. Reflected: 255 - 128 = 127, 127 * 127 / 256 = 63.0,
        // 63 * 96 / 256 = 23.6.
        let glass = |of| run(&Program::new(Kind::Glass, 0, 1), 8, of);
        assert_eq!(glass(of), Some(rgba(110, 110, 82, 151)));
        // At a pit's rim, at the near plane, opaque but for a 255th: as bright as it was.
        let of = Unshaded { x: 0, y: 0, z: 0, rgba: rgba(200, 100, 50, 254) };
        // 200 * 255 / 256 = 199, 99 and 49 * 254 / 255; twice 64 and 128 are 256, which is 255 at most.
        assert_eq!(glass(of), Some(rgba(198, 98, 48, 254)));
    }

    #[test]
    fn sieve_by_hand() {
        let sieve = |x, y, z, alpha| {
            let of = Unshaded { x, y, z, rgba: rgba(200, 100, 50, alpha) };
            run(&Program::new(Kind::Sieve, 0, 1), 8, of)
        };
        // Columns and rows from 3 to 13 of a tile are its hole.
        for (at, hole) in [(2, false), (3, true), (8, true), (13, true), (14, false), (18, false)] {
            assert_eq!(sieve(at, 8, 0, 254).is_none(), hole, "column {at}");
            assert_eq!(sieve(8, at, 0, 254).is_none(), hole, "row {at}");
        }
        // At half of the depth 255 - 64 = 191: 200 * 191 / 256 = 149.2, 74.6, 37.3; alpha 254 * 191 / 256 = 189.5.
        assert_eq!(sieve(0, 0, 1 << 23, 254), Some(rgba(149, 74, 37, 189)));
        // 42 * 191 / 256 = 31.3, and 43 * 191 / 256 = 32.1.
        assert_eq!(sieve(0, 0, 1 << 23, 42), None);
        assert_eq!(sieve(0, 0, 1 << 23, 43), Some(rgba(149, 74, 37, 32)));
    }
}
