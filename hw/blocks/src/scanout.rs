//! Shows a finished frame: sends the back bank's colours pixel by pixel and leaves the bank wiped.
//!
//! ```text
//!             +---------+
//!  start ---->|         |---> image (Stream of colours)
//!  colour --->| Scanout |<--- image_ready
//!             |         |---> read, wipe (back bank)
//!  busy <-----+---------+
//! ```
//! One pixel a cycle, row by row from the top left; the first is offered three cycles after `start`. It
//! stalls with its receiver and loses nothing. Where the next frame covers every pixel, the bank stays as it is.

use pellucid_machine::pixel::{COLOUR_BITS, Screen};
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Memory, Read, ReadPort, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct Scanout;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// Pixels are wiped as they are shown.
    pub wipes: bool,
}

impl Config {
    /// Bits of a pixel that is wiped, 0 if none are.
    fn wipe_bits(&self) -> u32 {
        if self.wipes { self.screen.pixel_bits() } else { 0 }
    }
}

/// What it is at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
pub enum Fsm {
    /// Waiting for a frame.
    Idle,
    /// Reading pixels.
    Run,
    /// All pixels are read; the last ones leave.
    Drain,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What it is at.
    pub fsm: Fsm,
    /// The next pixel to read.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// The pixel whose colour was asked for: it arrives now and is wiped now.
    #[with(cfg.wipe_bits())]
    pub asked: Stream<u32>,
    /// Colours on their way out.
    #[with(QUEUE_DEPTH)]
    pub queue: fifo::State,
}

const QUEUE_DEPTH: u32 = 3;

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A frame is in the back bank from the next cycle on. Only while not `busy`.
    pub start: bool,
    /// The colour that was asked for.
    #[with(COLOUR_BITS)]
    pub colour: Read<u32>,
    /// The receiver takes a colour.
    pub image_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// The colours, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Stream<u32>,
    /// A frame is being shown.
    pub busy: bool,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads a colour of the back bank.
    #[with(cfg.screen.pixel_bits())]
    pub read: ReadPort,
    /// Wipes a pixel of the back bank.
    #[with(cfg.wipe_bits())]
    pub wipe: Stream<u32>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Colours on their way out.
    pub queue: <Queue as Block>::Mem,
}

type Queue = Fifo<u32>;

fn queue() -> fifo::Config<u32> {
    fifo::Config { depth: QUEUE_DEPTH, item: COLOUR_BITS }
}

