//! Planes outside of the chip: frames are merged with what comes from there, word by word, and what is kept goes back.
//!
//! ```text
//!             +--------+                +-------+
//!  frame ---->| frames |--------------->|       |---> image (pixels)
//!  (colours)  +--------+                | nodes |
//!             +---------+   operands    |       |
//!  memory --->| answers |-------------->|       |
//!             +---------+               +-------+
//!             +------+     reads ahead      | means
//!  request <--| Skid |<---------------------+
//!             +------+
//! ```
//! A plane has a word for each pixel, and they lie one behind the other: the top, if there is one, then those of each level. A frame
//! is a pass over the screen, and with `schedule=nodes` so is each node. A pass is known before its pixels are: it reads the same planes for each,
//! from the lowest level on, and writes one, unless it gives the image. Its reads are asked for ahead of the pixels, as many as
//! [`reads_in_flight`](crate::config::Params::reads_in_flight) says, and a word is merged in each cycle in which one is there.
//!
//! A pixel takes as many cycles of the port as it has words, and one where it has none; at a level that a shorter tree leaves without a word one
//! more. The first word of a pass comes `L + 3` cycles after the last pixel of the one before, where `L` is the latency of the port.

use crate::colour::{Colour, Format, Pixel, unpacked};
use crate::config::Config;
use crate::level::{Fill, edges, swept};
use crate::node::{MOST_INPUTS, mean};
use crate::sums;
use crate::tree::MOST_LEVELS;
use pellucid_blocks::skid::{self, Skid};
use pellucid_machine::outside::{self, Request, Word};
use pellucid_machine::pixel::COLOUR_BITS;
use pellucid_sim::{Block, Fifo, Label, Memory, Signals, Stream, bits_for, fifo, rtl};

pub mod pass;

use pass::{Pass, Top, of_sums, of_tree};

/// See the module's description.
pub struct Planes;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// How far the nodes of each level are.
    #[with(*cfg.tree.level(k as u32))]
    #[len(cfg.levels())]
    pub levels: [Fill; MOST_LEVELS],
    /// The frame that comes next, by number within its image.
    #[width(cfg.frame_bits())]
    pub frame: u32,
    /// What waits in the top.
    #[with(*cfg)]
    #[exists(cfg.has_top())]
    pub top: Stream<Top>,
    /// The pass at hand.
    #[with(*cfg)]
    pub pass: Stream<Pass>,
    /// The pixel whose words are asked for; none if all were.
    #[with(cfg.screen.pixel_bits())]
    pub asked: Stream<u32>,
    /// The planes of which it lacks one.
    #[width(cfg.planes())]
    pub left: u32,
    /// Words that were asked for and not merged.
    #[width(bits_for(u64::from(cfg.params.reads_in_flight)))]
    pub owed: u32,
    /// The pixel that is merged.
    #[width(cfg.screen.pixel_bits())]
    pub pixel: u32,
    /// The level at which it is.
    #[width(cfg.level_bits())]
    #[exists(cfg.levels() > 1)]
    pub level: u32,
    /// Operands that came for its node there.
    #[width(bits_for(u64::from(cfg.operands())))]
    #[exists(cfg.operands() > 0)]
    pub have: u32,
    /// These, but for the last.
    #[with(cfg.channel_bits())]
    #[len(cfg.operands())]
    pub operands: [Colour; MOST_INPUTS],
    /// What came of the levels below.
    #[with(cfg.channel_bits())]
    #[exists(cfg.levels() > 1 || cfg.has_top())]
    pub mean: Stream<Colour>,
    /// Pixels of a frame.
    #[with(FRAMES.depth)]
    #[block(Fifo<u32>, FRAMES)]
    pub frames: fifo::State,
    /// Words that came.
    #[with(cfg.answers().depth)]
    #[block(Fifo<Colour>, cfg.answers())]
    pub answers: fifo::State,
    /// A request that was not taken.
    #[with(cfg.plane_port())]
    #[block(Skid<Request>, cfg.plane_port())]
    pub requests: skid::State<Request>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A pixel of a frame, `0xRRGGBB`, only while `ready`.
    #[with(COLOUR_BITS)]
    pub frame: Stream<u32>,
    /// The image can take a pixel.
    pub image_ready: bool,
    /// What the outside memory shows.
    #[with(cfg.plane_port())]
    pub memory: outside::In,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Moore {
    /// A pixel of a frame is taken.
    pub ready: bool,
    /// A pixel is under way.
    pub busy: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// A pixel of the image; its channels have 8 bits.
    #[with(cfg.pixel())]
    pub image: Stream<Pixel>,
    /// Levels whose node gives its result.
    #[width(cfg.levels())]
    pub merges: u32,
    /// Levels whose node gives the last pixel of it.
    #[width(cfg.levels())]
    pub merged: u32,
    /// That node of each level, by number.
    #[width(cfg.tree.level(k as u32).number_bits())]
    #[len(cfg.levels())]
    pub nodes: [u32; MOST_LEVELS],
    /// A node's own sweep goes on by a pixel.
    pub sweeps: bool,
    /// What is asked of the memory.
    #[with(cfg.plane_port())]
    pub request: Stream<Request>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Pixels of a frame.
    #[block(Fifo<u32>, FRAMES)]
    pub frames: <Fifo<u32> as Block>::Mem,
    /// Words that came.
    #[block(Fifo<Colour>, cfg.answers())]
    pub answers: <Fifo<Colour> as Block>::Mem,
}

