use super::*;
use crate::cached_table::Cached;
use crate::test_util::{Behind, Pattern, Source, pattern, screen};
use pellucid_machine::outside::{self, Word};
use pellucid_machine::pixel::{Z_FAR, blend, is_opaque, rgba};
use pellucid_sim::{ReadPort, Sim, StreamMonitor, WritePort};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use std::collections::VecDeque;

/// Few pixels, with lines of `line` pixels and so many reads in flight.
pub(super) fn config(line: u32, reads_in_flight: u32) -> Config {
    Config::new(screen(5, 3), Cached { sets: 2, ways: 2, line }, reads_in_flight, 3)
}

const PIXELS: u32 = 15;

/// A pixel that is resolved: whether its fragments arrive, and which of them are visible.
#[derive(Clone, Debug)]
struct Visit {
    pixel: u32,
    visible: Vec<bool>,
}

/// A fragment that comes again: its pixel, and what that holds from then on, where it changes.
type Return = (u32, Option<Pixel>);

/// A frame: fragments that come, pixels that are resolved then, in rising order, and fragments that come again instead.
#[derive(Clone, Debug, Default)]
struct Frame {
    fragments: Vec<Fragment>,
    visits: Vec<Visit>,
    returns: Vec<Return>,
}

/// When what is offered, taken and answered.
#[derive(Clone, Debug)]
struct Pace {
    starts: Pattern,
    passed: Pattern,
    taken: Pattern,
    arrives: Pattern,
    shown: Pattern,
}

/// What a frame comes to.
#[derive(Debug, Default, PartialEq)]
struct Result {
    passed: Vec<Marked<PixelFragment>>,
    drawn: u32,
    hidden: u32,
    culled: u32,
    /// Depth of each pixel that is resolved, in order.
    depths: Vec<u32>,
    /// Colours that the blender finds, in order.
    below: Vec<u32>,
    /// What the pixel holds of each fragment that comes again, in order.
    found: Vec<Pixel>,
    image: Vec<u32>,
}

/// What a pixel of number `pixel` becomes once it is blended.
fn blended(pixel: u32) -> u32 {
    0xab_00_00 | pixel
}

/// A frame as plain loops.
fn reference(cfg: &Config, frame: &Frame) -> Result {
    let background = cfg.screen.background;
    let mut r = Result { image: vec![background; PIXELS as usize], ..Result::default() };
    let mut depth = [Z_FAR; PIXELS as usize];
    for f in &frame.fragments {
        let pixel = f.y * cfg.screen.width + f.x;
        let at = pixel as usize;
        let nearer = f.z < depth[at];
        match (is_opaque(f.rgba), nearer) {
            (true, true) => {
                (depth[at], r.image[at]) = (f.z, f.rgba >> 8);
                r.drawn += 1;
            }
            (true, false) => r.hidden += 1,
            (false, true) => {
                let Fragment { z, rgba, label, .. } = *f;
                if cfg.composes() {
                    r.image[at] = blend(rgba, r.image[at]);
                }
                r.passed.push(Marked::item(PixelFragment { pixel, z, rgba, label }));
            }
            (false, false) => r.culled += 1,
        }
    }
    r.passed.push(Marked::end());
    for Visit { pixel, visible } in &frame.visits {
        r.depths.push(depth[*pixel as usize]);
        if visible.contains(&true) {
            r.below.push(r.image[*pixel as usize]);
            r.image[*pixel as usize] = blended(*pixel);
        }
    }
    for (pixel, becomes) in &frame.returns {
        let at = *pixel as usize;
        r.found.push(Pixel { depth: depth[at], colour: r.image[at] });
        if let Some(Pixel { depth: z, colour }) = becomes {
            (depth[at], r.image[at]) = (*z, *colour);
        }
    }
    r
}

