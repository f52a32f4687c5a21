//! A machine of one architecture under the clock.

use crate::board::{Board, Timing};
use crate::dut::{At, Dut, Failure, Observed, Observer, Quiet};
use crate::item::{ItemType, Offer};
use crate::machine::{Machine, Ports};
use crate::monitor::Monitor;
use crate::outside;
use crate::phase::PhaseInfo;
use crate::pixel::Marked;
use crate::tally::Tally;
use pellucid_sim::block::Cycle;
use pellucid_sim::{
    Declare, Fault, Kind, Memory, Registers, Sampler, Signals, Sim, Stream, Watchdog, join,
};

/// Cycles without progress after which a simulation is given up, beside those that its outside memory
/// [may take](Timing::longest).
pub const WATCHDOG_CYCLES: u64 = 100_000;
/// How often the watchdog looks.
const LOOK_EVERY: u64 = 1 << 14;

/// How many cycles after one look whether all but the front rests the next comes, at least.
const LOOK_FOR_REST: u64 = 16;

/// Which signals are not within the front.
struct Elsewhere {
    front: &'static str,
    path: String,
    signals: Vec<bool>,
}

impl Declare for Elsewhere {
    fn open(&mut self, name: &str) {
        self.path = join(&self.path, name);
    }
    fn close(&mut self) {
        let end = self.path.rfind('.').unwrap_or_default();
        self.path.truncate(end);
    }
    fn signal(&mut self, _: &str, _: u32, _: Kind) {
        self.signals.push(!is_within(&self.path, self.front));
    }
}

/// Whether what is at `path` is the part at `whole`, or of it.
fn is_within(path: &str, whole: &str) -> bool {
    path.strip_prefix(whole).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// A cycle of a machine.
struct ObservedCycle<'a, M: Machine> {
    cycle: &'a Cycle<'a, Board<M>>,
    input: &'a M::In,
}

impl<M: Machine> Observed for ObservedCycle<'_, M> {
    fn sample(&self, to: &mut Sampler) {
        Registers::sample(self.cycle.q, self.cycle.cfg, to);
        Signals::sample(&self.cycle.out, self.cycle.cfg, to);
    }
    fn registers(&self, to: &mut Vec<u64>) {
        (M::numbers().state)(self.cycle.cfg, self.cycle.q, to);
    }
    fn ports(&self, inputs: &mut Vec<u64>, outputs: &mut Vec<u64>) {
        let numbers = M::numbers();
        (numbers.input)(self.cycle.cfg, self.input, inputs);
        (numbers.out)(self.cycle.cfg, &self.cycle.out, outputs);
    }
}

/// Shows a cycle. It comes by value: where nobody watches, it need not be in memory at all.
#[inline(never)]
fn show<M: Machine>(
    observer: &mut dyn Observer,
    at: At,
    input: M::In,
    cycle: Cycle<Board<M>>,
) -> Quiet {
    observer.cycle(at, &ObservedCycle::<M> { cycle: &cycle, input: &input })
}

/// See the module's description.
pub struct Clocked<M: Machine> {
    sim: Sim<Board<M>>,
    monitor: M::Monitor,
    watchdog: Watchdog,
    pixels: Vec<u32>,
    /// Pixels of an image.
    of_image: usize,
    images: Vec<Vec<u32>>,
    /// The cycle in which the machine was first ready: 0 on every time axis that users see.
    ready_at: Option<u64>,
    phase: u8,
    replay: bool,
    /// The frame's items that were taken so far.
    taken: u32,
    observer: Option<Box<dyn Observer>>,
    peeks: bool,
    quiet: Quiet,
    display: Option<Box<dyn FnMut(u64) -> bool>>,
    /// The inputs of the last cycle.
    input: M::In,
    /// What was to be seen in the last cycle, while nothing but the front works.
    rest: Option<M::Out>,
    /// When it is looked next whether that is so.
    look_for_rest: u64,
    /// Which signals of the registers are not within the front, once that is known.
    elsewhere: Option<Vec<bool>>,
}

