//! What every architecture shows to the outside: frames of fragments or of primitives in, images out.

use crate::course;
use crate::depth_test;
use crate::display;
use crate::pixel::{COLOUR_BITS, Fragment, MAX_SIDE, Marked, Screen};
use crate::primitive::{Primitive, span};
use pellucid_sim::{
    Block, Deadlock, Figure, Handshake, Label, Netlist, Signals, StorageInfo, Stream,
    StreamMonitor, Violation, Wait, rtl,
};

/// What a machine is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum Phase {
    /// After reset: clearing its memories.
    #[default]
    Clear,
    /// Ready for a frame.
    Idle,
    /// Taking a frame's items.
    Store,
    /// Turning them into an image.
    Resolve,
    /// The image is done, but the one before is still being shown.
    Wait,
}

/// Inputs of a machine that takes fragments.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct Frame {
    /// A frame's fragments in arrival order, then its end.
    #[with(*cfg)]
    pub fragment: Stream<Marked<Fragment>>,
    /// The display takes a pixel.
    pub image_ready: bool,
}

/// Inputs of a machine that takes primitives.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct PrimitiveFrame {
    /// A frame's primitives in arrival order, then its end.
    #[with(*cfg)]
    pub primitive: Stream<Marked<Primitive>>,
    /// The display takes a pixel.
    pub image_ready: bool,
}

/// What a machine that takes fragments shows before its inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(())]
pub struct Shown {
    /// What it is at.
    pub phase: Phase,
    /// A fragment, or the end of a frame, is taken.
    pub ready: bool,
    /// What comes next is the same frame again: see [`Ports::replay`].
    pub replay: bool,
    /// The image, pixel by pixel, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Stream<u32>,
    /// An image is being shown.
    pub shows: bool,
}

/// What a machine of these blocks shows.
#[inline(always)]
#[rtl]
pub fn shown(
    course: course::Moore,
    depth_test: depth_test::Moore,
    display: display::Moore,
) -> Shown {
    Shown {
        phase: course.phase,
        ready: course.open && depth_test.ready,
        replay: course.replay,
        image: display.image,
        shows: display.busy,
    }
}

/// What a frame is made of.
pub trait Item: Copy + Default {
    /// Inputs of a machine that takes such items.
    type Frame: Copy;
    /// The inputs in which `item` is offered.
    fn frame(item: Stream<Marked<Self>>, image_ready: bool) -> Self::Frame;
    /// Labels it as number `number` of its frame, counted from 0.
    fn label(&mut self, number: u32);
}

impl Item for Fragment {
    type Frame = Frame;

    #[inline(always)]
    fn frame(fragment: Stream<Marked<Fragment>>, image_ready: bool) -> Frame {
        Frame { fragment, image_ready }
    }

    #[inline(always)]
    fn label(&mut self, number: u32) {
        self.label = Label::new(number, self.x as u16, self.y as u16);
    }
}

/// Its place is where it begins: the first column of its first row.
impl Item for Primitive {
    type Frame = PrimitiveFrame;

    #[inline(always)]
    fn frame(primitive: Stream<Marked<Primitive>>, image_ready: bool) -> PrimitiveFrame {
        PrimitiveFrame { primitive, image_ready }
    }

    #[inline(always)]
    fn label(&mut self, number: u32) {
        let first = span(self.edges, MAX_SIDE).first;
        self.label = Label::new(number, first as u16, self.row as u16);
    }
}

/// What the outside sees of a machine in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Ports {
    /// What it is at.
    pub phase: Phase,
    /// Whether the item that was offered is taken.
    pub item_ready: bool,
    /// The image goes out, pixel by pixel, `0xRRGGBB`.
    pub image: Handshake<u32>,
    /// What is to come next is the same frame again, from its first fragment. High from the end of a round
    /// of the frame until its first item comes again.
    pub replay: bool,
}

/// Says to which engine each item of a frame goes; asked once of each, in arrival order.
pub type Dealer<T> = Box<dyn FnMut(&T) -> u32>;

/// How a machine makes a pixel's colour of its fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// Far to near, rounded at each step: the exact blend.
    Blend,
    /// A sum of fragments, each weighted by its own alpha and by what the nearer ones let through, in the
    /// M-buffer's fixed point: close to the exact blend, not equal to it.
    Weights,
}