/// Plays frames, each of which is shown while the next one comes; gives what they came to, and in how many cycles each was
/// stored.
fn play(cfg: Config, frames: &[Frame], memory: Behind, pace: &Pace) -> (Vec<Result>, Vec<u64>) {
    let mut sim = Sim::<Pixels>::new(cfg);
    let mut memory = memory;
    let mut to_memory = StreamMonitor::new("request", "pixels", "memory");
    let mut passing = StreamMonitor::new("passed", "pixels", "test");
    let mut images = vec![];
    let mut image = StreamMonitor::new("image", "pixels", "test");
    let nothing = In {
        storing: false,
        fragment: Stream::idle(),
        passed_ready: true,
        stored: false,
        resolve: Resolve::default(),
        revisit: Revisit::default(),
        colour_read: ReadPort::default(),
        colour_write: WritePort::default(),
        clearing: false,
        clear: Stream::idle(),
        show: false,
        image_ready: true,
        memory: outside::In::default(),
    };
    let mut step = |sim: &mut Sim<Pixels>, i: In| -> Out {
        let cycle = sim.cycle();
        assert!(cycle < 100_000, "it does not end");
        let i = In { memory: memory.shows(cycle), image_ready: pace.shown.at(cycle), ..i };
        let seen = sim.moore();
        image.observe(seen.image.with(i.image_ready)).unwrap();
        images.extend((seen.image.valid && i.image_ready).then_some(seen.image.payload));
        let out = sim.clock(i).unwrap().out;
        to_memory.observe(out.request.with(i.memory.ready)).unwrap();
        memory.edge(cycle, out.request);
        out
    };
    let mut pixel = 0;
    while pixel < PIXELS {
        let ready = sim.moore().clear_ready;
        step(&mut sim, In { clearing: true, clear: Stream::offer(pixel), ..nothing });
        pixel += u32::from(ready);
    }
    while !sim.moore().drained {
        step(&mut sim, In { clearing: true, ..nothing });
    }
    let (mut results, mut cycles) = (vec![], vec![]);
    for frame in frames {
        let mut r = Result::default();
        // Store.
        let items = frame.fragments.iter().copied().map(Marked::item).chain([Marked::end()]);
        let mut source = Source::new(items, pace.starts.clone());
        let first = sim.cycle();
        while r.passed.last() != Some(&Marked::end()) {
            let cycle = sim.cycle();
            let seen = sim.moore();
            let (fragment, passed_ready) = (source.offer(cycle), pace.passed.at(cycle));
            source.edge(seen.ready);
            passing.observe(seen.passed.with(passed_ready)).unwrap();
            let Marked { end, item } = seen.passed.payload;
            let passed = if end { Marked::end() } else { Marked::item(item) };
            r.passed.extend((seen.passed.valid && passed_ready).then_some(passed));
            let stored = r.passed.last() == Some(&Marked::end());
            let i = In { storing: true, fragment, passed_ready, stored, ..nothing };
            let out = step(&mut sim, i);
            r.drawn += u32::from(out.drawn);
            r.hidden += u32::from(out.hidden);
            r.culled += u32::from(out.culled);
        }
        cycles.push(sim.cycle() - first);
        // Fragments come again: those that went on wait for their pixels.
        let again = |&(pixel, _): &Return| {
            Marked::item(PixelFragment { pixel, ..PixelFragment::default() })
        };
        let items = frame.returns.iter().map(again).chain([Marked::end()]);
        let mut source = Source::new(items, pace.taken.clone());
        let mut wait = VecDeque::new();
        let mut ended = !cfg.revisits();
        while !ended || !wait.is_empty() {
            let cycle = sim.cycle();
            let seen = sim.moore();
            let mut i = nothing;
            i.revisit.on = true;
            i.revisit.fragment = source.offer(cycle);
            source.edge(seen.ready);
            i.passed_ready = wait.len() < 4 && pace.passed.at(cycle);
            if let Some(&pixel) = wait.front()
                && seen.pixel.valid
                && pace.arrives.at(cycle)
            {
                let (expected, becomes) = frame.returns[r.found.len()];
                assert_eq!(pixel, expected);
                i.revisit.taken = true;
                if let Some(payload) = becomes {
                    i.revisit.write = Stream::offer(payload);
                }
                r.found.push(seen.pixel.data);
                wait.pop_front();
            }
            if seen.passed.valid && i.passed_ready {
                let Marked { end, item } = seen.passed.payload;
                ended |= end;
                wait.extend((!end).then_some(item.pixel));
            }
            step(&mut sim, i);
        }
        if cfg.revisits() {
            let mut i = nothing;
            i.revisit.over = true;
            step(&mut sim, i);
        }
        // Resolve: pixels are asked for, their fragments arrive, and the visible ones' are blended two cycles later.
        let (mut asked, mut taken) = (0, 0);
        let mut arriving: VecDeque<(u32, bool, bool)> = VecDeque::new();
        let mut sorted: VecDeque<u32> = VecDeque::new();
        let (mut reading, mut writing) = (None, None);
        let mut started = None;
        loop {
            let cycle = sim.cycle();
            let Moore { resolve, depth, colour, .. } = sim.moore();
            let mut i = nothing;
            if let Some(visit) = frame.visits.get(asked) {
                i.resolve.ask = Stream { valid: resolve.ready, payload: visit.pixel };
                asked += usize::from(resolve.ready);
            }
            if depth.valid && pace.taken.at(cycle) {
                let Visit { pixel, visible } = &frame.visits[taken];
                i.resolve.taken = true;
                i.resolve.kept = !visible.is_empty();
                r.depths.push(depth.data);
                let last = visible.len().wrapping_sub(1);
                arriving.extend(visible.iter().enumerate().map(|(k, v)| (*pixel, *v, k == last)));
                taken += 1;
            }
            if let Some(pixel) = writing.take() {
                i.colour_write.write(pixel, blended(pixel));
            }
            if let Some(pixel) = reading.take() {
                r.below.push(colour.data);
                writing = Some(pixel);
            }
            if resolve.colour_ready
                && let Some(pixel) = sorted.pop_front()
            {
                i.colour_read.read(pixel);
                reading = Some(pixel);
            }
            // Those that came by the cycle before.
            if resolve.open
                && resolve.there
                && pace.arrives.at(cycle)
                && let Some(next) = arriving.front().copied()
            {
                if i.resolve.kept && arriving.len() == frame.visits[taken - 1].visible.len() {
                    // Just taken: not yet.
                } else {
                    arriving.pop_front();
                    let (pixel, visible, last) = next;
                    (i.resolve.comes, i.resolve.visible, i.resolve.last) = (true, visible, last);
                    if visible && started != Some(pixel) {
                        sorted.push_back(pixel);
                        started = Some(pixel);
                    }
                }
            }
            let done = taken == frame.visits.len() && arriving.is_empty() && sorted.is_empty();
            let done = done && reading.is_none() && writing.is_none() && !i.resolve.comes;
            step(&mut sim, i);
            if done {
                break;
            }
        }
        while sim.moore().busy || !sim.moore().drained {
            step(&mut sim, nothing);
        }
        step(&mut sim, In { show: true, ..nothing });
        results.push(r);
    }
    while sim.moore().busy {
        step(&mut sim, nothing);
    }
    for (r, shown) in results.iter_mut().zip(images.chunks(PIXELS as usize)) {
        r.image = shown.to_vec();
    }
    (results, cycles)
}