impl<M: Machine> Clocked<M> {
    /// A machine at power-up.
    pub fn new(cfg: M::Config) -> Clocked<M> {
        let of_image = M::screen(&cfg).pixels() as usize;
        let monitor = M::Monitor::new(&cfg);
        let mut sim = Sim::new(cfg);
        let watchdog = Self::watchdog(&mut sim);
        Clocked {
            monitor,
            sim,
            watchdog,
            pixels: Vec::with_capacity(of_image),
            of_image,
            images: vec![],
            ready_at: None,
            phase: 0,
            replay: false,
            taken: 0,
            observer: None,
            peeks: false,
            quiet: Quiet::default(),
            display: None,
            input: M::Item::input(Stream::idle(), false, outside::In::default()),
            rest: None,
            look_for_rest: 0,
            elsewhere: None,
        }
    }

    fn watchdog(sim: &mut Sim<Board<M>>) -> Watchdog {
        Watchdog::new(WATCHDOG_CYCLES + sim.memories().longest())
    }

    fn offered(offer: Offer) -> Stream<Marked<M::Item>> {
        match offer {
            Offer::Nothing => Stream::idle(),
            Offer::End => Stream::offer(Marked::end()),
            Offer::Item(item) => match M::Item::of(item) {
                Some(item) => Stream::offer(Marked::item(item)),
                None => panic!("the machine takes {:?}", M::Item::KIND),
            },
        }
    }

    /// The item that is offered, with the label of the one that is taken next.
    #[inline(always)]
    fn labelled(&self, offer: Offer) -> Stream<Marked<M::Item>> {
        let mut item = Self::offered(offer);
        if !item.payload.end {
            item.payload.item.label(self.taken);
        }
        item
    }

    /// One cycle in which `item` is offered; how many items are taken, or would be: 0 or 1. A cycle is a whole machine: one copy of its
    /// code serves all who call.
    #[inline(never)]
    fn cycle(&mut self, item: &Stream<Marked<M::Item>>) -> Result<usize, Box<Failure>> {
        let at = self.sim.cycle();
        let image_ready = match &mut self.display {
            None => true,
            Some(ready) => ready(at),
        };
        if self.rest.is_some()
            && let Some(done) = self.alone(at, item, image_ready)
        {
            return done;
        }
        if self.peeks
            && let Some(observer) = &mut self.observer
        {
            observer.peek(self.sim.memories());
        }
        let outside = self.sim.memories().outside();
        // It is made anew wherever it is of use: a copy that is kept would have to lie in memory in every cycle.
        let input = || M::Item::input(*item, image_ready, outside);
        let cycle = match self.sim.clock(input()) {
            Ok(cycle) => cycle,
            Err(fault) => {
                self.input = input();
                return Err(Box::new(fault.into()));
            }
        };
        // A cycle with a fault is shown before it is told of.
        let observed = self.monitor.observe(cycle.cfg, cycle.q, &cycle.out);
        let fits =
            if cfg!(debug_assertions) { Signals::check(&cycle.out, cycle.cfg) } else { Ok(()) };
        let ports = M::ports(cycle.cfg, &cycle.out);
        let phase = ports.phase;
        if phase != self.phase {
            self.phase = phase;
            self.ready_at.get_or_insert(at);
        }
        let time = self.ready_at.map(|zero| at - zero);
        let away = phase == self.quiet.phase && time.unwrap_or_default() < self.quiet.until;
        if !away && let Some(observer) = &mut self.observer {
            self.quiet = show::<M>(&mut **observer, At { time, phase }, input(), cycle);
        } else if M::may_be_alone(cycle.cfg, cycle.q) && !self.peeks && at >= self.look_for_rest {
            let out = cycle.out;
            self.rest = self.rests().then_some(out);
            // What does not rest yet may in some cycles; to look each time would cost more than it gives.
            self.look_for_rest = at + LOOK_FOR_REST;
        }
        observed.map_err(|violation| Box::new(violation.into()))?;
        fits.map_err(|overflow| Box::new(Fault::overflow(at, overflow).into()))?;
        self.after(at, item, &ports)
    }

