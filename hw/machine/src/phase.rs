//! The phases of an architecture, by name, and the cycles that it spends in each.

use pellucid_sim::Figure;

/// A phase of an architecture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseInfo {
    /// Its name: of its cycles among the figures, and of the window of a waveform that shows its begin.
    pub name: &'static str,
    /// What its cycles are, in one sentence.
    pub about: &'static str,
    /// A frame is worked on: its cycles are part of the total.
    pub works: bool,
    /// Its cycles are a figure.
    pub counts: bool,
}

/// The most phases of an architecture.
pub const MAX_PHASES: usize = 16;

/// Counts the cycles of each phase.
#[derive(Clone, Debug, Default)]
pub struct PhaseCounts {
    phases: [u64; MAX_PHASES],
    scanout: u64,
}

impl PhaseCounts {
    /// One cycle: the number of its phase, and whether an image is being shown.
    #[inline(always)]
    pub fn observe(&mut self, phase: u8, scanout: bool) {
        self.phases[usize::from(phase) % MAX_PHASES] += 1;
        self.scanout += u64::from(scanout);
    }

    /// What was counted of a machine with these phases.
    pub fn cycles(&self, phases: &'static [PhaseInfo]) -> Cycles {
        let counted = phases.iter().zip(self.phases);
        let works = counted.clone().filter(|(phase, _)| phase.works);
        let counts = counted.filter(|(phase, _)| phase.counts);
        Cycles {
            total: works.map(|(_, cycles)| cycles).sum(),
            phases: counts.collect(),
            scanout: self.scanout,
        }
    }
}

/// Cycles by phase.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cycles {
    /// Those of all phases in which a frame is worked on, over all frames.
    pub total: u64,
    /// Those of each phase that counts.
    pub phases: Vec<(&'static PhaseInfo, u64)>,
    /// Showing images, beside the next frame.
    pub scanout: u64,
}

impl Cycles {
    /// Those of the phase of that name, if there is one.
    pub fn of(&self, name: &str) -> Option<u64> {
        self.phases.iter().find(|(phase, _)| phase.name == name).map(|(_, cycles)| *cycles)
    }

    /// Those before the last cycle, which was one of that phase. What was shown in it is not known: scanout stays.
    #[must_use]
    pub fn before_one_of(mut self, last: &PhaseInfo) -> Cycles {
        self.total -= u64::from(last.works);
        for (phase, cycles) in &mut self.phases {
            *cycles -= u64::from(phase.name == last.name);
        }
        self
    }

    /// Those since the same machine had counted `earlier`.
    #[must_use]
    pub fn since(&self, earlier: &Cycles) -> Cycles {
        let phase = |(phase, cycles): &(&'static PhaseInfo, u64)| {
            (*phase, cycles - earlier.of(phase.name).unwrap_or(0))
        };
        Cycles {
            total: self.total - earlier.total,
            phases: self.phases.iter().map(phase).collect(),
            scanout: self.scanout - earlier.scanout,
        }
    }

    /// All of them as figures, the total first.
    pub fn figures(&self) -> Vec<Figure> {
        let figure = |name, about, value| Figure { name, unit: "cycles", about, value };
        let mut figures = vec![figure(
            "total",
            "All phases in which a frame is worked on together, over all frames.",
            self.total,
        )];
        figures.extend(self.phases.iter().map(|(phase, n)| figure(phase.name, phase.about, *n)));
        let about = "Showing images; beside the next frame's store.";
        figures.push(figure("scanout", about, self.scanout));
        figures
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_added_up_and_what_does_not_count_is_left_out() {
        const fn phase(name: &'static str, works: bool, counts: bool) -> PhaseInfo {
            PhaseInfo { name, about: "", works, counts }
        }
        const PHASES: &[PhaseInfo] = &[
            phase("idle", false, false),
            phase("count", true, true),
            phase("scan", true, true),
            phase("wait", false, true),
        ];
        let mut counts = PhaseCounts::default();
        for (phase, shows) in [(0, true), (1, true), (1, false), (2, false), (3, false), (0, false)]
        {
            counts.observe(phase, shows);
        }
        let cycles = counts.cycles(PHASES);
        assert_eq!((cycles.total, cycles.scanout), (3, 2));
        let of = ["count", "scan", "wait", "idle", "resolve"].map(|name| cycles.of(name));
        assert_eq!(of, [Some(2), Some(1), Some(1), None, None]);
        let [idle, count, ..] = PHASES else { panic!("four phases") };
        assert_eq!(cycles.clone().before_one_of(idle), cycles);
        let earlier = cycles.clone().before_one_of(count);
        assert_eq!((earlier.total, earlier.of("count"), earlier.of("scan")), (2, Some(1), Some(1)));
        let one = cycles.since(&earlier);
        assert_eq!((one.total, one.of("count"), one.of("scan")), (1, Some(1), Some(0)));
        assert_eq!(cycles.since(&Cycles::default()), cycles);
        let figures: Vec<_> = cycles.figures().iter().map(|f| (f.name, f.value)).collect();
        assert_eq!(figures, [("total", 3), ("count", 2), ("scan", 1), ("wait", 1), ("scanout", 2)]);
    }
}