/// A memory whose words are without meaning at first: one that is read before it is written has too many bits.
fn memory(cfg: &Config, ready: Pattern, latencies: Vec<u64>) -> Behind {
    let mut memory = Behind::new(cfg.port().words, ready, latencies);
    memory.words.fill(Word { low: u64::MAX, ..Word::default() });
    memory
}

fn always() -> Pace {
    let p = Pattern::always;
    Pace { starts: p(), passed: p(), taken: p(), arrives: p(), shown: p() }
}

fn fragments() -> impl Strategy<Value = Vec<Fragment>> {
    let alpha = prop_oneof![Just(255u8), 0u8..255];
    let z = prop_oneof![0u32..6, Just(Z_FAR), Just(Z_FAR - 1)];
    let fragment = (0..5u32, 0..3u32, z, alpha, any::<u8>()).prop_map(|(x, y, z, a, red)| {
        Fragment { x, y, z, rgba: rgba(red, 1, 2, a), ..Fragment::default() }
    });
    proptest::collection::vec(fragment, 0..50)
}

fn returns() -> impl Strategy<Value = Vec<Return>> {
    let pixel = (0..=Z_FAR, 0..1u32 << 24).prop_map(|(depth, colour)| Pixel { depth, colour });
    proptest::collection::vec((0..PIXELS, proptest::option::of(pixel)), 0..60)
}

fn frame() -> impl Strategy<Value = Frame> {
    let visible = proptest::collection::vec(any::<bool>(), 0..4);
    let pixels = proptest::sample::subsequence((0..PIXELS).collect::<Vec<_>>(), 0..=15);
    (fragments(), pixels, proptest::collection::vec(visible, 15)).prop_map(
        |(fragments, pixels, visible)| {
            let visits = pixels.into_iter().zip(visible);
            let visits = visits.map(|(pixel, visible)| Visit { pixel, visible }).collect();
            Frame { fragments, visits, returns: vec![] }
        },
    )
}

fn pace() -> impl Strategy<Value = Pace> {
    (pattern(), pattern(), pattern(), pattern(), pattern()).prop_map(
        |(starts, passed, taken, arrives, shown)| Pace { starts, passed, taken, arrives, shown },
    )
}

