//! Watches the machine: its T-buffer, and what becomes of the frames.

use crate::config::{Config, Method};
use crate::level::Fill;
use crate::{Accumulate, MachinePhase, Out, PHASES, State};
use pellucid_blocks::allocator::Chosen;
use pellucid_machine::accumulation::Accumulation;
use pellucid_machine::monitor::{above, below, seen_from};
use pellucid_machine::outside::{self, Outside, Request};
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_machine::{
    Arithmetic, Census, Check, Machine, Memories, Monitor, PhaseCounts, PhaseInfo, Ports, Room,
    Tally, seen, waits,
};
use pellucid_sim::{Deadlock, Figures, StorageInfo, StreamMonitor, Violation};
use pellucid_tbuffer::TBuffer;
use pellucid_tbuffer::monitor::TBufferMonitor;

pellucid_sim::counters! {
    /// The accumulator's own figures, beside those of the T-buffer.
    pub struct AccumulateCounters {
        /// Frames that were merged into images.
        frames: "frames",
        /// Images that were completed.
        images: "images",
        /// Passes as the paper counts them: one for each frame, and one for each node of the tree.
        passes: "passes",
        /// Sweeps over the screen that these took.
        sweeps: "sweeps",
        /// Planes that held something of use at once, at most.
        peak_planes: "planes",
    }
}

/// The requests at the port, and those of them that are the T-buffer's, where planes lie outside.
const REQUEST: &str = "request";
const OF_TBUFFER: &str = "fragment_request";
/// Where the T-buffer is.
const TBUFFER: &str = "tbuffer.";

/// See the module's description.
pub struct AccumulateMonitor {
    phases: PhaseCounts,
    tbuffer: TBufferMonitor,
    own: AccumulateCounters,
    /// Pixels that came to the accumulator, and those that nodes took from the top.
    pixels: u64,
    swept: u64,
    image: StreamMonitor<u32>,
    /// The port, where planes lie outside, too.
    port: StreamMonitor<Request>,
}

/// Planes in use in a cycle.
fn planes(cfg: &Config, q: &State) -> u64 {
    let q = &q.accumulator;
    if cfg.method() == Method::Tree {
        let (levels, top): (Vec<Fill>, _) = if cfg.outside() {
            (q.planes.levels.to_vec(), q.planes.top.valid)
        } else {
            (q.tree.levels.iter().map(|level| level.fill).collect(), q.tree.sweep.valid)
        };
        levels.iter().map(|level| u64::from(level.filled)).sum::<u64>() + u64::from(top)
    } else {
        u64::from(q.frame > 0 || q.planes.frame > 0)
    }
}

/// The most planes that frames and nodes of the tree take, by counting as they come.
fn most_planes(cfg: &Config) -> u64 {
    let levels: Vec<u32> = (0..cfg.levels()).map(|k| cfg.tree.level(k).node.inputs).collect();
    let (mut waiting, mut most) = (vec![0; levels.len()], 0);
    for frame in 0..cfg.frames() {
        let last = frame + 1 == cfg.frames();
        let mut height: u32 = waiting.iter().sum();
        for (waiting, inputs) in waiting.iter_mut().zip(&levels) {
            most = most.max(height + u32::from(cfg.tree.sweeps));
            if !last && *waiting + 1 < *inputs {
                *waiting += 1;
                break;
            }
            height -= *waiting;
            *waiting = 0;
        }
        most = most.max(waiting.iter().sum());
    }
    u64::from(most)
}

impl Machine for Accumulate {
    type Item = Fragment;
    type Monitor = AccumulateMonitor;
    const PHASES: &[PhaseInfo] = PHASES;

    fn arithmetic(cfg: &Config) -> Arithmetic {
        TBuffer::<Chosen>::arithmetic(&cfg.tbuffer)
    }

    fn accumulation(cfg: &Config) -> Option<Accumulation> {
        cfg.accumulation()
    }

    #[inline(always)]
    fn ports(cfg: &Config, out: &Out) -> Ports {
        let tbuffer = TBuffer::<Chosen>::ports(&cfg.tbuffer, &out.tbuffer);
        Ports { phase: out.phase as u8, image: out.image, outside: out.outside, ..tbuffer }
    }

    fn port(cfg: &Config) -> outside::Config {
        cfg.port()
    }

    fn outside(cfg: &Config) -> Option<Outside> {
        cfg.outside_memory()
    }

    fn room(cfg: &Config, frame: &Census) -> Option<Room> {
        TBuffer::<Chosen>::room(&cfg.tbuffer, frame).map(|room| room.of_part("tbuffer"))
    }

    fn screen(cfg: &Config) -> Screen {
        cfg.screen
    }