/// Pixels of a frame that wait, so that one can come in each cycle.
const FRAMES: fifo::Config<u32> = fifo::Config { depth: 2, item: COLOUR_BITS };

impl Config {
    fn answers(&self) -> fifo::Config<u32> {
        fifo::Config { depth: self.params.reads_in_flight, item: self.channel_bits() }
    }
    /// Bits of a level's number.
    pub(super) fn level_bits(&self) -> u32 {
        if self.levels() < 2 { 0 } else { bits_for(u64::from(self.levels() - 1)) }
    }
    pub(super) fn plane_number_bits(&self) -> u32 {
        if self.planes() < 2 { 0 } else { bits_for(u64::from(self.planes() - 1)) }
    }
    /// Operands that wait for another one.
    fn operands(&self) -> u32 {
        let most = (0..self.levels()).map(|k| self.tree.level(k).planes()).max();
        most.map_or(0, |planes| planes - 1)
    }
    fn pixel(&self) -> Format {
        let pixel_bits = self.screen.pixel_bits();
        Format { pixel_bits, channel_bits: self.channel_bits(), closes: true }
    }
}

/// A colour as a word: red uppermost, of channels of so many bits.
#[inline(always)]
#[rtl]
fn word(bits: &u32, colour: Colour) -> Word {
    let (r, g, b) = (u64::from(colour.r), u64::from(colour.g), u64::from(colour.b));
    let mut high = 0;
    if 3 * *bits > u64::BITS {
        high = r >> (u64::BITS - 2 * *bits);
    }
    Word { low: r << (2 * *bits) | g << *bits | b, high, label: Label::NONE }
}

/// The colour that a word holds.
#[inline(always)]
#[rtl]
fn colour(bits: &u32, word: Word) -> Colour {
    let mask = (1u64 << *bits) - 1;
    let mut r = word.low >> (2 * *bits);
    if 3 * *bits > u64::BITS {
        r |= word.high << (u64::BITS - 2 * *bits);
    }
    Colour {
        r: (r & mask) as u32,
        g: (word.low >> *bits & mask) as u32,
        b: (word.low & mask) as u32,
    }
}

type Frames = Fifo<u32>;
type Answers = Fifo<Colour>;
type Requests = Skid<Request>;

#[rtl(
    check(Planes, crate::test_util::outside(&[("frames", "4")])),
    check(Planes, crate::test_util::outside(&[("frames", "8"), ("branching", "2,4"), ("schedule", "nodes")])),
    check(Planes, crate::test_util::outside(&[("frames", "5"), ("weights", "triangle"), ("branching", "4")])),
    check(Planes, crate::test_util::outside(&[("frames", "3"), ("method", "buffer"), ("sum_bits", "24")])),
    check(Planes, crate::test_util::outside(&[("frames", "3"), ("method", "blend")]))
)]
impl Block for Planes {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State {
            levels: [Fill::NONE; MOST_LEVELS],
            frame: 0,
            top: Stream::idle(),
            pass: Stream::idle(),
            asked: Stream::idle(),
            left: 0,
            owed: 0,
            pixel: 0,
            level: 0,
            have: 0,
            operands: [Colour::default(); MOST_INPUTS],
            mean: Stream::idle(),
            frames: Frames::reset(&FRAMES),
            answers: Answers::reset(&cfg.answers()),
            requests: Requests::reset(&cfg.plane_port()),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let frames = Frames::moore(&FRAMES, &q.frames, &m.frames);
        let mut busy = frames.front.valid || q.pixel != 0;
        if cfg.has_top() {
            busy |= q.top.valid;
        }
        Moore { ready: frames.ready, busy }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let bits = cfg.channel_bits();
        let frame = Frames::moore(&FRAMES, &q.frames, &m.frames).front;
        let answer = Answers::moore(&cfg.answers(), &q.answers, &m.answers).front;
        let free = Requests::moore(&cfg.plane_port(), &q.requests, &()).ready;
        let pass = q.pass.payload;
        let last = q.pixel == cfg.screen.pixels() - 1;