/// The cache of a frame buffer, and what is around it.
#[derive(Clone, Debug)]
struct Around {
    cached: Cached,
    reads_in_flight: u32,
    ready: Pattern,
    latencies: Vec<u64>,
    pace: Pace,
}

impl Around {
    fn config(&self, blended: u32) -> Config {
        Config::new(screen(5, 3), self.cached, self.reads_in_flight, blended)
    }

    /// Frames come to what plain banks make of them.
    fn holds(&self, cfg: Config, frames: &[Frame]) -> TestCaseResult {
        let memory = memory(&cfg, self.ready.clone(), self.latencies.clone());
        let (found, _) = play(cfg, frames, memory, &self.pace);
        let expected: Vec<Result> = frames.iter().map(|frame| reference(&cfg, frame)).collect();
        prop_assert_eq!(found, expected);
        Ok(())
    }
}

fn around() -> impl Strategy<Value = Around> {
    let latencies = proptest::collection::vec(1u64..30, 1..6);
    ((0u32..2, 0u32..2, 0u32..3), 2u32..9, pattern(), latencies, pace()).prop_map(
        |((sets, ways, line), reads_in_flight, ready, latencies, pace)| {
            let cached = Cached { sets: 1 << sets, ways: 1 << ways, line: 1 << line };
            Around { cached, reads_in_flight, ready, latencies, pace }
        },
    )
}

proptest! {
    /// Whatever comes, whoever waits, and however the memory takes and answers.
    #[test]
    fn behaves_as_plain_banks(
        frames in proptest::collection::vec(frame(), 1..4),
        around in around(),
    ) {
        let cfg = around.config(3);
        around.holds(cfg, &frames)?;
    }

    /// The same where fragments are blended as they come.
    #[test]
    fn composes_as_plain_banks(
        frames in proptest::collection::vec(fragments(), 1..4),
        around in around(),
    ) {
        let cfg = around.config(1).blending(Blends::Coming);
        let frames: Vec<Frame> =
            frames.into_iter().map(|fragments| Frame { fragments, ..Frame::default() }).collect();
        around.holds(cfg, &frames)?;
    }

    /// The same where they come again.
    #[test]
    fn revisits_plain_banks(
        frames in proptest::collection::vec((fragments(), returns()), 1..4),
        around in around(),
    ) {
        let cfg = around.config(1).blending(Blends::Revisiting);
        let frame = |(fragments, returns)| Frame { fragments, returns, ..Frame::default() };
        let frames: Vec<Frame> = frames.into_iter().map(frame).collect();
        around.holds(cfg, &frames)?;
    }
}

/// Where nothing is opaque nothing is read; fragments pass one a cycle, whatever the memory.
#[test]
fn transparent_fragments_of_pixels_that_hold_nothing_wait_for_none() {
    let fragments: Vec<Fragment> = (0..200u32)
        .map(|k| Fragment { x: k % 5, y: k / 5 % 3, z: k, rgba: 0x80, ..Fragment::default() })
        .collect();
    for latency in [1, 100] {
        let cfg = config(4, 2);
        let frame = Frame { fragments: fragments.clone(), ..Frame::default() };
        let memory = memory(&cfg, Pattern::always(), vec![latency]);
        let (_, cycles) = play(cfg, &[frame], memory, &always());
        // Three stages to fill and empty, and the end of the frame.
        assert_eq!(cycles, [200 + 4]);
    }
}

/// Fragments of a pixel that meet what one before them has left, one a cycle once the pixel is in the cache.
#[test]
fn fragments_of_one_pixel_see_each_other() {
    let fragments: Vec<Fragment> = (0..200u32)
        .map(|k| {
            let alpha = if k % 3 == 0 { 0xff } else { 0x80 };
            Fragment { x: 1, y: 1, z: 900 - k, rgba: k << 8 | alpha, ..Fragment::default() }
        })
        .collect();
    for latency in [1, 100] {
        let cfg = config(4, 2);
        let frame = Frame { fragments: fragments.clone(), ..Frame::default() };
        let memory = memory(&cfg, Pattern::always(), vec![latency]);
        let (found, cycles) = play(cfg, std::slice::from_ref(&frame), memory, &always());
        assert_eq!(found, [reference(&cfg, &frame)]);
        // The sets are forgotten before, and each that is written is shown again; the first waits for its line.
        let whole = 200 + 6 + latency;
        assert!((whole..whole + 8).contains(&cycles[0]), "{latency}: {cycles:?}");
    }
}
