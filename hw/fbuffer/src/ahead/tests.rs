use super::*;
use crate::plays::Play;
use crate::survivors::{self, Survivors};
use crate::test_util::behind::Behind;
use crate::test_util::{Pattern, Source, ahead, pattern};
use crate::window::{self, Places, Window};
use pellucid_machine::pixel::{Fragment, Marked};
use pellucid_sim::{Sim, StreamMonitor};
use proptest::prelude::*;
use std::collections::VecDeque;

/// Fragment and pass, from every value of its word.
fn values(cfg: &Config, number: u32, pass: u32, killed: bool) -> Values {
    let mut values = Values { of: [0; MOST_VALUES], killed };
    for k in 0..cfg.shader.values() {
        let all = (number << 8 | pass << 4 | k).wrapping_mul(0x9e37_79b1);
        values.of[k as usize] = all >> (32 - cfg.shader.bits);
    }
    values
}

/// A fragment in the shader: its number, and what the pass before has left of it.
type InShader = Option<(Marked<u32>, Values)>;

/// A window with its survivors, a shader of some stages, and an F-buffer before a memory.
struct Machine {
    window: Sim<Window>,
    survivors: Option<Sim<Survivors>>,
    ahead: Sim<Ahead>,
    memory: Behind,
    requests: StreamMonitor<Request>,
    stages: usize,
    cycle: u64,
}

impl Machine {
    fn new(cfg: Config, stages: usize, ready: Pattern, latencies: Vec<u64>) -> Machine {
        let window = cfg.shader.window;
        Machine {
            window: Sim::new(window),
            survivors: window.compacts.then(|| Sim::new(window)),
            ahead: Sim::new(cfg),
            memory: Behind::new(cfg.port().words, ready, latencies),
            requests: StreamMonitor::new("request", "ahead", "test"),
            stages,
            cycle: 0,
        }
    }

    /// A play of `count` fragments, of which `kills` says which this pass kills; those that it shades, and the number behind the window.
    fn play(
        &mut self,
        play: Play,
        [pass, passes]: [u32; 2],
        count: u32,
        kills: &dyn Fn(u32, u32) -> bool,
        starts: &Pattern,
    ) -> (Vec<u32>, u32, bool) {
        let cfg = *self.ahead.config();
        let compacts = cfg.shader.window.compacts;
        let killed = |number: u32, pass: u32| (0..=pass).any(|pass| kills(number, pass));
        let items = (0..count).map(|z| Marked::item(Fragment { z, ..Fragment::default() }));
        let mut source = Source::new(items.chain([Marked::end()]), starts.clone());
        let mut line: VecDeque<InShader> = vec![None; self.stages].into();
        let (mut shaded, mut over) = (vec![], false);
        for cycle in self.cycle.. {
            assert!(cycle < self.cycle + 100_000, "the end of the play does not come");
            let (moore, ahead) = (self.window.moore(), self.ahead.moore());
            let mut survivors = self.survivors.as_ref().map(Sim::moore).unwrap_or_default();
            survivors.next = ahead.next;

            // What leaves the shader is written, or waits.
            let leaves = *line.front().unwrap();
            let item = leaves.filter(|(item, _)| !item.end).map(|(item, _)| item.item);
            let gone = |number| compacts && killed(number, pass);
            let stored = item.filter(|number| pass + 1 < passes && !gone(*number));
            let advance = stored.is_none() || ahead.room;
            let written = stored.filter(|_| ahead.room);
            if advance {
                line.pop_front();
                let Stream { valid, payload: Marked { end, item } } = moore.placed;
                let number = if compacts { item.number } else { item.fragment.z };
                line.push_back(valid.then_some((Marked { end, item: number }, ahead.values.data)));
                if valid && !end && play.reads {
                    let before = killed(number, pass - 1) && cfg.shader.tells();
                    assert_eq!(ahead.values.data, values(&cfg, number, pass - 1, before));
                }
            }
            let ended = advance && leaves.is_some_and(|(item, _)| item.end);

            let there = ahead.there;
            let fragment = source.offer(cycle);
            let i = window::In { fragment, play, survivors, there, advance, over };
            let out = self.window.clock(i).unwrap().out;
            if out.shaded {
                shaded.push(i.fragment.payload.item.z);
            }
            let word = |number: u32| {
                let killed = killed(number, pass) && cfg.shader.tells();
                let number = if compacts { number } else { 0 };
                Left { values: values(&cfg, item.unwrap(), pass, killed), number }
            };
            let shown = self.memory.shows(cycle);
            let to_ahead = In {
                write: written.map_or(Stream::idle(), |number| Stream::offer(word(number))),
                label: Label::NONE,
                taken: out.read.valid,
                reads: play.reads,
                over,
                memory: shown,
            };
            let request = self.ahead.clock(to_ahead).unwrap().out;
            self.requests.observe(request.with(shown.ready)).unwrap();
            self.memory.edge(cycle, request);
            if let Some(survivors) = &mut self.survivors {
                let of_survivors = survivors::In {
                    enters: out.shaded,
                    leaves: advance && item.is_some(),
                    survives: written.map_or(Stream::idle(), Stream::offer),
                    over,
                };
                survivors.clock(of_survivors).unwrap();
            }
            source.edge(out.taken);
            if over {
                self.cycle = cycle + 1;
                let beyond = window::beyond(self.window.config(), play.window, moore);
                return (shaded, moore.end, beyond);
            }
            over = ended;
        }
        unreachable!()
    }

