//! Rates and times that follow from a part's numbers alone, held to what the memory does.
//!
//! Formulas as in Ramulator's tests (`tests/latency_throughput/utils/spec.py`), with the burst as part of a latency. Latencies must
//! be exact; rates are of some thousand bursts, and may be 1 % below for their begin and end.

use crate::traffic::run;
use pellucid_dram::{CommandBuses, Config, Dram, Mapping, Part, Request, Scheduler};

/// The address of a burst, by the definition of `row-bank-column`; `lane` is the pseudo-channel.
fn address(config: &Config, lane: u64, group: u64, bank: u64, row: u64, column: u64) -> u64 {
    assert_eq!((config.mapping, config.channels, config.ranks), (Mapping::RowBankColumn, 1, 1));
    let o = &config.part.organisation;
    let burst = (row * u64::from(o.banks) + bank) * u64::from(o.bank_groups) + group;
    let burst = (burst * o.bursts() + column) * u64::from(o.pseudo_channels) + lane;
    burst * o.burst_bytes()
}

/// With refreshes so rare that none comes, or as they are; a machine that asks twice in a device clock.
fn config(name: &str, refreshed: bool) -> Config {
    let mut part = Part::named(name).unwrap();
    if !refreshed {
        part.timing.refi = 1_000_000;
    }
    let tck = part.timing.tck_ps;
    Config { mapping: Mapping::RowBankColumn, machine_period_ps: tck / 2, ..Config::new(part) }
}

/// Bytes for each device clock of reads in this order.
fn rate(config: &Config, addresses: impl Iterator<Item = u64>) -> f64 {
    let requests: Vec<(bool, u64)> = addresses.map(|address| (false, address)).collect();
    let statistics = run(Dram::new(config.clone()).unwrap(), &requests, 0).statistics;
    statistics.bytes_read as f64 / statistics.clocks as f64
}

fn hold(what: &str, part: &str, measured: f64, expected: f64) {
    let tck = Part::named(part).unwrap().timing.tck_ps as f64 / 1000.0;
    println!("{part}: {what} {:.2} GB/s, expected {:.2}", measured / tck, expected / tck);
    assert!(
        measured <= expected * 1.0001 && measured >= expected * 0.99,
        "{part}: {what} is {measured:.3} bytes a clock, expected {expected:.3}"
    );
}

#[test]
fn latency_of_an_idle_memory() {
    for part in Part::NAMES {
        let mut config = config(part, false);
        config.machine_period_ps = config.part.timing.tck_ps;
        let t = config.part.timing;
        let at = |row| (false, address(&config, 0, 0, 0, row, 0));
        // To a closed bank, to the open row, to another row of the bank; each long after the one before.
        let run = run(Dram::new(config.clone()).unwrap(), &[at(0), at(0), at(1)], 500);
        let open = t.cl + t.burst;
        assert_eq!(run.latencies, [t.rcd_read + open, open, t.rp + t.rcd_read + open], "{part}");
        println!("{part}: {:.2} ns", run.latencies[2] as f64 * t.tck_ps as f64 / 1000.0);
        let s = run.statistics;
        assert_eq!((s.row_misses, s.row_hits, s.row_conflicts), (1, 1, 1), "{part}");
    }
}

#[test]
fn streaming() {
    for part in Part::NAMES {
        let config = Config { mapping: Mapping::RowBankColumnGroup, ..config(part, false) };
        let o = config.part.organisation;
        let peak = (o.burst_bytes() * u64::from(o.pseudo_channels)) as f64
            / config.part.timing.burst as f64;
        let bursts = (0..20_000).map(|n| n * o.burst_bytes());
        hold("streaming", part, rate(&config, bursts), peak);
    }
}

