use super::*;
use crate::config::Params;
use crate::test_util::{Pattern, behind::Behind, screen};
use pellucid_machine::params::Parameters;
use pellucid_sim::Sim;

/// A machine for more pixels, with planes outside.
fn large(settings: &[(&str, &str)]) -> Config {
    let mut params = Params::default();
    for (name, value) in [("planes", "outside")].iter().chain(settings) {
        params.set(name, value).unwrap();
    }
    Config::new(screen(20, 15), params).unwrap()
}

/// The cycles of each pass of an image, from the end of the one before to its own, beside a memory that takes a request a cycle and answers
/// after so many; with the words of each pixel that it reads and writes.
fn passes(cfg: Config, latency: u64) -> Vec<(u64, u32, bool)> {
    let mut sim = Sim::<Planes>::new(cfg);
    let mut memory = Behind::new(cfg.plane_port().words, Pattern::always(), vec![latency]);
    let (mut sent, mut shown, mut passes, mut begun) = (0, 0, vec![], 0);
    while shown < cfg.screen.pixels() {
        let cycle = sim.cycle();
        assert!(cycle < 200_000, "the image does not end");
        let comes = sim.moore().ready && sent < cfg.frames() * cfg.screen.pixels();
        sent += u32::from(comes);
        let frame = if comes { Stream::offer(sent % 1000) } else { Stream::idle() };
        let (pass, last) = (sim.state().pass.payload, sim.state().pixel);
        let shows = memory.shows(cycle);
        let out = sim.clock(In { frame, image_ready: true, memory: shows }).unwrap().out;
        memory.edge(cycle, out.request);
        shown += u32::from(out.image.valid);
        if last == cfg.screen.pixels() - 1 && sim.state().pixel == 0 {
            passes.push((cycle + 1 - begun, pass.reads.count_ones(), !pass.shows));
            begun = cycle + 1;
        }
    }
    passes
}

/// A cycle for each word, and one where a pixel has none; the latency of the port is waited for once in a pass, and where the pass writes, too,
/// its port is not idle meanwhile.
#[test]
fn a_pass_takes_a_cycle_for_each_word() {
    for settings in [
        &[("frames", "8")][..],
        &[("frames", "8"), ("schedule", "nodes")],
        &[("frames", "16"), ("branching", "4")],
        &[("frames", "4"), ("method", "buffer")],
        &[("frames", "4"), ("method", "blend")],
    ] {
        let cfg = large(settings);
        let pixels = u64::from(cfg.screen.pixels());
        for latency in [1, 16, 40] {
            let found = passes(cfg, latency);
            let nodes: u32 = (0..cfg.levels()).map(|k| cfg.tree.level(k).nodes).sum();
            let of_nodes = if cfg.has_top() { nodes } else { 0 };
            assert_eq!(found.len() as u32, cfg.frames() + of_nodes);
            let written: u32 = found.iter().map(|(_, _, writes)| u32::from(*writes)).sum();
            let read: u32 = found.iter().map(|(_, reads, _)| *reads).sum();
            assert_eq!((read, written), (found.len() as u32 - 1, found.len() as u32 - 1));
            for (cycles, reads, writes) in found {
                let words = (pixels * u64::from(reads + u32::from(writes))).max(pixels);
                let more = cycles - words;
                match (reads, writes) {
                    (0, _) => assert_eq!(more, 1),
                    (_, false) => assert_eq!(more, latency + 2, "{settings:?}"),
                    (_, true) => assert!(more <= latency + 2, "{settings:?}: {more}"),
                }
            }
        }
    }
}

/// With fewer reads in flight than the latency has cycles so many go in that time.
#[test]
fn reads_in_flight_cover_the_latency() {
    let settings = [("frames", "2"), ("reads_in_flight", "4")];
    let found = passes(large(&settings), 18);
    // The second pass reads a word for each of 300 pixels, four of them in 20 cycles; the last four come one after the other.
    assert_eq!(found[1], (300 / 4 * 20 + 4, 1, false));
}

#[test]
fn a_word_holds_a_colour() {
    let colours = [(8, 255), (16, 65_535), (21, 2_097_151), (22, 4_194_303), (24, 16_777_215)];
    for (bits, most) in colours {
        for of in [[most, 0, 0], [0, most, 0], [0, 0, most], [1, most - 2, 5]] {
            let [r, g, b] = of;
            let held = word(&bits, Colour { r, g, b });
            assert_eq!(colour(&bits, held), Colour { r, g, b }, "{bits} bits");
            let high_bits = (3 * bits).saturating_sub(64);
            assert_eq!(held.high >> high_bits, 0, "{bits} bits");
        }
    }
}