    /// What is left of a cycle once it has been seen; what [`Clocked::cycle`] says of it.
    #[inline(always)]
    fn after(
        &mut self,
        at: u64,
        item: &Stream<Marked<M::Item>>,
        ports: &Ports,
    ) -> Result<usize, Box<Failure>> {
        self.replay = ports.replay;
        if item.valid && ports.item_ready {
            self.taken = if item.payload.end { 0 } else { self.taken.saturating_add(1) };
        }
        if ports.image.fires() {
            self.pixel(ports.image.payload);
        }
        if at.is_multiple_of(LOOK_EVERY) {
            self.look()?;
        }
        Ok(ports.item_ready.into())
    }

    /// A cycle in which all but the front rests, if it does; then it is as [`Clocked::cycle`].
    #[inline(never)]
    fn alone(
        &mut self,
        at: u64,
        item: &Stream<Marked<M::Item>>,
        image_ready: bool,
    ) -> Option<Result<usize, Box<Failure>>> {
        let time = self.ready_at.map_or(0, |zero| at - zero);
        if self.observer.is_some() && time >= self.quiet.until {
            self.rest = None;
            return None;
        }
        let Clocked { sim, monitor, rest, .. } = self;
        let out = rest.as_mut()?;
        let input = M::Item::input(*item, image_ready, sim.memories().outside());
        let clocked = sim.clock_part(|cfg, q, d, m| {
            let m = m.machine();
            if M::may_be_alone(cfg, d) { M::alone(cfg, q, d, m, &input, out) } else { None }
        });
        match clocked {
            Some(Ok(())) => (),
            Some(Err(fault)) => {
                self.input = input;
                return Some(Err(Box::new(fault.into())));
            }
            None => {
                self.rest = None;
                return None;
            }
        }
        if let Err(violation) = monitor.observe(sim.config(), sim.edge().0, out) {
            return Some(Err(Box::new(violation.into())));
        }
        let ports = M::ports(sim.config(), out);
        Some(self.after(at, item, &ports))
    }

    /// Whether the last cycle has changed no register but the front's, nothing is under way outside, and no memory of the machine but
    /// the front's has anything to do.
    #[cold]
    fn rests(&mut self) -> bool {
        let Some(front) = M::FRONT.filter(|_| self.sim.memories().idle()) else { return false };
        let Clocked { sim, elsewhere, .. } = self;
        let elsewhere = elsewhere.get_or_insert_with(|| {
            let mut to = Elsewhere { front, path: String::new(), signals: vec![] };
            <M::State as Registers>::declare(sim.config(), "", &mut to);
            to.signals
        });
        let (before, now) = sim.edge();
        let mut values = [vec![], vec![]];
        Registers::sample(before, sim.config(), &mut values[0]);
        Registers::sample(now, sim.config(), &mut values[1]);
        let mut pairs = values[0].iter().zip(&values[1]).zip(&*elsewhere);
        let mut rests = pairs.all(|((before, now), elsewhere)| !elsewhere || before == now);
        if rests {
            sim.memories().machine().visit("", &mut |path, storage| {
                rests &= is_within(path, front) || !storage.busy();
            });
        }
        rests
    }

    fn pixel(&mut self, colour: u32) {
        self.pixels.push(colour);
        if self.pixels.len() == self.of_image {
            let next = Vec::with_capacity(self.of_image);
            self.images.push(std::mem::replace(&mut self.pixels, next));
        }
    }

