//! Each rule by hand: a pair of commands that is illegal at clock n-1 and legal at clock n, for the checker and for the table
//! that the scheduler obeys. The numbers are written out, from the parts' data: none is computed here.

use crate::checker::Checker;
use pellucid_dram::Command::{self, *};
use pellucid_dram::device::Device;
use pellucid_dram::{Config, Issued, Part, Refresh, constraints};

/// Commands at clocks to banks, legal by themselves; then the command that must wait, its bank, until which clock, and by which
/// rule.
struct Pair(&'static [(u64, Command, usize)], Command, usize, u64, &'static str);

/// Banks of both parts: four to a group, 16 to a rank. Row 1 throughout.
fn hold(config: &Config, pairs: &[Pair]) {
    let table = constraints(config);
    for Pair(before, command, bank, n, rule) in pairs {
        let mut device = Device::new(config, &table);
        for &(clock, command, bank) in *before {
            assert!(
                device.earliest(command, bank) <= clock,
                "{rule}: {command:?} at {clock} is too early"
            );
            device.issue(command, bank, 1, clock);
        }
        assert_eq!(device.earliest(*command, *bank), *n, "{rule}: {before:?}, then {command:?}");
        for (clock, expected) in [(n - 1, &[*rule][..]), (*n, &[])] {
            let mut checker = Checker::new(config);
            let mut broken = vec![];
            let last = (clock, *command, *bank);
            for &(clock, command, bank) in before.iter().chain([&last]) {
                broken.extend(checker.command(Issued { clock, command, channel: 0, bank, row: 1 }));
            }
            // Bursts that follow too soon meet on the data bus, too, where `ccd_s` is no longer than one.
            let rules = broken.iter().map(|breach| breach.rule).filter(|&rule| rule != "burst");
            let rules: Vec<&str> = rules.collect();
            assert_eq!(rules, expected, "{before:?}, then {command:?} at {clock}");
        }
    }
}

#[test]
fn ddr4() {
    let config = Config { ranks: 2, ..Config::new(Part::named("ddr4-3200").unwrap()) };
    hold(
        &config,
        &[
            Pair(&[(0, Activate, 0)], Read, 0, 22, "rcd_read"),
            Pair(&[(0, Activate, 0)], Write, 0, 22, "rcd_write"),
            Pair(&[(0, Activate, 0)], Precharge, 0, 52, "ras"),
            Pair(&[(0, Activate, 0)], PrechargeAll, 0, 52, "ras"),
            Pair(&[(0, Activate, 0), (60, Precharge, 0)], Activate, 0, 82, "rp"),
            Pair(&[(0, Activate, 0), (60, PrechargeAll, 0)], Activate, 5, 82, "rp"),
            Pair(&[(0, Activate, 0), (60, PrechargeAll, 0)], Refresh, 0, 82, "rp"),
            Pair(&[(0, Activate, 0), (60, Precharge, 0)], Refresh, 0, 82, "rp"),
            Pair(&[(0, Activate, 0), (50, Read, 0)], Precharge, 0, 62, "rtp"),
            Pair(&[(0, Activate, 0), (50, Read, 0)], PrechargeAll, 0, 62, "rtp"),
            // 16 until the data, 4 of data, 24 of recovery.
            Pair(&[(0, Activate, 0), (22, Write, 0)], Precharge, 0, 66, "wr"),
            Pair(&[(0, Activate, 0), (22, Write, 0)], PrechargeAll, 0, 66, "wr"),
            Pair(&[(0, Activate, 0), (100, Activate, 4), (122, Read, 0)], Read, 4, 126, "ccd_s"),
            Pair(&[(0, Activate, 0), (100, Activate, 1), (122, Read, 0)], Read, 1, 130, "ccd_l"),
            Pair(&[(0, Activate, 0), (100, Activate, 4), (122, Write, 0)], Write, 4, 126, "ccd_s"),
            Pair(&[(0, Activate, 0), (100, Activate, 1), (122, Write, 0)], Write, 1, 130, "ccd_l"),
            Pair(&[(0, Activate, 0), (100, Activate, 4), (122, Write, 0)], Read, 4, 146, "wtr_s"),
            Pair(&[(0, Activate, 0), (100, Activate, 1), (122, Write, 0)], Read, 1, 154, "wtr_l"),
            Pair(&[(0, Activate, 0), (100, Activate, 4), (122, Read, 0)], Write, 4, 134, "rtw"),
            Pair(&[(0, Activate, 0)], Activate, 4, 4, "rrd_s"),
            Pair(&[(0, Activate, 0)], Activate, 1, 8, "rrd_l"),
            // The fourth of four activates is at 12; without the window the fifth could come at 20.
            Pair(
                &[(0, Activate, 0), (4, Activate, 4), (8, Activate, 8), (12, Activate, 12)],
                Activate,
                1,
                34,
                "faw",
            ),
            Pair(&[(0, Refresh, 0)], Activate, 3, 560, "rfc"),
            Pair(&[(0, Refresh, 0)], Refresh, 0, 560, "rfc"),
            // Banks 16 and up are those of the other rank. Data of 4 clocks, 2 of rest.
            Pair(
                &[(0, Activate, 0), (1, Activate, 16), (40, Read, 0)],
                Read,
                16,
                46,
                "rank_switch",
            ),
            Pair(
                &[(0, Activate, 0), (1, Activate, 16), (40, Write, 0)],
                Write,
                16,
                46,
                "rank_switch",
            ),
            // Read data from 62 to 66; a write's data begin 16 after it.
            Pair(
                &[(0, Activate, 0), (1, Activate, 16), (40, Read, 0)],
                Write,
                16,
                52,
                "rank_switch",
            ),
        ],
    );
}