/// An architecture: a block that takes frames, with the monitor that watches it.
pub trait Machine:
    Netlist + Block<In = <<Self as Machine>::Item as Item>::Frame, Out: Signals>
{
    /// What its frames are made of.
    type Item: Item;
    /// Watches it.
    type Monitor: Monitor<Self>;
    /// How it makes colours.
    const ARITHMETIC: Arithmetic;
    /// Whether it may ask for a frame again: see [`Ports::replay`].
    fn replays(_: &Self::Config) -> bool {
        false
    }
    /// Where the machine has several engines for what is opaque, a new dealer for each call: of opaque fragments
    /// that are equally deep the one of the engine with the lower number is seen, of one engine's the one that
    /// arrived first. What it says of transparent items is without meaning.
    fn dealer(_: &Self::Config) -> Option<Dealer<Self::Item>> {
        None
    }
    /// What the outside sees.
    fn ports(out: &Self::Out) -> Ports;
    /// The screen.
    fn screen(cfg: &Self::Config) -> Screen;
    /// What a run must have counted, by the closed forms of the architecture's seed document, for
    /// frames of which every fragment found its place.
    fn closed_forms(cfg: &Self::Config, tally: &Tally, frames: &[Census]) -> Vec<Check>;
}

/// What is known of a frame without the machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// F: transparent fragments in front of the opaque depth at their arrival.
    pub stored: u64,
    /// `[i]` is N_i: pixels with exactly `i` of them.
    pub histogram: Vec<u64>,
}

impl Census {
    /// Several frames as one.
    pub fn together(frames: &[Census]) -> Census {
        let mut all = Census::default();
        for Census { stored, histogram } in frames {
            all.stored += stored;
            all.histogram.resize(all.histogram.len().max(histogram.len()), 0);
            for (sum, pixels) in all.histogram.iter_mut().zip(histogram) {
                *sum += pixels;
            }
        }
        all
    }

    /// For each number of fragments from 0 on: the pixels that have so many, and the number.
    pub fn layers(&self) -> impl Iterator<Item = (u64, u64)> {
        self.histogram.iter().copied().zip(0..)
    }

    /// P: pixels with at least one fragment.
    pub fn pixels(&self) -> u64 {
        self.histogram.iter().skip(1).sum()
    }
}

/// A figure that is known beforehand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Check {
    /// What it is.
    pub what: &'static str,
    /// What it must be.
    pub expected: u64,
    /// What the run counted.
    pub found: u64,
}

/// Watches a machine cycle by cycle: counts, and holds its streams to their rules.
pub trait Monitor<M: Machine + ?Sized>: Sized {
    /// A monitor that has seen nothing.
    fn new(cfg: &M::Config) -> Self;
    /// One cycle: the registers at its start and the wires during it.
    ///
    /// # Errors
    /// A stream broke its rules: a bug in a block.
    fn observe(&mut self, cfg: &M::Config, q: &M::State, out: &M::Out) -> Result<(), Violation>;
    /// A number that grows whenever something moves between blocks.
    fn transfers(&self) -> u64;
    /// Who waits for whom in the last cycle.
    fn deadlock(&self, cycle: u64, idle: u64, q: &M::State) -> Deadlock;
    /// What was counted, once the memories' traffic is known.
    fn tally(&self, cfg: &M::Config, memories: &[(String, StorageInfo)]) -> Tally;
}

/// What a stream's monitor has seen.
pub struct Seen {
    /// Its traffic.
    pub tally: StreamTally,
    /// Something was offered in the last cycle.
    pub valid: bool,
    /// The receiver was ready in the last cycle.
    pub ready: bool,
}

/// What a stream's monitor has seen.
pub fn seen<T>(monitor: &StreamMonitor<T>) -> Seen
where
    T: Copy + Default + PartialEq + std::fmt::Debug,
{
    let (valid, ready) = monitor.last();
    let StreamMonitor { name, from, to, transfers, stalls, .. } = *monitor;
    Seen { tally: StreamTally { name, from, to, transfers, stalls }, valid, ready }
}

/// Who waits for whom; `state` names the state of a block.
pub fn waits(streams: &[Seen], state: impl Fn(&str) -> &'static str) -> Vec<Wait> {
    let (mut senders, mut receivers) = (vec![], vec![]);
    for Seen { tally, valid, ready } in streams {
        let StreamTally { name: stream, from, to, .. } = *tally;
        if *valid && !ready {
            let state = state(from);
            senders.push(Wait { block: from, state, stream, other: to, sends: true });
        } else if *ready && !valid {
            let state = state(to);
            receivers.push(Wait { block: to, state, stream, other: from, sends: false });
        }
    }
    // Who cannot send is the cause; who has nothing to receive matters only without one.
    if senders.is_empty() { receivers } else { senders }
}

/// The memories that there are, with `peak(path, words)` as the most words in use.
pub fn memory_tallies(
    memories: &[(String, StorageInfo)],
    peak: impl Fn(&str, u64) -> u64,
) -> Vec<MemoryTally> {
    let there = memories.iter().filter(|(_, info)| info.words > 0);
    let tally = |(name, info): &(String, StorageInfo)| MemoryTally {
        name: name.clone(),
        info: *info,
        peak_words: peak(name, info.words),
    };
    there.map(tally).collect()
}

