//! What Yosys counts, against what the netlist's registers and memories say.

mod tools;

use pellucid_blocks::allocator::{self, FreeList};
use pellucid_blocks::chains::config as chains;
use pellucid_blocks::chains::scan::Scan;

use pellucid_blocks::sorter::{self, Sorter};
use pellucid_machine::pixel::Screen;
use pellucid_rbuffer::queue::{self, Queue};
use pellucid_sim::netlist::{Module, Netlist, Register, Type, elaborate};
use pellucid_tbuffer::config::{Config, PRESETS, Params};
use pellucid_testbench::area::{Area, measure};
use pellucid_verilog::files;

fn area<B: Netlist>(cfg: &B::Config) -> (Module, Area) {
    let netlist = elaborate::<B>(cfg);
    let area = measure(&netlist, &files(&netlist, &[]), true).unwrap();
    assert!(area.unknown.is_empty(), "{:?}", area.unknown);
    (netlist, area)
}

/// Flip-flops of a block's own registers that ever change: one for each bit, and one for each state of
/// a state machine, since Yosys gives each its own.
fn flip_flops(module: &Module) -> u64 {
    let own = |k: &usize| module.owner(*k).is_none() && !module.is_constant(*k);
    let registers = (0..module.registers.len()).filter(own).map(|k| &module.registers[k]);
    let count = |register: &Register| match register.ty {
        Type::State(states) => states.variants.len() as u64,
        _ => u64::from(register.width),
    };
    registers.map(count).sum()
}

const SCREEN: Screen = Screen { width: 64, height: 48, background: 0 };

fn sorter(depth: u32) -> sorter::Config {
    sorter::Config { depth, layer_bits: 8, pixel_bits: SCREEN.pixel_bits(), newest_first: false }
}

fn chains(sections: u32) -> chains::Config {
    let params = Params { sections, outside_sections: 0, ..(PRESETS[0].params)() };
    Config::new(SCREEN, params).unwrap().chains
}

#[test]
fn a_register_is_a_flip_flop_for_each_bit() {
    if !tools::have(&["yosys"]) {
        return;
    }
    let (netlist, counted) = area::<Sorter>(&sorter(4));
    assert_eq!(counted.parts[0].cells.flip_flops, flip_flops(&netlist));

    // Each of the blocks of a hierarchy has its own.
    let (netlist, counted) = area::<Scan>(&chains(64));
    let children: Vec<u64> = netlist.instances.iter().map(|i| flip_flops(&i.module)).collect();
    let counts: Vec<u64> = counted.parts.iter().map(|part| part.cells.flip_flops).collect();
    assert_eq!(counts[1..], children);
    assert_eq!(counts[0], flip_flops(&netlist) + children.iter().sum::<u64>());
}

#[test]
fn a_memory_is_a_ram_block_where_it_is_large() {
    if !tools::have(&["yosys"]) {
        return;
    }
    for (sections, half_rams) in [(16_u32, 0), (1024, 1), (2048, 2)] {
        let (_, counted) = area::<FreeList>(&allocator::Config { sections });
        let [list, queue] = &counted.parts[..] else { panic!("{:?}", counted.parts) };
        assert_eq!((list.path.as_str(), queue.path.as_str()), ("", "queue"));
        // A queue of all sections' numbers. A block RAM has 18 Kbit.
        let bits = sections * sections.ilog2();
        assert_eq!(list.cells.memory_bits, u64::from(bits));
        assert_eq!(queue.cells.half_rams, half_rams, "{sections} sections");
        // The list itself has a register that counts from 0 to `sections`.
        let own = list.cells.flip_flops - queue.cells.flip_flops;
        assert_eq!(own, u64::from(sections.ilog2() + 1));
    }
}

#[test]
fn outside_memory_takes_no_area() {
    if !tools::have(&["yosys"]) {
        return;
    }
    let queue = |outside| queue::Config { on_chip: 512, outside, latency: 9, screen: SCREEN };
    let (_, without) = area::<Queue>(&queue(0));
    let (_, with) = area::<Queue>(&queue(16384));
    let [without, with] = [without, with].map(|area| area.parts[0].cells);
    assert_eq!(with.half_rams, without.half_rams);
    // A pixel's number of 12 bits, 24 bits of depth and 32 of colour.
    assert_eq!([with.memory_bits, without.memory_bits], [512 * 68; 2]);
}

#[test]
fn a_longer_sorter_has_a_longer_path() {
    if !tools::have(&["yosys"]) {
        return;
    }
    let path = |depth| area::<Sorter>(&sorter(depth)).1.longest_path;
    let [short, long] = [1, 4].map(path);
    assert!(0 < short && short < long, "{short} and {long} cells");
}
