//! How fast the memory is simulated: `cargo bench -p pellucid-dram`.
//!
//! The item is a device clock of one channel. `loaded` asks for a burst in every clock that takes one, `idle` for none.

use divan::{Bencher, counter::ItemsCount};
use pellucid_dram::{Config, Dram, Mapping, Part, Request};

fn main() {
    divan::main();
}

const CLOCKS: u64 = 1_000_000;

fn run(part: &str, mapping: Mapping, mut address: impl FnMut(u64) -> Option<(bool, u64)>) -> u64 {
    let config = Config { mapping, ..Config::new(Part::named(part).unwrap()) };
    let mut dram = Dram::new(config).unwrap();
    let mut bursts = 0;
    for _ in 0..CLOCKS {
        if dram.ready()
            && let Some((write, address)) = address(bursts)
        {
            dram.push(Request { write, address, tag: bursts as u32, client: 0 });
            bursts += 1;
        }
        dram.cycle();
        dram.pop();
    }
    bursts
}

/// Splitmix64: a cheap number for each burst, so that the memory is what is measured.
fn mixed(n: u64) -> u64 {
    let n = (n + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let n = (n ^ (n >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    n ^ (n >> 27)
}

#[divan::bench(args = Part::NAMES, sample_count = 5)]
fn loaded_random(bencher: Bencher, part: &str) {
    let address = |n| Some((mixed(n) >> 60 < 4, mixed(n) << 3));
    bencher
        .counter(ItemsCount::new(CLOCKS))
        .bench_local(|| run(part, Mapping::RowBankColumnGroup, address));
}

#[divan::bench(args = Part::NAMES, sample_count = 5)]
fn loaded_streaming(bencher: Bencher, part: &str) {
    let bytes = Part::named(part).unwrap().organisation.burst_bytes();
    let address = |n| Some((false, n * bytes));
    bencher
        .counter(ItemsCount::new(CLOCKS))
        .bench_local(|| run(part, Mapping::RowBankColumnGroup, address));
}

#[divan::bench(args = Part::NAMES, sample_count = 5)]
fn idle(bencher: Bencher, part: &str) {
    bencher
        .counter(ItemsCount::new(CLOCKS))
        .bench_local(|| run(part, Mapping::RowBankColumnGroup, |_| None));
}
