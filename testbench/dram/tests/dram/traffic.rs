//! Traffic of all kinds, through all parts and policies: the commands are legal, each read is answered once, refreshes come in
//! time, nobody waits for ever.

use crate::checker::check;
use pellucid_dram::{
    Config, Dram, Issued, Mapping, Page, Part, Refresh, Request, Scheduler, Statistics,
};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;

/// What a run came to.
pub struct Run {
    pub commands: Vec<Issued>,
    pub statistics: Statistics,
    /// From push to pop, machine cycles, of each read in order of its request.
    pub latencies: Vec<u64>,
    /// The same from the cycle in which it would have been pushed, had the memory been ready all the time.
    pub delays: Vec<u64>,
}

/// Sends requests, with `gap` cycles between them or as soon after that as the memory is ready, and waits for all answers.
pub fn run(mut dram: Dram, requests: &[(bool, u64)], gap: u64) -> Run {
    dram.record();
    let (mut commands, mut pushed) = (vec![], vec![]);
    let (mut latencies, mut delays) = (vec![], vec![]);
    let (mut cycle, mut next, mut left) = (0, 0, requests.len());
    let limit = 10_000_000;
    let mut waiting = requests.iter();
    while left > 0 || !dram.idle() {
        if left > 0 && cycle >= next && dram.ready() {
            let &(write, address) = waiting.next().unwrap();
            let tag = pushed.len() as u32;
            dram.push(Request { write, address, tag, client: u8::from(write) });
            pushed.push((write, cycle, next));
            latencies.push(None);
            delays.push(None);
            left -= 1;
            next += 1 + gap;
        }
        dram.cycle();
        cycle += 1;
        if let Some(tag) = dram.pop() {
            let (write, begin, planned) = pushed[tag as usize];
            assert!(!write, "an answer to a write");
            let before = latencies[tag as usize].replace(cycle - begin);
            assert_eq!(before, None, "two answers to read {tag}");
            delays[tag as usize] = Some(cycle - planned);
        }
        commands.append(&mut dram.commands());
        assert!(cycle < limit, "not done after {limit} cycles");
    }
    assert_eq!(dram.pop(), None);
    let reads = pushed.iter().filter(|(write, ..)| !write).count();
    let latencies: Vec<u64> = latencies.into_iter().flatten().collect();
    assert_eq!(latencies.len(), reads, "answers");
    let delays = delays.into_iter().flatten().collect();
    Run { commands, statistics: dram.statistics(), latencies, delays }
}

#[derive(Clone, Copy, Debug)]
pub enum Kind {
    Random,
    Streaming,
    Fragments,
}

/// Requests of a kind, of which `writes` in 256 are writes, but for fragments, which are written and then read.
pub fn requests(kind: Kind, count: usize, writes: u32, bytes: u64, seed: u64) -> Vec<(bool, u64)> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    match kind {
        Kind::Random => {
            (0..count).map(|_| (rng.random_range(0..256) < writes, rng.random())).collect()
        }
        Kind::Streaming => {
            let start: u64 = rng.random_range(0..1 << 20);
            let write = |rng: &mut ChaCha8Rng| rng.random_range(0..256) < writes;
            (0..count as u64).map(|n| (write(&mut rng), (start + n) * bytes)).collect()
        }
        Kind::Fragments => fragments(count, &mut rng),
    }
}

/// Fragments of 8 bytes of a screen of 320x240, a span of a triangle after the other: each pixel's go to sections of four, which
/// are taken as they are needed. Then pixel by pixel all are read.
fn fragments(count: usize, rng: &mut ChaCha8Rng) -> Vec<(bool, u64)> {
    let mut pixels: HashMap<u64, Vec<u64>> = HashMap::new();
    let (mut requests, mut sections) = (vec![], 0);
    while requests.len() < count / 2 {
        let (y, x, length) =
            (rng.random_range(0..240), rng.random_range(0..300), rng.random_range(1..20));
        for x in x..x + length {
            let held = pixels.entry(y * 320 + x).or_default();
            if held.len().is_multiple_of(4) {
                held.push(sections * 32);
                sections += 1;
            } else {
                held.push(held[held.len() - 1] + 8);
            }
            requests.push((true, held[held.len() - 1]));
        }
    }
    let mut order: Vec<u64> = pixels.keys().copied().collect();
    order.sort_unstable();
    requests.extend(order.iter().flat_map(|pixel| &pixels[pixel]).map(|&address| (false, address)));
    requests
}

