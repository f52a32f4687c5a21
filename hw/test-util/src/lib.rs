//! What the tests of several blocks share: streams that come and go at random, and memories beside
//! the block under test.

pub mod behind;

use pellucid_machine::pixel::{Fragment, Screen, Z_FAR};
use pellucid_machine::primitive::{
    Attributes, BOUND_BITS, CHANNEL_PLANE_BITS, Edge, Primitive, Side, Z_PLANE_BITS,
};
use pellucid_sim::{Block, FaultKind, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream};
use proptest::prelude::*;
use std::collections::VecDeque;

/// A screen with a background that is neither black nor white.
pub fn screen(width: u32, height: u32) -> Screen {
    Screen { width, height, background: 0x10_20_30 }
}

/// In which cycles something happens; repeats without end, and holds at least one cycle in which it
/// does.
#[derive(Clone, Debug)]
pub struct Pattern(Vec<bool>);

impl Pattern {
    /// In every cycle.
    pub fn always() -> Pattern {
        Pattern(vec![true])
    }
    /// In the cycles of `cycles` that are true, over and over.
    pub fn of(cycles: Vec<bool>) -> Pattern {
        assert!(cycles.contains(&true), "it would never happen");
        Pattern(cycles)
    }
    /// Whether it happens in `cycle`.
    pub fn at(&self, cycle: u64) -> bool {
        self.0[(cycle % self.0.len() as u64) as usize]
    }
}

/// Every cycle, or some at random.
pub fn pattern() -> impl Strategy<Value = Pattern> {
    let random = proptest::collection::vec(any::<bool>(), 1..24).prop_map(|mut cycles| {
        cycles.push(true);
        Pattern(cycles)
    });
    prop_oneof![1 => Just(Pattern::always()), 3 => random]
}

/// The sending end of a stream: offers one item after the other, each until it is taken.
#[derive(Clone, Debug)]
pub struct Source<T> {
    items: VecDeque<T>,
    starts: Pattern,
    offered: bool,
}

impl<T: Copy + Default> Source<T> {
    /// Sends `items`; offers begin in the cycles of `starts`.
    pub fn new(items: impl IntoIterator<Item = T>, starts: Pattern) -> Source<T> {
        Source { items: items.into_iter().collect(), starts, offered: false }
    }
    /// What is offered in `cycle`.
    pub fn offer(&mut self, cycle: u64) -> Stream<T> {
        self.offered |= self.starts.at(cycle);
        match self.items.front() {
            Some(item) if self.offered => Stream::offer(*item),
            _ => Stream::idle(),
        }
    }
    /// The cycle ends; what was offered is taken if `ready`.
    pub fn edge(&mut self, ready: bool) {
        if self.offered && ready {
            self.items.pop_front();
            self.offered = false;
        }
    }
}

/// The edge of a memory beside the block under test: a misuse fails the test.
pub fn edge(memory: &mut impl Memory) {
    let fault = memory.clock();
    memory.visit("memory", &mut |path, storage| {
        let kind = storage.take_fault();
        assert!(!fault || kind.is_none(), "{path}: {kind:?}");
    });
}

/// A block under the clock whose registers' widths depend on less than its configuration, if it has any.
pub struct Clocked<B: Block> {
    cfg: B::Config,
    q: B::State,
    mem: B::Mem,
}

impl<B: Block> Clocked<B> {
    /// The block at power-up.
    pub fn new(cfg: B::Config) -> Clocked<B> {
        let (q, mem) = (B::reset(&cfg), B::memories(&cfg));
        Clocked { cfg, q, mem }
    }
    /// One cycle; a misuse of a memory is an error.
    pub fn clock(&mut self, i: B::In) -> Result<B::Out, FaultKind> {
        let q = self.q.clone();
        let out = B::next(&self.cfg, &q, &mut self.q, &mut self.mem, i);
        let mut fault = None;
        if self.mem.clock() {
            self.mem.visit("", &mut |_, storage| fault = fault.take().or(storage.take_fault()));
        }
        fault.map_or(Ok(out), Err)
    }
    /// What it shows.
    pub fn moore(&self) -> B::Moore {
        B::moore(&self.cfg, &self.q, &self.mem)
    }
    /// Its memories.
    pub fn memories(&mut self) -> &mut B::Mem {
        &mut self.mem
    }
}

/// Words read from a memory so far, and words written to it.
pub fn traffic(memory: &mut impl Memory) -> (u64, u64) {
    let (mut reads, mut writes) = (0, 0);
    memory.visit("memory", &mut |_, storage| {
        reads += storage.info().reads;
        writes += storage.info().writes;
    });
    (reads, writes)
}

/// A memory of latency 1 that holds `words`, whose widths depend on `item`.
pub fn holding<T: Signals + Default>(
    words: &[T],
    item: T::Config,
    policy: ReadDuringWrite,
) -> Ram1R1W<T> {
    let mut ram = Ram1R1W::new(words.len() as u32, item, 1, policy);
    for (addr, word) in words.iter().enumerate() {
        ram.write(addr as u32, *word);
        edge(&mut ram);
    }
    ram
}

/// What a memory of latency 1 and `words` words holds.
pub fn contents<T: Signals + Default>(ram: &mut Ram1R1W<T>, words: u32) -> Vec<T> {
    let read = |addr| {
        ram.read(addr);
        edge(ram);
        ram.q().data
    };
    (0..words).map(read).collect()
}