/// What DDR4 has not, or not apart from other rules.
#[test]
fn others() {
    let text = Part::file("hbm3-6400").unwrap();
    let hbm = Config::new(Part::named("hbm3-6400").unwrap());
    let hbm = Config { refresh: Refresh::PerBank, ..hbm };
    hold(
        &hbm,
        &[
            Pair(&[(0, Activate, 0)], Read, 0, 31, "rcd_read"),
            Pair(&[(0, Activate, 0)], Write, 0, 15, "rcd_write"),
            // 45 and 26 are one clock less than 72.
            Pair(&[(0, Activate, 0), (45, Precharge, 0)], Activate, 0, 72, "rc"),
            Pair(
                &[(0, Activate, 0), (5, Activate, 1), (60, Precharge, 0)],
                Precharge,
                1,
                62,
                "ppd",
            ),
            Pair(&[(0, RefreshBank, 0)], RefreshBank, 1, 13, "pbr2pbr"),
            Pair(&[(0, RefreshBank, 0)], Activate, 1, 13, "pbr2act"),
            Pair(&[(0, RefreshBank, 0)], Activate, 0, 320, "rfc_bank"),
            Pair(&[(0, Activate, 1)], RefreshBank, 0, 5, "rrd_l"),
            Pair(&[(0, Activate, 4)], RefreshBank, 0, 4, "rrd_s"),
            Pair(&[(0, Activate, 0), (60, Precharge, 0)], RefreshBank, 0, 86, "rp"),
        ],
    );
    // With reads far behind writes, the data bus binds between ranks, but not within one.
    let text = text.replace("cwl = 10", "cwl = 30").replace("rtw = 20", "rtw = 3");
    let late = Config { ranks: 2, ..Config::new(Part::parse("late", &text).unwrap()) };
    // Write data from 70 to 72, and 1 of rest; a read's data begin 20 after it.
    hold(
        &late,
        &[Pair(
            &[(0, Activate, 0), (1, Activate, 16), (40, Write, 0)],
            Read,
            16,
            53,
            "rank_switch",
        )],
    );
}

/// What state forbids, whatever the clock.
#[test]
fn states() {
    let config = Config::new(Part::named("ddr4-3200").unwrap());
    for (before, (command, bank, row), rule) in [
        (&[][..], (Read, 0, 1), "burst of a row that is not open"),
        (&[(Activate, 0)][..], (Write, 0, 2), "burst of a row that is not open"),
        (&[(Activate, 0), (Precharge, 0)][..], (Read, 0, 1), "burst of a row that is not open"),
        (&[(Activate, 0), (PrechargeAll, 0)][..], (Read, 0, 1), "burst of a row that is not open"),
        (&[(Activate, 0)][..], (Activate, 0, 2), "activate of an open bank"),
        (&[(Activate, 5)][..], (Refresh, 0, 0), "refresh of an open bank"),
        (&[(Activate, 0)][..], (RefreshBank, 0, 0), "refresh of an open bank"),
        (&[][..], (RefreshBank, 1, 0), "refresh out of turn"),
    ] {
        let mut checker = Checker::new(&config);
        for (n, &(command, bank)) in before.iter().enumerate() {
            let clock = 1000 * n as u64;
            assert_eq!(checker.command(Issued { clock, command, channel: 0, bank, row: 1 }), []);
        }
        let broken = checker.command(Issued { clock: 9000, command, channel: 0, bank, row });
        let rules: Vec<&str> = broken.iter().map(|breach| breach.rule).collect();
        assert_eq!(rules, [rule], "{before:?}, then {command:?}");
    }
    let mut checker = Checker::new(&config);
    let at = |bank| Issued { clock: 0, command: Activate, channel: 0, bank, row: 1 };
    checker.command(at(0));
    let rules: Vec<&str> = checker.command(at(4)).iter().map(|breach| breach.rule).collect();
    assert_eq!(rules, ["rrd_s", "command bus"]);
    assert!(checker.refreshed(3 * 12480).is_err());
}
