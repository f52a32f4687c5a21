//! The machines of the comparison, each with the memory that it is given.

use super::need::Need;
use crate::reproduce::kept::Machine;

/// A machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contender {
    /// Its name in tables and files.
    pub name: &'static str,
    /// The architecture.
    pub arch: &'static str,
    preset: &'static str,
    memory: Memory,
}

/// How much memory a machine is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Memory {
    /// A slot for each fragment that comes.
    Counted,
    /// A quarter of that.
    Quarter,
    /// Eight slots for each pixel.
    Eight,
    /// For each pixel as many slots as the deepest one has fragments.
    Deepest,
    /// Pages of so many fragments: to begin with a slot for each pixel, and at most as many as are needed.
    Growing(usize),
    /// As many as are needed from the start.
    Pages(usize),
}

const fn machine(
    name: &'static str,
    (arch, preset): (&'static str, &'static str),
    memory: Memory,
) -> Contender {
    Contender { name, arch, preset, memory }
}

/// The Dynamic Fragment Buffer as fast as it gets.
pub const DFB: Contender = machine("dfb:fast", ("dfb", "fast"), Memory::Counted);
/// The same as the paper describes it.
pub const DFB_PAPER: Contender = machine("dfb:paper", ("dfb", "paper"), Memory::Counted);
/// The same with too little memory.
pub const DFB_BANDS: Contender = machine("dfb:fast in bands", ("dfb", "fast"), Memory::Quarter);
/// The sample of the DirectX SDK.
pub const DX: Contender = machine("dfb:dx", ("dfb", "dx"), Memory::Eight);
/// A fixed array.
pub const B3D: Contender = machine("b3d", ("b3d", "paper"), Memory::Deepest);
/// Lists of pages.
pub const PPLL4: Contender = machine("ppll4", ("ppll", "ppll4"), Memory::Growing(1));
/// Lists of fragments.
pub const PLL: Contender = machine("pll", ("ppll", "pll"), Memory::Growing(0));
/// Lists of pages without any memory management.
pub const PPLL4_ENOUGH: Contender = machine("ppll4 without", ("ppll", "ppll4"), Memory::Pages(1));
/// Lists of fragments without any.
pub const PLL_ENOUGH: Contender = machine("pll without", ("ppll", "pll"), Memory::Pages(0));

/// Those of most figures.
pub const RIVALS: [Contender; 5] = [DFB, DFB_PAPER, B3D, PPLL4, PLL];

/// Bytes of a fragment, by the paper: "more than 4 GB" for 590 layers at 800x600.
const FRAGMENT: u64 = 16;
/// Bytes of a counter, a base, a head or a link.
const WORD: u64 = 4;
/// What the paper's computer had, in bytes: 1.5 GB.
const MEMORY: u64 = 1_500_000_000;
/// Slots for each pixel of the sample of the DirectX SDK.
const EIGHT: u64 = 8;

impl Contender {
    /// What the frames take in this machine by the paper's rules, in bytes.
    pub fn bytes(self, need: &Need) -> u64 {
        let Need { pixels, fragments, layers, pages } = *need;
        let tables = 2 * WORD * pixels;
        match self.memory {
            Memory::Counted => fragments * FRAGMENT + tables,
            Memory::Quarter => fragments.div_ceil(4) * FRAGMENT + tables,
            Memory::Eight => EIGHT * pixels * FRAGMENT + tables,
            // The machine has at least one.
            Memory::Deepest => pixels * layers.max(1) * FRAGMENT,
            Memory::Growing(k) | Memory::Pages(k) => {
                pages[k] * (page(k) * FRAGMENT + WORD) + WORD * pixels
            }
        }
    }

    /// Whether frames take all of the memory that this machine is given.
    pub fn is_filled(self) -> bool {
        !matches!(self.memory, Memory::Quarter | Memory::Eight)
    }

    /// Why the frames cannot be had with this machine, if so.
    pub fn lacks(self, need: &Need) -> Option<&'static str> {
        if self.memory == Memory::Eight && need.fragments > EIGHT * need.pixels {
            return Some("more than 8 fragments a pixel");
        }
        (self.bytes(need) > MEMORY).then_some("more than 1.5 GB")
    }

    /// As it is asked for where frames need this.
    pub fn machine(self, need: &Need) -> Machine {
        let settings = self.settings(need).into_iter();
        Machine {
            name: self.name.to_string(),
            arch: self.arch,
            preset: Some(self.preset),
            settings: settings.map(|(name, value)| (name, value.to_string())).collect(),
        }
    }

    /// The parameters that give it that memory, all of it on chip.
    fn settings(self, need: &Need) -> Vec<(&'static str, u64)> {
        let Need { pixels, fragments, layers, pages } = *need;
        let slots = |n: u64| vec![("fragments", n.max(1)), ("outside_fragments", 0)];
        let lists = |begin: u64, k: usize| {
            let most = pages[k].max(1);
            let begin = begin.clamp(1, most);
            vec![("pages", begin), ("most_pages", most), ("fragments", most * page(k))]
        };
        match self.memory {
            Memory::Counted => slots(fragments),
            Memory::Quarter => slots(fragments.div_ceil(4)),
            Memory::Eight => slots(EIGHT * pixels),
            Memory::Deepest => {
                let layers = layers.max(1);
                vec![("layers", layers), ("fragments", pixels * layers)]
            }
            Memory::Growing(k) => lists(pixels / page(k), k),
            Memory::Pages(k) => lists(pages[k], k),
        }
    }
}

/// Fragments of a page.
fn page(k: usize) -> u64 {
    super::need::PAGES[k].into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text's own numbers: 590 layers at 800x600 are "more than 4 GB", and full quads take four times as much in lists of pages.
    #[test]
    fn bytes_are_those_of_the_paper() {
        let plant = Need { pixels: 480_000, fragments: 0, layers: 590, pages: [0, 0] };
        assert_eq!(B3D.bytes(&plant), 4_531_200_000);
        assert_eq!(B3D.lacks(&plant), Some("more than 1.5 GB"));
        let quad = Need { pixels: 100, fragments: 100, layers: 1, pages: [100, 100] };
        assert_eq!(DFB.bytes(&quad), 1600 + 800);
        assert_eq!(B3D.bytes(&quad), 1600);
        assert_eq!(PPLL4.bytes(&quad), 100 * 68 + 400);
        assert_eq!(PLL.bytes(&quad), 100 * 20 + 400);
        assert_eq!(DX.bytes(&quad), 8 * 1600 + 800);
        let deep = Need { fragments: 801, ..quad };
        assert_eq!(DX.lacks(&quad), None);
        assert_eq!(DX.lacks(&deep), Some("more than 8 fragments a pixel"));
    }
}