/// A triangle: corners in 1/256 pixel, and depth and colour as planes in 2^-16: what they are in the middle
/// of the upper left pixel, and what they gain with each column and row.
#[derive(Clone, Debug, Default)]
pub struct Triangle {
    /// Column and row of each corner.
    pub corners: [(i64, i64); 3],
    /// Depth.
    pub z: [i64; 3],
    /// Red, green, blue and alpha.
    pub colour: [[i64; 3]; 4],
    /// All of it hides what lies behind it.
    pub opaque: bool,
}

/// A line that a triangle lies on one side of: `a * column + b * row + c` is at least 0 in its pixels.
type Line = (i64, i64, i64);

impl Triangle {
    /// The lines of its edges; none if it has no area.
    fn lines(&self) -> Option<[Line; 3]> {
        let [a, mut b, mut c] = self.corners;
        let area = (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
        if area < 0 {
            (b, c) = (c, b);
        }
        let line = |from: (i64, i64), to: (i64, i64)| {
            let (dx, dy) = (to.0 - from.0, to.1 - from.1);
            let owns = dy < 0 || (dy == 0 && dx > 0);
            let middle = dx * (128 - from.1) - dy * (128 - from.0);
            (-dy, dx, (middle - i64::from(!owns)).div_euclid(256))
        };
        (area != 0).then(|| [line(b, c), line(c, a), line(a, b)])
    }

    /// Its fragments, row by row from left to right, by definition.
    pub fn fragments(&self, screen: Screen) -> Vec<Fragment> {
        let Some(lines) = self.lines() else { return vec![] };
        let mut fragments = vec![];
        for y in 0..screen.height {
            for x in 0..screen.width {
                let (column, row) = (i64::from(x), i64::from(y));
                if lines.iter().all(|(a, b, c)| a * column + b * row + c >= 0) {
                    let at = |[at, dx, dy]: [i64; 3], bits: u32, most: i64| {
                        // What does not fit wraps, as two's complement does.
                        let spare = 64 - bits;
                        let value = (at + dx * column + dy * row) << spare >> spare;
                        (value >> 16).clamp(0, most) as u32
                    };
                    let [red, green, blue] = [0, 1, 2].map(|k| at(self.colour[k], 26, 255));
                    let alpha = if self.opaque { 255 } else { at(self.colour[3], 26, 254) };
                    fragments.push(Fragment {
                        x,
                        y,
                        z: at(self.z, 42, Z_FAR.into()),
                        rgba: red << 24 | green << 16 | blue << 8 | alpha,
                        ..Fragment::default()
                    });
                }
            }
        }
        fragments
    }
}

/// A triangle set up; nothing if no row of the screen is its.
pub fn triangle(screen: Screen, triangle: &Triangle) -> Option<Primitive> {
    let lines = triangle.lines()?;
    let low = |of: fn(&(i64, i64)) -> i64| triangle.corners.iter().map(of).min().unwrap_or(0);
    let high = |of: fn(&(i64, i64)) -> i64| triangle.corners.iter().map(of).max().unwrap_or(0);
    let rows = ((low(|c| c.1) + 127).div_euclid(256)).max(0)
        ..=((high(|c| c.1) - 128).div_euclid(256)).min(i64::from(screen.height) - 1);
    let level = |y: &i64| lines.iter().all(|(a, b, c)| *a != 0 || b * y + c >= 0);
    let rows: Vec<i64> = rows.filter(level).collect();
    let (first, last) = (*rows.first()?, *rows.last()?);
    let bits = |value: i64, bits: u32| value as u64 & ((1 << bits) - 1);
    let edges = lines.map(|(a, b, c)| {
        let (height, at) = (a.abs(), b * first + c);
        match a.signum() {
            0 => Edge::default(),
            sign => Edge {
                side: if sign > 0 { Side::Left } else { Side::Right },
                bound: bits(at.div_euclid(height), BOUND_BITS),
                bound_step: bits(b.div_euclid(height), BOUND_BITS),
                rest: at.rem_euclid(height) as u32,
                rest_step: b.rem_euclid(height) as u32,
                height: height as u32,
            },
        }
    });
    let attributes = |of: fn([i64; 3], i64) -> i64| {
        let [red, green, blue, alpha] =
            triangle.colour.map(|plane| bits(of(plane, first), CHANNEL_PLANE_BITS) as u32);
        Attributes { z: bits(of(triangle.z, first), Z_PLANE_BITS), red, green, blue, alpha }
    };
    Some(Primitive {
        row: first as u32,
        last_row: last as u32,
        edges,
        at: attributes(|[at, _, dy], first| at + dy * first),
        per_column: attributes(|[_, dx, _], _| dx),
        per_row: attributes(|[_, _, dy], _| dy),
        opaque: triangle.opaque,
        ..Primitive::default()
    })
}

/// A triangle that has a row, set up.
pub fn primitive(screen: Screen, of: &Triangle) -> Primitive {
    triangle(screen, of).unwrap()
}

/// A fragment as a primitive that has just that pixel.
pub fn point(fragment: Fragment) -> Primitive {
    let Fragment { x, y, z, rgba, .. } = fragment;
    let plane = |value: u32| [i64::from(value) << 16, 0, 0];
    let (left, top) = (i64::from(x) * 256, i64::from(y) * 256);
    let of = Triangle {
        corners: [(left, top), (left + 500, top), (left, top + 500)],
        z: plane(z),
        colour: rgba.to_be_bytes().map(|channel| plane(channel.into())),
        opaque: fragment.is_opaque(),
    };
    primitive(Screen { width: x + 1, height: y + 1, background: 0 }, &of)
}
