//! What cannot be put together is refused; what can be, at the ends of every range, runs.

use pellucid_dram::{Config, Dram, Part, Refresh, Request};

#[test]
fn messages() {
    let config = || Config::new(Part::named("ddr4-3200").unwrap());
    for (config, expected) in [
        (
            Config { channels: 3, ..config() },
            "`channels` is 3: expected a power of two from 1 to 64",
        ),
        (
            Config { channels: 0, ..config() },
            "`channels` is 0: expected a power of two from 1 to 64",
        ),
        (Config { ranks: 0, ..config() }, "`ranks` is 0: expected a power of two from 1 to 128"),
        (
            Config { ranks: 16, ..config() },
            "a data bus of `ddr4-3200` with 16 ranks has 256 banks: expected at most 128",
        ),
        (
            Config { machine_period_ps: 0, ..config() },
            "`machine_period_ps` is 0: expected a number of ps from 1 to 1000000",
        ),
        (
            Config { refresh: Refresh::PerBank, ..config() },
            "`ddr4-3200` has no `rfc_bank`, `pbr2pbr` and `pbr2act`: expected `all-bank` refresh",
        ),
    ] {
        assert_eq!(
            Dram::new(config).err().map(|error| error.to_string()).as_deref(),
            Some(expected)
        );
    }
}

/// The smallest device and the largest one, with a slow and a fast machine; a request too many is left out.
#[test]
fn ends_of_the_ranges() {
    let text = Part::file("hbm3-6400").unwrap();
    let with = |pairs: &[(&str, &str)]| {
        let edited = pairs.iter().fold(text.to_string(), |text, (old, new)| {
            assert!(text.contains(old), "{old}");
            text.replacen(old, new, 1)
        });
        Part::parse("edited", &edited).unwrap()
    };
    let small = with(&[
        ("bus_bits = 32", "bus_bits = 8"),
        ("burst_length = 8", "burst_length = 1"),
        ("pseudo_channels = 2", "pseudo_channels = 1"),
        ("bank_groups = 4", "bank_groups = 1"),
        ("banks = 4", "banks = 1"),
        ("rows = 16384", "rows = 1"),
        ("columns = 256", "columns = 1"),
    ]);
    let large = with(&[
        ("bus_bits = 32", "bus_bits = 4096"),
        ("burst_length = 8", "burst_length = 256"),
        ("pseudo_channels = 2", "pseudo_channels = 16"),
        ("bank_groups = 4", "bank_groups = 2"),
        ("banks = 4", "banks = 64"),
        ("rows = 16384", "rows = 16777216"),
        ("columns = 256", "columns = 1048576"),
    ]);
    for (part, channels) in [(small, 1), (large, 64)] {
        for machine_period_ps in [1, 625, 1_000_000] {
            let mut dram =
                Dram::new(Config { channels, machine_period_ps, ..Config::new(part.clone()) })
                    .unwrap();
            // All to one bank, and none answered yet: reads fill its queue.
            let mut taken = 0;
            while dram.ready() {
                assert!(dram.push(Request {
                    write: false,
                    address: u64::MAX,
                    tag: taken,
                    client: 255
                }));
                taken += 1;
            }
            assert_eq!(taken, 32);
            assert!(!dram.push(Request {
                write: false,
                address: u64::MAX,
                tag: taken,
                client: 255
            }));
            let mut tags = vec![];
            while !dram.idle() {
                dram.cycle();
                tags.extend(dram.pop());
            }
            assert_eq!(tags, (0..32).collect::<Vec<u32>>());
            assert_eq!(dram.statistics().reads, 32);
        }
    }
}

/// A write joins a queued one; a read of a queued write is there in the next clock; a machine's clock has its own period.
#[test]
fn queued_writes() {
    let part = Part::named("ddr4-3200").unwrap();
    let mut dram = Dram::new(Config { machine_period_ps: 1000, ..Config::new(part) }).unwrap();
    let request = |write, address, tag| Request { write, address, tag, client: 3 };
    // A read that opens another row of the bank keeps the writes in their queue.
    dram.push(request(false, 0, 1));
    dram.push(request(true, 1 << 30, 0));
    dram.push(request(true, (1 << 30) + 8, 0));
    dram.push(request(false, (1 << 30) + 63, 2));
    assert_eq!(dram.pop(), None);
    dram.cycle();
    assert_eq!((dram.pop(), dram.pop()), (Some(2), None));
    let s = dram.statistics();
    assert_eq!((s.clocks, s.reads_forwarded, s.writes_coalesced, s.bytes_written), (1, 1, 1, 0));
    // 48 clocks of 625 ps: 30 cycles of 1 ns.
    (1..29).for_each(|_| dram.cycle());
    assert_eq!((dram.pop(), dram.statistics().clocks), (None, 46));
    dram.cycle();
    assert_eq!((dram.pop(), dram.statistics().clocks), (Some(1), 48));
    while !dram.idle() {
        dram.cycle();
    }
    let s = dram.statistics();
    assert_eq!((s.bytes_read, s.bytes_written), (64, 64));
    assert_eq!((s.row_misses, s.row_conflicts, s.activates, s.precharges), (1, 1, 2, 1));
    assert_eq!((s.clients[3].reads, s.clients[3].writes), (2, 2));
    assert_eq!((s.read_latency_clocks, s.clients[3].read_latency_clocks), (49, 49));
}