    /// All plays of a frame: what each pass of each window shades.
    fn frame(
        &mut self,
        passes: u32,
        count: u32,
        kills: &dyn Fn(u32, u32) -> bool,
        starts: &Pattern,
    ) -> Vec<Vec<Vec<u32>>> {
        let (mut all, mut window) = (vec![], 0);
        loop {
            let (mut of_window, mut end, mut beyond) = (vec![], 0, false);
            for pass in 0..passes {
                let play = Play { draws: false, shades: true, reads: pass > 0, window };
                let shaded;
                (shaded, end, beyond) = self.play(play, [pass, passes], count, kills, starts);
                of_window.push(shaded);
            }
            all.push(of_window);
            if !beyond {
                return all;
            }
            window = if self.survivors.is_some() { end } else { window + 1 };
        }
    }
}

/// An F-buffer of 2^`place_bits` places, of words with so many targets, that holds what is killed or drops it.
fn config(place_bits: u32, compacts: bool, targets: u32, bits: &str, reads: u32) -> Config {
    let kill = if compacts { "compact" } else { "keep" };
    let settings = [
        ("program", "sieve"),
        ("kill", kill),
        ("targets", &targets.to_string()),
        ("component_bits", bits),
    ];
    let mut cfg = ahead(&settings, reads);
    cfg.shader.window.places = Places::Counted(place_bits);
    cfg
}

proptest! {
    /// Whatever the memory: each fragment is in one window, and in every pass of it up to the one that kills it where it is dropped; it
    /// finds what the pass before has left of it; and a word is written and read once for each.
    #[test]
    fn no_fragment_is_shaded_twice_or_never(
        killed_in in prop::collection::vec(0..5u32, 0..40),
        place_bits in 0..5u32,
        compacts: bool,
        targets in 1..=4u32,
        bits in prop_oneof![Just("8"), Just("16"), Just("32")],
        reads in 1..9u32,
        passes in 2..4u32,
        stages in 1..=12usize,
        starts in pattern(),
        ready in pattern(),
        latencies in prop::collection::vec(1..30u64, 1..8),
    ) {
        let count = killed_in.len() as u32;
        let places = 1 << place_bits;
        let kills = |number: u32, pass: u32| killed_in[number as usize] == pass;
        let (mut expected, mut first, mut words) = (vec![], 0, 0);
        loop {
            let (mut end, mut left) = (first, 0);
            while end < count && left < places {
                left += u32::from(!compacts || killed_in[end as usize] > 0);
                end += 1;
            }
            let of_pass = |pass| {
                let shaded = |number: &u32| !compacts || killed_in[*number as usize] >= pass;
                (first..end).filter(shaded).collect::<Vec<u32>>()
            };
            expected.push((0..passes).map(of_pass).collect::<Vec<_>>());
            words += (1..passes).map(|pass| of_pass(pass).len()).sum::<usize>();
            if end == count {
                break;
            }
            first = end;
        }
        let cfg = config(place_bits, compacts, targets, bits, reads);
        let mut machine = Machine::new(cfg, stages, ready, latencies);
        prop_assert_eq!(&machine.frame(passes, count, &kills, &starts), &expected);
        // And of a frame after it.
        prop_assert_eq!(machine.frame(passes, count, &kills, &starts), expected);
        let requests = 2 * 2 * words as u64 * u64::from(cfg.parts());
        prop_assert_eq!(machine.requests.transfers, requests);
    }
}

