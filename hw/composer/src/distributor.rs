//! The distributor: opaque primitives to one of the object-order engines each, transparent ones to whoever
//! adds them, the end of a frame to all.
//!
//! ```text
//!                +-------------+---> engine, to_engine
//!  primitive --->| Distributor |---> to_transparency
//!  ready <-------|             |---> to_all (the end)
//!                +-------------+<--- taken
//! ```
//! Round robin, each engine gets every so-manieth primitive. By area, each primitive goes to the engine whose
//! primitives have the fewest pixels so far in this frame, about: the first of equal ones. A primitive waits
//! until who is to have it is ready.

use super::config::Distribution;
use pellucid_machine::pixel::{Marked, Screen};
use pellucid_machine::primitive::{Format, Primitive};
use pellucid_sim::{Block, Registers, Signals, Stream, bits_for, check_range, rtl};

/// See the module's description.
pub struct Distributor;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// Object-order engines, at least 1.
    pub engines: u32,
    /// Which of them a primitive goes to.
    pub distribution: Distribution,
}

/// Bits of how many pixels an engine has to draw; more count as the most.
pub const LOAD_BITS: u32 = 31;
/// The most pixels that are counted.
pub const MOST_LOAD: u32 = (1 << LOAD_BITS) - 1;

impl Config {
    /// Bits of an engine's number.
    pub fn engine_bits(&self) -> u32 {
        bits_for(u64::from(self.engines - 1))
    }
    /// Whether areas decide.
    fn by_area(&self) -> bool {
        self.distribution == Distribution::Area
    }
    /// Engines whose load is kept.
    fn loads(&self) -> u32 {
        if self.by_area() { self.engines } else { 0 }
    }
}

/// Registers.
#[derive(Clone, Debug, Registers)]
pub struct State {
    /// What came, and goes on to whom it is for.
    #[with(Format { area: cfg.by_area(), ..Format::whole(cfg.screen) })]
    pub item: Stream<Marked<Primitive>>,
    /// The engine whose turn it is, round robin.
    #[width(cfg.engine_bits())]
    #[exists(!cfg.by_area())]
    pub turn: u32,
    /// Pixels that each engine has to draw.
    #[width(LOAD_BITS)]
    #[len(cfg.loads())]
    pub loads: Vec<u32>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Primitives, then the end of the frame.
    #[with(Format::whole(cfg.screen))]
    pub primitive: Stream<Marked<Primitive>>,
    /// Who is to have the one that is given takes it.
    pub taken: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A primitive is given, or the end of the frame.
    #[with(Format::drawn(cfg.screen))]
    pub item: Stream<Marked<Primitive>>,
    /// It is for one of the engines.
    pub to_engine: bool,
    /// Which one.
    #[width(cfg.engine_bits())]
    pub engine: u32,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// What is offered is taken.
    pub ready: bool,
}