    fn closed_forms(cfg: &Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        let figure = |name| tally.figure(name);
        let check = |what, expected, found| Check { what, expected, found };
        let (all, of_image) = (frames.len() as u64, u64::from(cfg.frames()));
        let pixels = u64::from(cfg.screen.pixels());
        let mut checks = vec![check("frames that were merged", all, figure("frames"))];
        if all % of_image == 0 {
            let images = all / of_image;
            let nodes: u64 = (0..cfg.levels()).map(|k| u64::from(cfg.tree.level(k).nodes)).sum();
            let own_sweeps = if cfg.has_top() { nodes } else { 0 };
            let traffic = |of: fn(&StorageInfo) -> u64| {
                let planes = tally.memories.iter().filter(|memory| {
                    let name = memory.name.as_str();
                    let queues = ["accumulator.queue", "accumulator.planes."];
                    name.starts_with("accumulator.")
                        && !queues.iter().any(|queue| name.starts_with(queue))
                });
                planes.map(|memory| of(&memory.info)).sum()
            };
            // All but the last input of a node wait for it; with a sweep of its own that one does, too.
            let stored = images * (of_image - 1 + own_sweeps) * pixels;
            checks.extend([
                check("images, one for N frames", images, figure("images")),
                check("passes, N + nodes for each image", images * (of_image + nodes), figure("passes")),
                check("sweeps of the screen", images * (of_image + own_sweeps), figure("sweeps")),
                check("pixels written to planes, N - 1 for each of an image and those of nodes' sweeps", stored, traffic(|info| info.writes)),
                check("pixels read from planes, as many", stored, traffic(|info| info.reads)),
                check("planes in use, at most", if cfg.method() == Method::Tree { most_planes(cfg) } else { u64::from(of_image > 1) }, figure("peak_planes")),
            ]);
            if cfg.method() == Method::Tree && cfg.params.weights == crate::weights::Weights::None {
                // The sum over all levels of b - 1, and one more for what is merged next.
                checks.push(check(
                    "planes in use, (b - 1) log_b N and the top",
                    u64::from(cfg.planes()),
                    figure("peak_planes"),
                ));
            }
        }
        let inside = seen_from(TBUFFER, tally);
        checks.extend(TBuffer::<Chosen>::closed_forms(&cfg.tbuffer, &inside, frames));
        checks
    }
}

/// A block of the T-buffer as it is called here: its frames go to the accumulator.
fn here(block: &'static str) -> &'static str {
    if block == "display" { "accumulator" } else { block }
}

impl Monitor<Accumulate> for AccumulateMonitor {
    fn new(cfg: &Config) -> AccumulateMonitor {
        AccumulateMonitor {
            phases: PhaseCounts::default(),
            tbuffer: <TBufferMonitor as Monitor<TBuffer<Chosen>>>::new(&cfg.tbuffer),
            own: AccumulateCounters::default(),
            pixels: 0,
            swept: 0,
            image: StreamMonitor::new("accumulated", "accumulator", "display"),
            port: StreamMonitor::new(REQUEST, "turns", "outside"),
        }
    }

    #[inline(always)]
    fn observe(&mut self, cfg: &Config, q: &State, o: &Out) -> Result<(), Violation> {
        let did = &o.accumulator;
        self.phases.observe(o.phase as u8, o.image.valid);
        Monitor::<TBuffer<Chosen>>::observe(
            &mut self.tbuffer,
            &cfg.tbuffer,
            &q.tbuffer,
            &o.tbuffer,
        )?;
        self.image.observe(o.image)?;
        if o.phase == MachinePhase::Clear {
            return Ok(());
        }
        if cfg.outside() {
            self.port.observe(o.outside.request)?;
        }
        let nodes = u64::from(did.merged.count_ones());
        self.pixels += u64::from(did.comes);
        self.swept += u64::from(did.sweeps);
        self.own.frames += u64::from(did.events.frame_in);
        self.own.images += u64::from(did.events.image_done);
        self.own.passes += u64::from(did.events.frame_in) + nodes;
        self.own.sweeps += u64::from(did.events.frame_in);
        if cfg.has_top() {
            self.own.sweeps += nodes;
        }
        self.own.peak_planes = self.own.peak_planes.max(planes(cfg, q));
        Ok(())
    }

    fn transfers(&self) -> u64 {
        let tbuffer = Monitor::<TBuffer<Chosen>>::transfers(&self.tbuffer);
        tbuffer + self.pixels + self.swept + self.image.transfers + self.port.transfers
    }

    fn deadlock(&self, cycle: u64, idle: u64, q: &State) -> Deadlock {
        let inside = Monitor::<TBuffer<Chosen>>::deadlock(&self.tbuffer, cycle, idle, &q.tbuffer);
        let inside = inside.waits.into_iter();
        let mut waits: Vec<_> = waits(&[seen(&self.image), seen(&self.port)], |_| "Accumulate");
        waits.extend(inside.map(|wait| pellucid_sim::Wait { other: here(wait.other), ..wait }));
        if waits.iter().any(|wait| wait.sends) {
            waits.retain(|wait| wait.sends);
        }
        Deadlock { cycle, idle, waits }
    }

    fn tally(&self, cfg: &Config, memories: &[(String, StorageInfo)]) -> Tally {
        let [inside, around] = below(TBUFFER, memories);
        let mut tally = Monitor::<TBuffer<Chosen>>::tally(&self.tbuffer, &cfg.tbuffer, &inside);
        let inside = std::mem::replace(&mut tally.memories, Memories::new(&around).tallies());
        tally.memories.extend(above(TBUFFER, inside));
        tally.streams.iter_mut().for_each(|stream| stream.to = here(stream.to));
        if cfg.outside() {
            // The T-buffer's requests are some of those at the port.
            let own = tally.streams.iter_mut().filter(|stream| stream.name == REQUEST);
            own.for_each(|stream| (stream.name, stream.to) = (OF_TBUFFER, "turns"));
            tally.streams.push(seen(&self.port).tally);
        }
        tally.streams.push(seen(&self.image).tally);
        let mut own = self.own.figures();
        own.append(&mut tally.own);
        // As the paper has it a plane is a texture: three bytes for each pixel.
        let plane = 3 * u64::from(cfg.screen.pixels());
        Tally {
            cycles: self.phases.cycles(PHASES),
            dropped_since: "no section was free (see `tbuffer.sections` and `tbuffer.outside_sections`)",
            seed_bytes: tally.seed_bytes + plane * u64::from(cfg.planes()),
            seed_bytes_used: tally.seed_bytes_used + plane * self.own.peak_planes,
            own,
            ..tally
        }
    }
}