fn configs() -> impl Strategy<Value = Config> {
    let parts = prop::sample::select(&Part::NAMES[..]);
    let mappings = prop::sample::select(Mapping::ALL);
    let schedulers = prop::sample::select(Scheduler::ALL);
    let pages = prop::sample::select(Page::ALL);
    let refreshes = prop::sample::select(Refresh::ALL);
    let sizes = (prop::sample::select(&[1u32, 2, 4][..]), prop::sample::select(&[1u32, 2][..]));
    (parts, mappings, schedulers, pages, refreshes, sizes, 200u64..3000).prop_map(
        |(part, mapping, scheduler, page, refresh, (channels, ranks), machine_period_ps)| {
            let part = Part::named(part).unwrap();
            let refresh =
                if part.timing.bank_refresh.is_some() { refresh } else { Refresh::AllBank };
            Config { part, channels, ranks, mapping, scheduler, page, refresh, machine_period_ps }
        },
    )
}

fn hold(config: &Config, requests: &[(bool, u64)], gap: u64) -> Result<(), TestCaseError> {
    let run = run(Dram::new(config.clone()).unwrap(), requests, gap);
    let s = &run.statistics;
    let (breaches, refreshed) = check(config, &run.commands, s.clocks);
    prop_assert_eq!(breaches.first(), None);
    prop_assert_eq!(refreshed, Ok(()));
    // Every request moved a burst, or joined one.
    let bytes = config.part.organisation.burst_bytes();
    let reads = requests.iter().filter(|(write, _)| !write).count() as u64;
    let writes = requests.len() as u64 - reads;
    prop_assert_eq!((s.reads, s.writes), (reads, writes));
    prop_assert_eq!(s.bytes_read, (reads - s.reads_forwarded) * bytes);
    prop_assert_eq!(s.bytes_written, (writes - s.writes_coalesced) * bytes);
    let bursts = (s.bytes_read + s.bytes_written) / bytes;
    prop_assert_eq!(s.row_hits + s.row_misses + s.row_conflicts, bursts);
    prop_assert_eq!(s.busy_bus_clocks, bursts * config.part.timing.burst);
    prop_assert!(s.activates >= s.row_misses + s.row_conflicts);
    let clients: Vec<(u64, u64)> = s.clients.iter().map(|c| (c.reads, c.writes)).collect();
    let expected = [(reads, 0), (0, writes)];
    prop_assert_eq!(&clients[..], &expected[..if writes > 0 { 2 } else { 1 }]);
    // Whoever has waited for an interval between refreshes goes first, one after the other of 64.
    let (t, tck) = (&config.part.timing, config.part.timing.tck_ps);
    let bound = 2 * t.refi + 64 * (t.rc + t.rfc);
    let longest = run.latencies.iter().max().copied().unwrap_or(0);
    prop_assert!(
        longest * config.machine_period_ps / tck <= bound,
        "a read waited {} cycles",
        longest
    );
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn legal(
        config in configs(),
        kind in prop::sample::select(&[Kind::Random, Kind::Streaming, Kind::Fragments][..]),
        writes in prop::sample::select(&[0u32, 16, 85, 128, 255][..]),
        gap in prop::sample::select(&[0u64, 1, 7, 60][..]),
        seed in any::<u64>(),
    ) {
        let bytes = config.part.organisation.burst_bytes();
        hold(&config, &requests(kind, 3000, writes, bytes, seed), gap)?;
    }

    /// What does not bind in a part that is shipped may bind in another.
    #[test]
    fn any_device(
        config in configs(),
        kind in prop::sample::select(&[Kind::Random, Kind::Streaming, Kind::Fragments][..]),
        writes in prop::sample::select(&[0u32, 85, 128][..]),
        gap in prop::sample::select(&[0u64, 1, 7, 60][..]),
        seed in any::<u64>(),
    ) {
        let part = any_part(&mut ChaCha8Rng::seed_from_u64(seed));
        let config = Config { part, ..config };
        hold(&config, &requests(kind, 1500, writes, 32, seed), gap)?;
    }

    /// Few rows of few banks, so that hits, conflicts, coalesced writes and forwarded reads are common.
    #[test]
    fn crowded(config in configs(), writes in 0u32..256, gap in 0u64..40, seed in any::<u64>()) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let layout = *Dram::new(config.clone()).unwrap().layout();
        let pool: Vec<u64> = (0..24).map(|_| rng.random::<u64>() % layout.capacity() as u64).collect();
        let requests: Vec<(bool, u64)> = (0..3000)
            .map(|_| {
                let near = rng.random_range(0..4) * config.part.organisation.burst_bytes();
                (rng.random_range(0..256) < writes, pool[rng.random_range(0..24)] ^ near)
            })
            .collect();
        hold(&config, &requests, gap)?;
    }
}