#[rtl(
    output = (),
    check(Distributor, Config {
        screen: crate::test_util::screen(7, 5), engines: 3, distribution: Distribution::RoundRobin
    }),
    check(Distributor, Config {
        screen: crate::test_util::screen(7, 5), engines: 4, distribution: Distribution::Area
    })
)]
impl Block for Distributor {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        check_range("the number of engines of a distributor", cfg.engines, 1..);
        State { item: Stream::idle(), turn: 0, loads: vec![0; cfg.loads() as usize] }
    }

    fn memories(_: &Config) {}

    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        let Marked { end, item } = q.item.payload;
        let mut engine = q.turn;
        if cfg.by_area() {
            engine = 0;
            let mut least = q.loads[0];
            for k in 1..cfg.engines {
                if q.loads[k as usize] < least {
                    least = q.loads[k as usize];
                    engine = k;
                }
            }
        }
        Moore { item: q.item, to_engine: !end && item.opaque, engine }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let Moore { to_engine, engine, .. } = Self::moore(cfg, q, &());
        let Marked { end, item } = q.item.payload;
        let goes = q.item.valid && i.taken;
        if goes && end {
            d.turn = 0;
        } else if goes && to_engine {
            d.turn = if q.turn + 1 == cfg.engines { 0 } else { q.turn + 1 };
        }
        if cfg.by_area() {
            for k in 0..cfg.engines {
                if goes && end {
                    d.loads[k as usize] = 0;
                } else if goes && to_engine && engine == k {
                    // A primitive costs, however small it is.
                    let load = q.loads[k as usize] + item.area + 1;
                    d.loads[k as usize] = load.min(MOST_LOAD);
                }
            }
        }
        let ready = !q.item.valid || goes;
        if ready {
            d.item = i.primitive;
        }
        Out { ready }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::screen;
    use pellucid_sim::Sim;

    fn config(distribution: Distribution) -> Config {
        Config { screen: screen(7, 5), engines: 3, distribution }
    }

    /// To whom primitives of these areas go, and what the model of the distribution says.
    fn engines(cfg: Config, areas: &[Option<u32>]) -> (Vec<Option<u32>>, Vec<Option<u32>>) {
        let primitive = |area: &Option<u32>| Primitive {
            opaque: area.is_some(),
            area: area.unwrap_or(9),
            ..Primitive::default()
        };
        let mut sim = Sim::<Distributor>::new(cfg);
        let mut seen = vec![];
        for area in areas {
            let primitive = Stream::offer(Marked::item(primitive(area)));
            sim.clock(In { primitive, taken: true }).unwrap();
            let shown = sim.moore();
            assert!(shown.item.valid);
            seen.push(shown.to_engine.then_some(shown.engine));
        }
        let mut model = cfg.distribution.engines(cfg.engines);
        let expected = areas.iter().map(|area| {
            let primitive = primitive(area);
            primitive.opaque.then(|| model.engine(&primitive))
        });
        (seen, expected.collect())
    }

    #[test]
    fn round_robin_and_by_area() {
        let areas = [Some(5), Some(1), None, Some(2), Some(0), Some(3), Some(1)];
        let (seen, model) = engines(config(Distribution::RoundRobin), &areas);
        let turns = [Some(0), Some(1), None, Some(2), Some(0), Some(1), Some(2)];
        assert_eq!((seen, model), (turns.to_vec(), turns.to_vec()));
        // Loads: 6 0 0, then 6 2 0, 6 2 3, 6 3 3, 6 7 3, 6 7 5.
        let (seen, model) = engines(config(Distribution::Area), &areas);
        let least = [Some(0), Some(1), None, Some(2), Some(1), Some(1), Some(2)];
        assert_eq!((seen, model), (least.to_vec(), least.to_vec()));
    }

    /// Loads that are more than can be counted are all the same: the first engine gets what comes.
    #[test]
    fn loads_end_at_the_most_that_is_counted() {
        let screen = screen(8192, 8192);
        let cfg = Config { screen, ..config(Distribution::Area) };
        let (seen, model) = engines(cfg, &[Some(screen.pixels() - 1); 200]);
        assert_eq!(seen, model);
        assert_eq!(seen[194..], [Some(0); 6]);
    }

    #[test]
    fn what_is_not_taken_waits() {
        let mut sim = Sim::<Distributor>::new(config(Distribution::RoundRobin));
        let offer = |area| {
            Stream::offer(Marked::item(Primitive { area, opaque: true, ..Primitive::default() }))
        };
        for (area, taken, ready) in [(1, false, true), (2, false, false), (2, true, true)] {
            let out = sim.clock(In { primitive: offer(area), taken }).unwrap().out;
            assert_eq!(out.ready, ready);
        }
        assert_eq!((sim.moore().item.payload.item.area, sim.moore().engine), (2, 1));
    }

    #[test]
    #[should_panic(expected = "the number of engines of a distributor is 0: expected at least 1")]
    fn there_is_an_engine() {
        Distributor::reset(&Config { engines: 0, ..config(Distribution::RoundRobin) });
    }
}
