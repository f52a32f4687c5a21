//! Frame buffers in outside memory that a cache holds whole.

use crate::frames::Setup;
use pellucid_machine::Architecture;
use pellucid_machine::architecture::Parameterised;
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_sim::Label;

/// Frames through a machine of which every fragment finds its pixel in the cache: each line comes once, as pixels of an older frame are
/// never looked at, and goes once with each frame, whatever blends with its pixels; and each pixel comes as it is shown. The latency
/// costs no cycles.
///
/// # Panics
/// It is not so, or a run is not right.
pub fn lines_come_once(arch: &'static Architecture, parameters: &Parameterised) {
    const SCREEN: Screen = Screen { width: 32, height: 16, background: 0x10_20_30 };
    const FRAMES: u64 = 3;
    let frame: Vec<Fragment> = (0..4 * SCREEN.pixels())
        .map(|k| {
            let pixel = k * 391 % SCREEN.pixels();
            let alpha = if k % 5 == 0 { 0xff } else { 0x70 };
            let z = k * 7907 % 65_536;
            Fragment { x: pixel % 32, y: pixel / 32, z, rgba: k << 8 | alpha, label: Label::NONE }
        })
        .collect();
    let frames = vec![frame.clone(); FRAMES as usize];
    let cycles = [1, 64].map(|latency| {
        let mut parameters = parameters.clone();
        parameters.extend([
            ("framebuffer", "cached".to_string()),
            ("framebuffer_sets", "16".to_string()),
            ("outside_latency", latency.to_string()),
            ("reads_in_flight", (latency + 8).to_string()),
        ]);
        let setup = Setup::free(arch, SCREEN, parameters);
        let run = setup.run(&frames).unwrap();
        let verdict = setup.verdict(&run, &vec![setup.golden(&frame); FRAMES as usize]);
        assert!(verdict.is_right(), "{:?}", verdict.faults());
        let pixels = u64::from(SCREEN.pixels());
        assert_eq!(run.tally.figure("framebuffer_misses"), pixels / 8);
        assert_eq!(run.tally.figure("framebuffer_written_back"), FRAMES * pixels);
        let info = run.tally.memory("front.pixels.outside").unwrap().info;
        // Both banks are cleared after the reset.
        let words = [(1 + FRAMES) * pixels, (2 + FRAMES) * pixels];
        assert_eq!([info.reads, info.writes], words, "{latency}");
        run.tally.cycles.total
    });
    let [least, more] = cycles;
    assert!(more < least + least / 20, "{cycles:?}");
}
