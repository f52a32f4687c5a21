//! A front that is clocked alone, while all else in its machine rests: it clears memories, or shows an image between frames. Its
//! frame buffer is on chip: one outside has the port to share.

use super::{Config, Front, In, Mem, Moore, State};
use crate::scanout;
use crate::sequencer::Phase;
use pellucid_machine::pixel::Screen;
use pellucid_sim::{Block, Memory, Signals};

/// In the coming cycle it has work that it may do alone.
pub fn may_be_alone(q: &State) -> bool {
    match q.sequencer.phase {
        Phase::Clear => q.sequencer.clear.valid,
        Phase::Idle => q.display.scanout.fsm != scanout::Fsm::Idle,
        Phase::Store | Phase::Resolve | Phase::Wait => false,
    }
}

/// A cycle of it with its memories: what it shows before, and whether a memory is at fault. Nothing where something comes that it would
/// take.
#[inline(always)]
pub fn alone(
    cfg: &Screen,
    q: &mut State,
    d: &mut State,
    m: &mut Mem,
    comes: bool,
    image_ready: bool,
) -> Option<(Moore, bool)> {
    if comes && d.sequencer.phase != Phase::Clear {
        return None;
    }
    let cfg = &Config::on_chip(*cfg);
    q.follow(cfg, d);
    let seen = Front::moore(cfg, q, m);
    Front::next(cfg, q, d, m, In { image_ready, cleared: true, ..In::default() });
    debug_assert!(d.check(cfg).is_ok(), "a register of the front overflows");
    Some((seen, m.clock()))
}

/// Within the implementation of [`Machine`](pellucid_machine::Machine) for a machine of fragments whose registers and memories
/// have a `front`: clocks that [alone](pellucid_machine::Machine::alone). The first expression is whether the frame buffer lies
/// outside; it has the configuration. The second one clears what else is cleared in the same cycle, memories clocked, and is
/// whether one of these is at fault, or nothing where that takes longer; it has registers before and after the edge, memories, and
/// a stream of what is cleared, too.
#[macro_export]
macro_rules! front_alone {
    (|$cfg:ident, $q:ident, $d:ident, $m:ident, $clear:ident| $outside:expr, $clears:expr) => {
        const FRONT: Option<&'static str> = Some("front");

        fn may_be_alone($cfg: &Self::Config, q: &Self::State) -> bool {
            !$outside && $crate::front::alone::may_be_alone(&q.front)
        }

        #[inline(always)]
        fn alone(
            $cfg: &Self::Config,
            $q: &mut Self::State,
            $d: &mut Self::State,
            $m: &mut Self::Mem,
            i: &Self::In,
            out: &mut Self::Out,
        ) -> Option<bool> {
            let $clear = $d.front.sequencer.clear;
            let mut fault = false;
            if $clear.valid {
                fault = $clears?;
            }
            let (comes, image_ready) = (i.fragment.valid, i.image_ready);
            let (q, d, m) = (&mut $q.front, &mut $d.front, &mut $m.front);
            let (seen, of_front) =
                $crate::front::alone::alone(&$cfg.screen, q, d, m, comes, image_ready)?;
            out.fragment = i.fragment.with(seen.status.ready);
            out.image = seen.status.image.with(image_ready);
            out.events.scanout = seen.status.shows;
            Some(fault | of_front)
        }
    };
}