/// A part with numbers of its own, as a file.
fn any_part(rng: &mut ChaCha8Rng) -> Part {
    let mut text = "name = \"any\"\n[organisation]\nbus_bits = 16\nburst_length = 16\nrows = 64\ncolumns = 256\n".to_string();
    for (key, most) in [("pseudo_channels", 2), ("bank_groups", 3), ("banks", 3)] {
        text += &format!("{key} = {}\n", 1 << rng.random_range(0..most));
    }
    let buses = if rng.random() { "one" } else { "row-and-column" };
    text += &format!("command_buses = \"{buses}\"\n[timing]\ntck_ps = 1000\n");
    let mut upto = |most: u64| rng.random_range(1..=most);
    let (burst, cl, cwl, rp, wr) = (upto(4), upto(20), upto(20), upto(20), upto(20));
    let (rcd_read, rcd_write, rtp, ppd) = (upto(20), upto(20), upto(20), upto(6));
    let (ccd_s, rrd_s, wtr_s) = (burst + upto(3) - 1, upto(8), upto(8));
    let (ccd_l, rrd_l, wtr_l) = (ccd_s + upto(4) - 1, rrd_s + upto(4) - 1, wtr_s + upto(8) - 1);
    let (faw, ras) = (rrd_s + upto(40), rcd_read + upto(20));
    let (rc, rtw) = (ras + rp + upto(8) - 1, (cl + burst).saturating_sub(cwl) + upto(4));
    let (rfc_bank, rank_switch) = (20 + upto(60), upto(3));
    let (pbr2pbr, pbr2act, rfc) = (upto(40), upto(20), rfc_bank + upto(80));
    let refi =
        16 * (pbr2pbr + faw + pbr2act + rrd_l) + rfc + rc + cwl + burst + wr + rp + upto(900);
    for (key, clocks) in [
        ("burst", burst),
        ("cl", cl),
        ("cwl", cwl),
        ("rcd_read", rcd_read),
        ("rcd_write", rcd_write),
        ("rp", rp),
        ("ras", ras),
        ("rc", rc),
        ("rtp", rtp),
        ("wr", wr),
        ("ccd_s", ccd_s),
        ("ccd_l", ccd_l),
        ("rrd_s", rrd_s),
        ("rrd_l", rrd_l),
        ("faw", faw),
        ("wtr_s", wtr_s),
        ("wtr_l", wtr_l),
        ("rtw", rtw),
        ("rank_switch", rank_switch),
        ("ppd", ppd),
        ("refi", refi),
        ("rfc", rfc),
        ("rfc_bank", rfc_bank),
        ("pbr2pbr", pbr2pbr),
        ("pbr2act", pbr2act),
    ] {
        text += &format!("{key} = {clocks}\n");
    }
    Part::parse("any", &text).unwrap()
}

/// A read of another row, or any read, against what would keep it waiting for ever: row hits, or writes that never end.
#[test]
fn nothing_starves() {
    for part in Part::NAMES {
        for (flood_writes, row) in [(false, 5), (true, 0)] {
            let mut config = Config::new(Part::named(part).unwrap());
            config.mapping = Mapping::BankRowColumn;
            let o = config.part.organisation;
            let lanes = u64::from(o.pseudo_channels);
            let (row_bytes, refi) = (o.bursts() * o.burst_bytes() * lanes, config.part.timing.refi);
            let mut dram = Dram::new(config).unwrap();
            let (mut n, mut answered) = (0, None);
            for cycle in 0..3 * refi {
                if dram.ready() {
                    let victim = cycle >= 500 && n < 1 << 20;
                    n = if victim { 1 << 20 } else { n + 1 };
                    dram.push(match victim {
                        true => {
                            Request { write: false, address: row * row_bytes, tag: 1, client: 1 }
                        }
                        // Every burst of row 0 again and again; no write to the victim's.
                        false => Request {
                            write: flood_writes,
                            address: (lanes + n * lanes % (row_bytes / o.burst_bytes() - lanes))
                                * o.burst_bytes(),
                            tag: 0,
                            client: 0,
                        },
                    });
                }
                dram.cycle();
                if dram.pop() == Some(1) {
                    answered = Some(cycle - 500);
                }
            }
            let answered = answered.unwrap_or(u64::MAX);
            assert!(answered < 3 * refi / 2, "{part}: the read waited {answered} clocks");
        }
    }
}
