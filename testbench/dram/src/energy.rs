//! The energy that a memory has taken.

use crate::config::{Config, Refresh};
use crate::part::Energy;
use crate::statistics::Statistics;

pellucid_sim::counters! {
    /// The energy that a memory has taken, by what for: that of its devices, without what drives and ends the wires between.
    pub struct Spent {
        /// Opening rows of the memory outside, and closing them.
        activates: "pJ",
        /// Bursts read from the memory outside.
        reads: "pJ",
        /// Bursts written to the memory outside.
        writes: "pJ",
        /// Refreshes of the memory outside.
        refreshes: "pJ",
        /// What the memory outside takes all the time, with rows open.
        background: "pJ",
    }
}

impl Config {
    /// The energy of what was done; none where the part says nothing of it.
    pub fn spent(&self, done: &Statistics) -> Option<Spent> {
        let (o, timing) = (&self.part.organisation, &self.part.timing);
        let Energy { activate_pj, read_pj, write_pj, refresh_pj, background_mw } =
            self.part.energy?;
        // Background is that of all ranks of all buses: mW times ps are fJ.
        let ranks = u64::from(self.channels * o.pseudo_channels * self.ranks);
        let ps = u128::from(done.clocks) * u128::from(timing.tck_ps);
        let background = u128::from(background_mw * ranks) * ps / 1000;
        let parts = match self.refresh {
            Refresh::AllBank => 1,
            Refresh::PerBank => o.rank_banks() as u64,
        };
        Some(Spent {
            activates: done.activates * activate_pj,
            reads: done.bytes_read / o.burst_bytes() * read_pj,
            writes: done.bytes_written / o.burst_bytes() * write_pj,
            refreshes: done.refreshes * refresh_pj / parts,
            background: u64::try_from(background).unwrap_or(u64::MAX),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dram, Part, Request};
    use pellucid_sim::Figures;

    /// The currents of a device of 8 bits, mA, of which the file's figures are: DRAMsim3, configs/DDR4_8Gb_x8_3200.ini.
    const IDD0: f64 = 57.0;
    const IDD2N: f64 = 37.0;
    const IDD3N: f64 = 52.0;
    const IDD4R: f64 = 168.0;
    const IDD4W: f64 = 150.0;
    const IDD5AB: f64 = 250.0;
    const VDD: f64 = 1.2;
    const DEVICES: f64 = 8.0;

    #[test]
    fn the_figures_of_ddr4_are_those_of_its_currents() {
        let part = Part::named("ddr4-3200").unwrap();
        let ns = |clocks: u64| clocks as f64 * 0.625;
        let t = part.timing;
        let pj = |charge: f64| (VDD * charge * DEVICES).round() as u64;
        let standby = IDD3N * ns(t.ras) + IDD2N * ns(t.rc - t.ras);
        let expected = Energy {
            activate_pj: pj(IDD0 * ns(t.rc) - standby),
            read_pj: pj((IDD4R - IDD3N) * ns(t.burst)),
            write_pj: pj((IDD4W - IDD3N) * ns(t.burst)),
            refresh_pj: pj((IDD5AB - IDD3N) * ns(t.rfc)),
            background_mw: (VDD * IDD3N * DEVICES).round() as u64,
        };
        assert_eq!(part.energy, Some(expected));
    }

    fn config(ranks: u32, refresh: Refresh) -> Config {
        let mut part = Part::named("gddr6-14000").unwrap();
        part.energy = Some(Energy {
            activate_pj: 1_000_000,
            read_pj: 10,
            write_pj: 300,
            refresh_pj: 16_000,
            background_mw: 7,
        });
        Config { ranks, refresh, ..Config::new(part) }
    }

    /// Two reads of one row and a write of another, an interval between refreshes long.
    #[test]
    fn each_command_is_paid_for() {
        let refi = 3333;
        for (ranks, refresh, clocks, refreshes) in [
            (1, Refresh::AllBank, refi + 600, 16_000),
            // The second rank has its refresh half an interval later.
            (2, Refresh::AllBank, refi + refi / 2 + 600, 32_000),
            // A sixteenth each, sixteen in an interval.
            (1, Refresh::PerBank, refi + 150, 16_000),
        ] {
            let mut dram = Dram::new(config(ranks, refresh)).unwrap();
            let half = u64::try_from(dram.layout().capacity() / 2).unwrap();
            for (write, address) in [(false, 0), (false, 0), (true, half)] {
                assert!(dram.push(Request { write, address, tag: 0, client: 0 }));
            }
            (0..clocks).for_each(|_| dram.cycle());
            let spent = dram.config().spent(&dram.statistics()).unwrap();
            let (picoseconds, buses) = (clocks * 570, u64::from(ranks));
            let expected = Spent {
                activates: 2_000_000,
                reads: 20,
                writes: 300,
                refreshes,
                background: 7 * buses * picoseconds / 1000,
            };
            assert_eq!(spent, expected, "{refresh} of {ranks}");
            assert!(spent.figures().iter().all(|figure| figure.unit == "pJ"));
        }
    }

    #[test]
    fn a_part_without_figures_says_nothing() {
        let config = Config::new(Part::named("hbm3-6400").unwrap());
        assert_eq!(config.spent(&Statistics::default()), None);
    }
}