    #[cold]
    fn look(&mut self) -> Result<(), Box<Failure>> {
        let mut progress = self.monitor.transfers();
        self.sim.memories().each(&mut |storage| {
            let info = storage.info();
            progress += info.reads + info.writes;
        });
        let cycle = self.sim.cycle();
        match self.watchdog.look(cycle, progress) {
            None => Ok(()),
            Some(idle) => {
                Err(Box::new(self.monitor.deadlock(cycle, idle, self.sim.state()).into()))
            }
        }
    }
}

impl<M: Machine> Dut for Clocked<M> {
    fn send(&mut self, offer: Offer) -> Result<(), Box<Failure>> {
        let item = self.labelled(offer);
        while self.cycle(&item)? == 0 {}
        Ok(())
    }

    fn step(&mut self, offer: Offer) -> Result<bool, Box<Failure>> {
        Ok(self.cycle(&self.labelled(offer))? > 0)
    }

    fn run(&mut self, cycles: u64, images: usize) -> Result<u64, Box<Failure>> {
        let mut done = 0;
        while done < cycles && self.images.len() < images {
            self.cycle(&Stream::idle())?;
            done += 1;
        }
        Ok(done)
    }

    fn replay(&self) -> bool {
        self.replay
    }

    fn reset(&mut self) {
        self.sim.reset();
        self.rest = None;
        self.count_anew();
        self.pixels.clear();
        self.taken = 0;
        self.phase = 0;
        if let Some(observer) = &mut self.observer {
            observer.reset();
        }
    }

    fn set_display(&mut self, ready: Box<dyn FnMut(u64) -> bool>) {
        self.display = Some(ready);
    }

    fn set_timing(&mut self, timing: Box<dyn Timing>) {
        self.sim.memories().set_timing(timing);
        self.watchdog = Self::watchdog(&mut self.sim);
    }

    fn watch(&mut self, observer: Box<dyn Observer>) {
        self.peeks = observer.peeks();
        self.quiet = Quiet::default();
        self.rest = None;
        self.observer = Some(observer);
    }

    fn unwatch(&mut self) -> Option<Box<dyn Observer>> {
        self.peeks = false;
        self.observer.take()
    }

    fn show_fault(&mut self) -> u64 {
        // Unless the cycle came to its end, it has not been counted.
        let time = self.time();
        let (at, input) = (At { time: Some(time), phase: self.phase }, self.input);
        match (self.sim.at_fault(), &mut self.observer) {
            (Some(cycle), Some(observer)) => {
                show::<M>(&mut **observer, at, input, cycle);
                time
            }
            (Some(_), None) => time,
            (None, _) => time.saturating_sub(1),
        }
    }

    fn take_images(&mut self) -> Vec<Vec<u32>> {
        std::mem::take(&mut self.images)
    }

    fn images(&self) -> usize {
        self.images.len()
    }

    fn tally(&mut self) -> Tally {
        let mut memories = vec![];
        self.sim.memories().visit("", &mut |path, storage| {
            memories.push((path.to_string(), storage.info()));
        });
        let outside = self.sim.memories().figures();
        Tally { outside, ..self.monitor.tally(self.sim.config(), &memories) }
    }

    fn count_anew(&mut self) {
        self.sim.memories().each(&mut |storage| storage.count_anew());
        self.sim.memories().count_anew();
        self.monitor = M::Monitor::new(self.sim.config());
    }

    fn cycles(&self) -> u64 {
        self.sim.cycle()
    }

    fn time(&self) -> u64 {
        self.ready_at.map_or(0, |zero| self.sim.cycle() - zero)
    }

    fn phase(&self) -> u8 {
        self.phase
    }

    fn phases(&self) -> &'static [PhaseInfo] {
        M::PHASES
    }

    fn declare(&self, to: &mut dyn Declare) {
        let cfg = self.sim.config();
        <M::State as Registers>::declare(cfg, "registers", to);
        <M::Out as Signals>::declare(cfg, "wires", to);
    }

    fn memories(&mut self) -> &mut dyn Memory {
        self.sim.memories()
    }

    fn forget_undeclared(&mut self) {
        self.sim.forget_undeclared();
    }
}