/// Refreshes of all banks: from the last read before one to the first after it nothing moves.
#[test]
fn loss_by_refresh() {
    for part in Part::NAMES {
        let loss = |refreshed| {
            let config = Config { mapping: Mapping::RowBankColumnGroup, ..config(part, refreshed) };
            rate(&config, (0..200_000).map(|n| n * config.part.organisation.burst_bytes()))
        };
        let measured = 1.0 - loss(true) / loss(false);
        let t = Part::named(part).unwrap().timing;
        let expected = (t.rtp + t.rp + t.rfc + t.rcd_read) as f64 / t.refi as f64;
        println!("{part}: refresh {:.2} %, expected {:.2} %", 100.0 * measured, 100.0 * expected);
        assert!(
            (measured - expected).abs() < 0.005,
            "{part}: {measured:.4}, expected {expected:.4}"
        );
    }
}

#[test]
fn row_misses_of_one_bank() {
    for part in Part::NAMES {
        let config = config(part, false);
        let expected = config.part.organisation.burst_bytes() as f64 / config.part.timing.rc as f64;
        let rows = (0..5_000).map(|n| address(&config, 0, 0, 0, n, 0));
        hold("row misses of one bank", part, rate(&config, rows), expected);
    }
}

/// Each burst needs a row of its own, and no bank comes again before the others: four activates in `faw`, or one in `rrd_s`
/// where that is longer.
#[test]
fn activates() {
    for part in Part::NAMES {
        let mut config = config(part, false);
        // On one command bus some activates wait for a clock, as bursts go first.
        config.part.organisation.command_buses = CommandBuses::RowAndColumn;
        let (o, t) = (config.part.organisation, config.part.timing);
        let lanes = u64::from(o.pseudo_channels);
        let expected = (4 * o.burst_bytes() * lanes) as f64 / t.faw.max(4 * t.rrd_s) as f64;
        let rows = (0..10_000).map(|n| {
            let (lane, n) = (n % lanes, n / lanes);
            address(&config, lane, n % 4, n / 4 % 4, n / 16, 0)
        });
        hold("activates", part, rate(&config, rows), expected);
    }
}

#[test]
fn one_bank_group() {
    for part in Part::NAMES {
        let config = config(part, false);
        let o = config.part.organisation;
        let lanes = u64::from(o.pseudo_channels);
        let expected = (o.burst_bytes() * lanes) as f64 / config.part.timing.ccd_l as f64;
        // A row of each of the four banks in turn, so that the next one is opened in time.
        let bursts = (0..20_000).map(|n| {
            let (lane, n) = (n % lanes, n / lanes);
            address(&config, lane, 0, n / o.bursts() % 4, n / o.bursts() / 4, n % o.bursts())
        });
        hold("one bank group", part, rate(&config, bursts), expected);
    }
}

/// As many reads as a queue holds, each of another row of one bank: nothing else is asked. With refreshes as often as a part may have
/// them few go in each interval.
#[test]
fn no_request_waits_longer_than_is_said() {
    for part in Part::NAMES {
        for (seldom, scheduler) in
            [(true, Scheduler::FrFcfs), (false, Scheduler::FrFcfs), (false, Scheduler::Fcfs)]
        {
            let mut config = Config { scheduler, ..config(part, true) };
            let t = config.part.timing;
            if !seldom {
                config.part.timing.refi = t.rfc + t.rc + t.cwl + t.burst + t.wr + t.rp;
            }
            config.machine_period_ps = t.tck_ps;
            let mut dram = Dram::new(config.clone()).unwrap();
            for row in 0..32 {
                let address = address(&config, 0, 0, 0, row.into(), 0);
                assert!(dram.push(Request { write: false, address, tag: row, client: 0 }));
            }
            let mut waited = 0;
            while !dram.idle() {
                dram.cycle();
                while dram.pop().is_some() {}
                waited += 1;
            }
            let most = config.longest_wait();
            println!("{part}: {waited} of {most} clocks");
            assert!(waited <= most, "{part}: {waited} clocks, expected at most {most}");
            assert!(seldom || waited >= 8 * config.part.timing.refi, "{part}: {waited}");
        }
    }
}
