//! The library's counters keep their contract; faults of every kind are found out.

use crate::found::{self, fault};
use pellucid_blocks::array::config::Config;
use pellucid_blocks::array::counters::{self, Counters, Counts};
use pellucid_blocks::array::index::{self, Index};
use pellucid_properties::counters::{Counted, Counting, Model, Property};
use pellucid_properties::counters_properties;
use pellucid_sim::{Block, Memory, Ram1R1W, Read, ReadDuringWrite, WritePort};

counters_properties!(Counted);

/// What is wrong with [`Unit`].
const SLOW: u32 = 1;
const UNTOLD: u32 = 2;
const GREEDY: u32 = 3;
const LATE: u32 = 4;
const WRAPPED: u32 = 5;
const DOUBLE: u32 = 6;
const TWICE: u32 = 7;
const EARLY: u32 = 8;
/// What is wrong with [`Words`].
const OLD: u32 = 1;
const LOST: u32 = 2;
const SILENT: u32 = 3;
const KEPT: u32 = 4;

/// The library's unit that counts, and a fault.
struct Unit;

impl Block for Unit {
    type Config = Config;
    type State = index::State;
    type In = index::In;
    type Moore = index::Moore;
    type Out = index::Out;
    type Mem = index::Mem;

    fn reset(cfg: &Config) -> index::State {
        Index::reset(cfg)
    }
    fn memories(cfg: &Config) -> index::Mem {
        Index::memories(cfg)
    }
    fn moore(cfg: &Config, q: &index::State, m: &index::Mem) -> index::Moore {
        let mut seen = Index::moore(cfg, q, m);
        seen.ready &= fault() != SLOW || !q.stage.valid;
        seen
    }
    fn next(
        cfg: &Config,
        q: &index::State,
        d: &mut index::State,
        m: &mut index::Mem,
        i: index::In,
    ) -> index::Out {
        let mut out = Index::next(cfg, q, d, m, i);
        let pixel = q.stage.payload.item.pixel;
        let at_hand = q.stage.valid && !q.stage.payload.end;
        let lane = cfg.lane_of(pixel) as usize;
        let mut put = |count| {
            let mut counts = i.counts.data;
            counts.of[lane] = count;
            out.count_write = WritePort::default();
            out.count_write.write(cfg.word_of(pixel), counts);
        };
        match fault() {
            WRAPPED if at_hand && !out.counted => put(0),
            DOUBLE if out.counted && i.counts.data.of[lane] + 2 <= cfg.limit() => {
                put(i.counts.data.of[lane] + 2);
            }
            UNTOLD => out.counted &= pixel != 1,
            GREEDY => out.counted |= at_hand,
            LATE if out.ended && pixel == 0 => {
                out.ended = false;
                d.stage = q.stage;
                d.stage.payload.item.pixel = 1;
            }
            TWICE if out.counted => out.count_write.write(cfg.word_of(pixel), i.counts.data),
            EARLY => out.ended |= at_hand && pixel == 1,
            _ => {}
        }
        out
    }
}

impl Counting for Unit {
    fn latency(cfg: &Config) -> u32 {
        Index::latency(cfg)
    }
}

/// A memory of counters, and a fault.
struct Words;

#[derive(Memory)]
struct Mem {
    words: Ram1R1W<Counts>,
}

impl Block for Words {
    type Config = Config;
    type State = ();
    type In = counters::In;
    type Moore = Read<Counts>;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) {}
    fn memories(cfg: &Config) -> Mem {
        let meets = if fault() == OLD { ReadDuringWrite::Old } else { ReadDuringWrite::New };
        Mem { words: Ram1R1W::new(cfg.words(), *cfg, 1, meets) }
    }
    fn moore(_: &Config, (): &(), m: &Mem) -> Read<Counts> {
        let mut seen = m.words.q();
        seen.valid &= fault() != SILENT || seen.data.of[0] != 1;
        seen
    }
    fn next(cfg: &Config, (): &(), (): &mut (), m: &mut Mem, mut i: counters::In) {
        if fault() == LOST && i.index_read.asked().is_some() {
            i.index_write = WritePort::default();
        }
        if fault() == KEPT {
            i.walk_write = WritePort::default();
        }
        for port in [i.index_read, i.sum_read, i.walk_read] {
            m.words.pass_read(port);
        }
        for port in [i.index_write, i.sum_write, i.walk_write] {
            m.words.pass_write(port);
        }
        if i.clear.valid && i.clear.payload < cfg.words() {
            m.words.write(i.clear.payload, Counts::default());
        }
    }
}

fn unit_is_found(fault: u32, property: Property) {
    found::is_found::<Model<Counted<Unit, Counters>>>(fault, property);
}

fn words_are_found(fault: u32, property: Property) {
    found::is_found::<Model<Counted<Index, Words>>>(fault, property);
}

#[test]
fn a_unit_that_does_not_take_one_a_cycle_is_found() {
    unit_is_found(SLOW, Property::Ready);
}

#[test]
fn a_fragment_that_is_not_told_or_told_without_being_counted_is_found() {
    unit_is_found(UNTOLD, Property::Counted);
    unit_is_found(GREEDY, Property::Counted);
}

#[test]
fn an_end_that_is_late_or_early_is_found() {
    unit_is_found(LATE, Property::End);
    unit_is_found(EARLY, Property::End);
}

#[test]
fn a_counter_that_goes_beyond_its_limit_is_found() {
    unit_is_found(WRAPPED, Property::Limit);
}

#[test]
fn a_wrong_count_is_found() {
    unit_is_found(DOUBLE, Property::Counts);
    words_are_found(LOST, Property::Counts);
}

#[test]
fn a_read_that_meets_a_write_and_shows_the_old_word_is_found() {
    words_are_found(OLD, Property::Meets);
    words_are_found(KEPT, Property::Meets);
}

#[test]
fn a_word_that_is_not_shown_is_found() {
    words_are_found(SILENT, Property::Valid);
}

#[test]
fn a_port_that_is_used_twice_is_found() {
    unit_is_found(TWICE, Property::Fault);
}

/// The shortest sequence for two fragments in a row of which the second does not see the first.
#[test]
fn a_failure_is_short_and_has_its_waveform() {
    let (message, folder) = found::found::<Model<Counted<Index, Words>>>(LOST);
    let expected = format!(
        "broken in cycle 7: a counter has how many fragments its pixel had: pixel 0 has 1 where 2 is due\n\
         its waveform: gtkwave {}\n\
         1 pixels, 1 in a word, counted to 2, cycle by cycle:\n     \
         0  clear 0\n     1  a fragment of pixel 0\n     2  a fragment of pixel 0\n     \
         3  the frame ends\n     4  nothing\n     5  nothing\n     6  the sum reads word 0\n     \
         7  nothing",
        folder.path().join("wave.gtkw").display()
    );
    assert_eq!(message, expected);
    found::has_marker(&folder, Property::Counts);
    let written = found::shown(&folder, "counters.wires.out.seen.counts.valid");
    assert_eq!(written, [(0, 0), (3, 1), (5, 0), (7, 1)]);
}
