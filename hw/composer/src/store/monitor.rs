//! Watches a fragment store behind the merger.

use super::{Config, FragmentStore, Out, State, Store};
use crate::transparency::{Transparency, Watch};
use pellucid_machine::monitor::{above, below, seen_from};
use pellucid_machine::primitive::pixels;
use pellucid_machine::{
    Arithmetic, Census, Check, Memories, Monitor, Outside, Room, Tally, outside,
};
use pellucid_sim::{Figures, Handshake, StorageInfo, Violation, Wait};

pellucid_sim::counters! {
    /// Figures of what waits for the fragment store.
    pub struct StoreCounters {
        /// Transparent primitives for which there was no place.
        lost_primitives: "primitives",
    }
}

/// See the module's description.
pub struct StoreMonitor<M: FragmentStore> {
    store: M::Monitor,
    lost_primitives: u64,
    lost: u64,
    /// The most primitives that a bank held.
    primitives: u64,
}

/// A machine's name for whoever sends it fragments.
const SOURCE: &str = "source";
/// Who that is here.
const SENDER: &str = "transparency";
/// Where its memories are.
const STORE: &str = "store.";

fn here(block: &'static str) -> &'static str {
    if block == SOURCE { SENDER } else { block }
}

impl<M: FragmentStore> Transparency for Store<M> {
    type Monitor = StoreMonitor<M>;

    fn arithmetic(cfg: &Config<M::Config>) -> Arithmetic {
        M::arithmetic(&cfg.store)
    }

    fn port(cfg: &Config<M::Config>) -> outside::Config {
        M::port(&cfg.store)
    }

    fn outside(cfg: &Config<M::Config>) -> Option<Outside> {
        M::outside(&cfg.store).map(|memory| memory.within("store"))
    }

    #[inline(always)]
    fn wires(cfg: &Config<M::Config>, out: &Out<M>) -> outside::Wires {
        M::ports(&cfg.store, &out.store).outside
    }

    fn room(cfg: &Config<M::Config>, frame: &Census) -> Option<Room> {
        M::room(&cfg.store, frame).map(|room| room.of_part(cfg.part))
    }

    fn closed_forms(cfg: &Config<M::Config>, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        M::closed_forms(&cfg.store, &seen_from(STORE, tally), frames)
    }
}

impl<M: FragmentStore> Watch<Store<M>> for StoreMonitor<M> {
    fn new(cfg: &Config<M::Config>) -> StoreMonitor<M> {
        let store = M::Monitor::new(&cfg.store);
        StoreMonitor { store, lost_primitives: 0, lost: 0, primitives: 0 }
    }

    #[inline(always)]
    fn observe(
        &mut self,
        cfg: &Config<M::Config>,
        q: &State<M>,
        o: &Out<M>,
        _: Handshake<u32>,
    ) -> Result<(), Violation> {
        if o.lost.valid {
            self.lost_primitives += 1;
            self.lost += pixels(&o.lost.payload, cfg.screen().width);
        }
        self.primitives = self.primitives.max(q.primitives.filled.into());
        self.store.observe(&cfg.store, &q.store, &o.store)
    }

    fn transfers(&self) -> u64 {
        self.store.transfers()
    }

    fn waits(&self, q: &State<M>) -> Vec<Wait> {
        let waits = self.store.deadlock(0, 0, &q.store).waits.into_iter();
        waits.map(|w| Wait { block: here(w.block), other: here(w.other), ..w }).collect()
    }

    fn tally(&self, cfg: &Config<M::Config>, memories: &[(String, StorageInfo)]) -> Tally {
        let [inside, around] = below(STORE, memories);
        let mut around = Memories::new(&around);
        for bank in ["primitives.first", "primitives.second"] {
            around.set_peak(bank, self.primitives);
        }
        let mut tally = self.store.tally(&cfg.store, &inside);
        let inside = std::mem::replace(&mut tally.memories, around.tallies());
        tally.memories.extend(above(STORE, inside));
        tally.streams.iter_mut().for_each(|s| s.from = here(s.from));
        // Opaque ones are the merged image's pixels.
        let f = &mut tally.fragments;
        f.arrived = f.arrived - f.drawn - f.hidden + self.lost;
        f.dropped += self.lost;
        if self.lost > 0 {
            tally.dropped_since = "a frame had too many transparent primitives (see `primitives`)";
        }
        tally.own.extend(StoreCounters { lost_primitives: self.lost_primitives }.figures());
        tally
    }
}