#[rtl(
    check(Scanout, Config { screen: crate::test_util::screen(3, 2), wipes: true }),
    check(Scanout, Config { screen: crate::test_util::screen(3, 2), wipes: false })
)]
impl Block for Scanout {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        cfg.screen.check();
        let queue = Queue::reset(&queue());
        State { fsm: Fsm::Idle, pixel: 0, asked: Stream::idle(), queue }
    }

    fn memories(_: &Config) -> Mem {
        Mem { queue: Queue::memories(&queue()) }
    }

    fn moore(_: &Config, q: &State, m: &Self::Mem) -> Moore {
        let image = Queue::moore(&queue(), &q.queue, &m.queue).front;
        Moore { image, busy: q.fsm != Fsm::Idle }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let mut read = ReadPort::default();
        let queued = Queue::moore(&queue(), &q.queue, &m.queue).count;
        d.asked.valid = false;
        match q.fsm {
            Fsm::Idle => {
                if i.start {
                    d.fsm = Fsm::Run;
                    d.pixel = 0;
                }
            }
            Fsm::Run => {
                // What was asked for finds room, and so must what is asked for now.
                if queued + u32::from(q.asked.valid) < QUEUE_DEPTH {
                    read.read(q.pixel);
                    d.asked = Stream::offer(if cfg.wipes { q.pixel } else { 0 });
                    if q.pixel == cfg.screen.pixels() - 1 {
                        d.fsm = Fsm::Drain;
                    } else {
                        d.pixel = q.pixel + 1;
                    }
                }
            }
            Fsm::Drain => {
                if queued == 0 && !q.asked.valid {
                    d.fsm = Fsm::Idle;
                }
            }
        }
        let push = Stream { valid: q.asked.valid, payload: i.colour.data };
        let to_queue = fifo::In { push, pop: i.image_ready };
        Queue::next(&queue(), &q.queue, &mut d.queue, &mut m.queue, to_queue);
        Out { read, wipe: Stream { valid: cfg.wipes && q.asked.valid, payload: q.asked.payload } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::{Pattern, contents, edge, holding, pattern, screen};
    use pellucid_sim::{Ram1R1W, ReadDuringWrite, Sim, StreamMonitor};
    use proptest::prelude::*;

    const WIPED: u32 = 0xff_ffff;

    /// A scanout beside the back bank that it shows.
    struct Bench {
        sim: Sim<Scanout>,
        bank: Ram1R1W<u32>,
        cycle: u64,
    }

    impl Bench {
        fn new(width: u32, height: u32, wipes: bool) -> Bench {
            let cfg = Config { screen: screen(width, height), wipes };
            let wiped = vec![WIPED; cfg.screen.pixels() as usize];
            let bank = holding(&wiped, COLOUR_BITS, ReadDuringWrite::Forbidden);
            Bench { sim: Sim::new(cfg), bank, cycle: 0 }
        }

        /// Draws `frame` into the bank and shows it; gives what came out, with its cycles.
        fn show(&mut self, frame: &[u32], ready: &Pattern) -> Vec<(u64, u32)> {
            for (pixel, colour) in frame.iter().enumerate() {
                self.bank.write(pixel as u32, *colour);
                edge(&mut self.bank);
            }
            let (mut shown, mut wiped) = (vec![], vec![]);
            let mut monitor = StreamMonitor::new("image", "Scanout", "test");
            assert!(!self.sim.moore().busy);
            let began = self.cycle;
            while self.cycle == began || self.sim.moore().busy {
                assert!(self.cycle < began + 10_000, "the frame does not end");
                let seen = self.sim.moore();
                let image = seen.image.with(ready.at(self.cycle));
                monitor.observe(image).unwrap();
                assert!(seen.busy || !image.valid, "an image goes out while it is not busy");
                shown.extend(image.fires().then_some((self.cycle, image.payload)));
                let i = In {
                    start: self.cycle == began,
                    colour: self.bank.q(),
                    image_ready: image.ready,
                };
                let out = self.sim.clock(i).unwrap().out;
                self.bank.pass_read(out.read);
                if out.wipe.valid {
                    // The bank shows the pixel that was asked for in the cycle before.
                    let pixel = out.wipe.payload;
                    assert_eq!(
                        self.bank.q().data,
                        frame[pixel as usize],
                        "wiped before it was read"
                    );
                    self.bank.write(pixel, WIPED);
                    wiped.push(pixel);
                }
                edge(&mut self.bank);
                self.cycle += 1;
            }
            let pixels = frame.len() as u32;
            let left = contents(&mut self.bank, pixels);
            if self.sim.config().wipes {
                assert_eq!(wiped, (0..pixels).collect::<Vec<_>>());
                assert_eq!(left, vec![WIPED; frame.len()]);
            } else {
                assert_eq!((wiped, &left[..]), (vec![], frame));
            }
            shown
        }
    }

    /// Colours that tell pixels and frames apart.
    fn frame(pixels: u32, number: u32) -> Vec<u32> {
        (0..pixels).map(|pixel| number << 16 | pixel).collect()
    }

    #[test]
    fn one_pixel_a_cycle() {
        let mut bench = Bench::new(5, 3, true);
        let shown = bench.show(&frame(15, 1), &Pattern::always());
        let first = shown[0].0;
        let expected: Vec<(u64, u32)> =
            (0..15).map(|k| (first + u64::from(k), 0x1_0000 | k)).collect();
        assert_eq!(shown, expected);
    }

    #[test]
    fn a_screen_of_one_pixel() {
        let mut bench = Bench::new(1, 1, true);
        assert_eq!(bench.show(&[0x12_34_56], &Pattern::always())[0].1, 0x12_34_56);
    }

    #[test]
    fn without_a_start_nothing_moves() {
        let mut sim = Sim::<Scanout>::new(Config { screen: screen(2, 2), wipes: true });
        for _ in 0..10 {
            let i = In { start: false, colour: Read::default(), image_ready: true };
            let out = sim.clock(i).unwrap().out;
            assert_eq!((out.read, out.wipe.valid), (ReadPort::default(), false));
            assert!(!sim.moore().busy && !sim.moore().image.valid);
        }
    }

    proptest! {
        /// One frame after the other, with a receiver that stalls at random.
        #[test]
        fn every_frame_is_shown_in_order(
            width in 1u32..6,
            height in 1u32..6,
            frames in 1u32..4,
            wipes in any::<bool>(),
            ready in pattern(),
        ) {
            let mut bench = Bench::new(width, height, wipes);
            for number in 1..=frames {
                let expected = frame(width * height, number);
                let shown: Vec<u32> =
                    bench.show(&expected, &ready).into_iter().map(|(_, colour)| colour).collect();
                prop_assert_eq!(shown, expected);
            }
        }
    }

    #[test]
    #[should_panic(expected = "the height of a screen is 0: expected 1 to 8192")]
    fn a_screen_without_rows_is_none() {
        Bench::new(3, 0, true);
    }
}