/// Counts the cycles of each phase.
#[derive(Clone, Debug, Default)]
pub struct PhaseCounts {
    phases: [u64; 5],
    /// Cycles of store that came before the phase: a frame's first fragment comes in while the machine
    /// still is idle.
    first: u64,
    scanout: u64,
}

impl PhaseCounts {
    /// One cycle: its phase, whether a fragment or an end was taken, whether an image is being shown.
    #[inline(always)]
    pub fn observe(&mut self, phase: Phase, came: bool, scanout: bool) {
        self.phases[phase as usize] += 1;
        self.first += u64::from(came && phase == Phase::Idle);
        self.scanout += u64::from(scanout);
    }

    /// What was counted.
    pub fn cycles(&self) -> Cycles {
        let of = |phase: Phase| self.phases[phase as usize];
        let (store, resolve) = (self.first + of(Phase::Store), of(Phase::Resolve));
        let (wait, clear) = (of(Phase::Wait), of(Phase::Clear));
        Cycles { total: store + resolve, store, resolve, wait, scanout: self.scanout, clear }
    }
}

/// What a run of a machine came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Cycles by phase.
    pub cycles: Cycles,
    /// Cycles that the architecture counts beside those.
    pub further_cycles: Vec<Figure>,
    /// Fragments by what became of them.
    pub fragments: Fragments,
    /// Why fragments are dropped, as a user reads it, with the parameters that could help.
    pub dropped_since: &'static str,
    /// Cycles in which a stream's offer was not taken: stream, sender, receiver, transfers, stalls.
    pub streams: Vec<StreamTally>,
    /// Memories with their traffic.
    pub memories: Vec<MemoryTally>,
    /// Accesses as the seed document counts them.
    pub seed_accesses: u64,
    /// Storage as the seed document counts it for the machine as configured, in bytes.
    pub seed_bytes: u64,
    /// The same for just the storage that was in use at the peak, in bytes.
    pub seed_bytes_used: u64,
    /// The architecture's own figures.
    pub own: Vec<Figure>,
}

impl Tally {
    /// One of the figures that only this architecture has, 0 if it has none of that name.
    pub fn figure(&self, name: &str) -> u64 {
        self.further_cycles.iter().chain(&self.own).find(|f| f.name == name).map_or(0, |f| f.value)
    }
}

pellucid_sim::counters! {
    /// Cycles by phase.
    pub struct Cycles {
        /// Store and resolve together, over all frames.
        total: "cycles",
        /// From a frame's first fragment until its last is stored.
        store: "cycles",
        /// From there until the image is complete.
        resolve: "cycles",
        /// With a complete image that waits for the one before to be shown.
        wait: "cycles",
        /// Showing images; beside the next frame's store.
        scanout: "cycles",
        /// Clearing memories, once after reset.
        clear: "cycles",
    }
}

pellucid_sim::counters! {
    /// Fragments by what became of them.
    pub struct Fragments {
        /// Fragments that came in, opaque and transparent.
        arrived: "fragments",
        /// Opaque fragments that were drawn (and perhaps drawn over later).
        drawn: "fragments",
        /// Opaque fragments that were hidden on arrival.
        hidden: "fragments",
        /// Transparent fragments that were stored.
        stored: "fragments",
        /// Transparent fragments that were stored in outside memory.
        spilled: "fragments",
        /// Transparent fragments behind their pixel's opaque depth: never blended.
        culled: "fragments",
        /// Transparent fragments that were blended.
        blended: "fragments",
        /// Transparent fragments for which there was no place: the image lacks them.
        dropped: "fragments",
    }
}

/// One stream's traffic.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamTally {
    /// Its name.
    pub name: &'static str,
    /// The block that sends.
    pub from: &'static str,
    /// The block that receives.
    pub to: &'static str,
    /// Transfers.
    pub transfers: u64,
    /// Cycles in which something was offered and not taken.
    pub stalls: u64,
}

/// One memory's traffic.
#[derive(Clone, Debug, PartialEq)]
pub struct MemoryTally {
    /// Its path.
    pub name: String,
    /// Size and traffic.
    pub info: StorageInfo,
    /// The most words that held something of use at once.
    pub peak_words: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitive::{BOUND_BITS, Edge, Side};

    #[test]
    fn items_are_labelled_where_they_begin() {
        let mut fragment = Fragment { x: 4, y: 7, ..Fragment::default() };
        fragment.label(9);
        assert_eq!(fragment.label, Label::new(9, 4, 7));
        // From column 3 on.
        let edge =
            Edge { side: Side::Left, bound: (1 << BOUND_BITS) - 3, height: 1, ..Edge::default() };
        let edges = [edge, Edge::default(), Edge::default()];
        let mut primitive = Primitive { row: 5, last_row: 6, edges, ..Primitive::default() };
        primitive.label(2);
        assert_eq!(primitive.label, Label::new(2, 3, 5));
    }
}