#[test]
fn words_of_the_port_are_as_few_as_will_do() {
    let of = |compacts, targets, bits| {
        let cfg = config(2, compacts, targets, bits, 1);
        (cfg.parts(), cfg.port().bits, cfg.port().words)
    };
    // 32 bits and that of a kill; 128 and that; 512 and that.
    assert_eq!(of(false, 1, "8"), (1, 33, 4));
    assert_eq!(of(false, 1, "32"), (2, 128, 8));
    assert_eq!(of(false, 4, "32"), (5, 128, 20));
    // And the number in place of the bit.
    assert_eq!(of(true, 2, "8"), (1, 96, 4));
    assert_eq!(of(true, 4, "16"), (3, 128, 12));
    // Nothing is killed.
    let glass = |targets| ahead(&[("program", "glass"), ("targets", targets)], 1).parts();
    assert_eq!([glass("1"), glass("4")], [1, 4]);
}

/// A fragment for each word that the port moves: `p` cycles for one that is written or read, `2 p` for one that is both, whatever the
/// latency, with as many reads in flight.
#[test]
fn a_pass_is_bound_by_the_port() {
    for (compacts, targets, bits, parts) in
        [(false, 1, "8", 1), (true, 1, "32", 2), (true, 4, "16", 3), (false, 4, "32", 5)]
    {
        for latency in [1, 7, 200] {
            let cfg = config(10, compacts, targets, bits, latency + 4);
            assert_eq!(cfg.parts(), parts);
            let always = Pattern::always();
            let mut machine = Machine::new(cfg, 4, always.clone(), vec![latency.into()]);
            for (pass, ways) in [(0, 1), (1, 2), (2, 1)] {
                let play = Play { draws: false, shades: true, reads: pass > 0, window: 0 };
                let before = machine.cycle;
                machine.play(play, [pass, 3], 1000, &|_, _| false, &always);
                let cycles = machine.cycle - before;
                // Until the first word is there, and from the last fragment on to the end of the play.
                let around = u64::from(latency + parts) + 12;
                let least = 1000 * ways * u64::from(parts);
                assert!((least..=least + around).contains(&cycles), "{cycles}: {latency} {parts}");
            }
        }
    }
}

/// With `r` reads in flight and a latency of `L` a word comes in `(L + c) / r` cycles: one after the other takes the whole way.
#[test]
fn too_few_reads_in_flight_wait_for_the_latency() {
    let cycles = |count: u32| {
        let always = Pattern::always();
        let mut machine = Machine::new(config(8, false, 1, "8", 1), 4, always.clone(), vec![50]);
        for pass in 0..2 {
            let play = Play { draws: false, shades: true, reads: pass > 0, window: 0 };
            machine.play(play, [pass, 2], count, &|_, _| false, &always);
        }
        machine.cycle
    };
    // A read is answered after 50 cycles, is at the front one later, and the next one is asked for one after it is taken.
    assert_eq!(cycles(60) - cycles(30), 30 * (1 + 52));
}

#[test]
#[should_panic(expected = "the number of reads in flight is 0: expected at least 1")]
fn something_is_in_flight() {
    Ahead::reset(&config(2, false, 1, "8", 0));
}
