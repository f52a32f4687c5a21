//! What the image composition machine is made of.

use crate::primitive::Primitive;

crate::choice! {
    /// Which object-order engine an opaque primitive goes to.
    pub enum Distribution {
        /// To each in turn.
        RoundRobin = "round_robin",
        /// To the one that has the fewest pixels to draw so far.
        Area = "area",
    }
}

impl Distribution {
    /// A model of where primitives go, among so many engines.
    pub fn engines(self, engines: u32) -> Engines {
        Engines { by_area: self == Distribution::Area, turn: 0, loads: vec![0; engines as usize] }
    }
}

/// See [`Distribution::engines`].
#[derive(Clone, Debug)]
pub struct Engines {
    by_area: bool,
    turn: usize,
    loads: Vec<u64>,
}

impl Engines {
    /// The engine that the frame's next opaque primitive goes to.
    pub fn engine(&mut self, primitive: &Primitive) -> u32 {
        let turn = self.turn;
        self.turn = (turn + 1) % self.loads.len();
        let least = |(k, load): (usize, &u64)| (*load, k);
        let by_area = self.loads.iter().enumerate().map(least).min().map_or(0, |(_, k)| k);
        let engine = if self.by_area { by_area } else { turn };
        self.loads[engine] += u64::from(primitive.area) + 1;
        engine as u32
    }
}