        // What comes to the level at hand, and what it gives.
        let mut value = Stream {
            valid: frame.valid && !pass.own,
            payload: unpacked(&cfg.fraction_bits(), frame.payload),
        };
        if cfg.levels() > 0 && q.mean.valid {
            value = q.mean;
        }
        // Where what is complete goes has room for it.
        let room = q.pass.valid && if pass.shows { i.image_ready } else { free };
        let (mut merges, mut takes, mut through) = (0, false, false);
        let mut nodes = [0; MOST_LEVELS];
        let mut result = value.payload;
        if cfg.levels() > 0 {
            if room && pass.own && !q.mean.valid {
                // What waits in the top is its node's last input.
                takes = answer.valid;
                d.mean = answer;
            } else if room && value.valid {
                through = q.level == pass.to;
                for k in 0..cfg.levels() {
                    let level = cfg.tree.level(k);
                    let Fill { filled, number, edges } = q.levels[k as usize];
                    nodes[k as usize] = number;
                    if k == q.level && !through && (answer.valid || filled == 0) {
                        takes = filled > 0;
                        if filled > q.have + 1 {
                            d.have = q.have + 1;
                            for plane in 0..level.planes() - 1 {
                                if plane == q.have {
                                    d.operands[plane as usize] = answer.payload;
                                }
                            }
                        } else {
                            // Inputs that lack have weight zero, whatever they are.
                            let mut of = [value.payload; MOST_INPUTS];
                            for plane in 0..level.planes() {
                                if plane < filled {
                                    of[plane as usize] = answer.payload;
                                    if plane < q.have {
                                        of[plane as usize] = q.operands[plane as usize];
                                    }
                                }
                            }
                            result = mean(&level.node, of, edges);
                            merges = 1 << k;
                            d.have = 0;
                            if k + 1 < cfg.levels() {
                                d.level = k + 1;
                            }
                            d.mean = Stream::offer(result);
                        }
                    }
                }
                through |= merges != 0 && q.level + 1 == pass.to;
            }
        } else if room && value.valid && (pass.reads == 0 || answer.valid) {
            takes = pass.reads != 0;
            through = true;
            let below = if takes { answer.payload } else { Colour { r: 0, g: 0, b: 0 } };
            result = sums::sum(&cfg.sums, below, value.payload);
            if pass.closes {
                result = sums::image(&cfg.sums, result);
            }
        }

        // What is complete goes.
        let mut push = Stream::idle();
        if through {
            if cfg.levels() > 0 {
                d.level = pass.from;
                d.mean.valid = false;
            }
            d.pixel = if last { 0 } else { q.pixel + 1 };
            if !pass.shows {
                let address = pass.writes * cfg.screen.pixels() + q.pixel;
                push = Stream::offer(Request { write: true, address, word: word(&bits, result) });
            }
        }
        let payload = Pixel { pixel: q.pixel, closes: pass.closes, colour: result };
        let image = Stream { valid: through && pass.shows, payload };

        // Words are asked for ahead.
        let asks = q.asked.valid && free && !push.valid && q.owed < cfg.params.reads_in_flight;
        if asks {
            let plane = q.left.trailing_zeros();
            let address = plane * cfg.screen.pixels() + q.asked.payload;
            push = Stream::offer(Request { write: false, address, word: Word::default() });
            let others = q.left & q.left.wrapping_sub(1);
            d.left = others;
            if others == 0 {
                d.left = pass.reads;
                d.asked.payload = q.asked.payload + 1;
                if q.asked.payload == cfg.screen.pixels() - 1 {
                    d.asked = Stream::idle();
                }
            }
        }
        d.owed = (q.owed + u32::from(asks)).saturating_sub(u32::from(takes));

        // A pass ends, and the next one begins.
        if through && last {
            d.pass.valid = false;
            let tops = cfg.has_top() && pass.to < cfg.levels() && pass.writes == 0;
            for k in 0..cfg.levels() {
                let merged = k >= pass.from && k < pass.to;
                if merged || (k == pass.to && !tops) {
                    d.levels[k as usize] =
                        swept(cfg.tree.level(k), q.levels[k as usize], merged, pass.closes);
                }
            }
            if !pass.own {
                d.frame = if pass.closes { 0 } else { q.frame + 1 };
            }
            if cfg.has_top() {
                d.top = Stream::idle();
                if tops {
                    d.top = Stream::offer(Top { level: pass.to, closes: pass.closes });
                }
            }
        }
        if !q.pass.valid {
            let next = if cfg.levels() > 0 {
                of_tree(cfg, q.levels, q.frame, q.top)
            } else {
                of_sums(cfg, q.frame)
            };
            d.pass = Stream::offer(next);
            d.level = next.from;
            d.left = next.reads;
            d.asked = Stream { valid: next.reads != 0, payload: 0 };
            for k in 0..cfg.levels() {
                let level = cfg.tree.level(k);
                d.levels[k as usize].edges = edges(level, q.levels[k as usize].number);
            }
        }

        let to_frames = fifo::In { push: i.frame, pop: through && !pass.own };
        Frames::next(&FRAMES, &q.frames, &mut d.frames, &mut m.frames, to_frames);
        let came = i.memory.response;
        let push_answer = Stream { valid: came.valid, payload: colour(&bits, came.payload) };
        let to_answers = fifo::In { push: push_answer, pop: takes };
        Answers::next(&cfg.answers(), &q.answers, &mut d.answers, &mut m.answers, to_answers);
        let to_requests = skid::In { push, taken: i.memory.ready };
        let request =
            Requests::next(&cfg.plane_port(), &q.requests, &mut d.requests, &mut (), to_requests);
        let sweeps = through && pass.own;
        let merged = if last { merges } else { 0 };
        Out { image, merges, merged, nodes, sweeps, request }
    }
}

#[cfg(test)]
mod tests;
