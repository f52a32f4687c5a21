//! What the policies do, by hand: who goes first, when a row is closed, when writes are drained.

use pellucid_dram::{Command, Config, Dram, Mapping, Page, Part, Request, Scheduler};

/// DDR4 with 8 KiB rows; the first 8 KiB of each 128 KiB are in bank 0.
fn dram(scheduler: Scheduler, page: Page) -> Dram {
    let part = Part::named("ddr4-3200").unwrap();
    let mapping = Mapping::RowBankColumn;
    let mut dram = Dram::new(Config { scheduler, page, mapping, ..Config::new(part) }).unwrap();
    dram.record();
    dram
}

fn address(row: u64, column: u64) -> u64 {
    (row << 17) + (column << 6)
}

fn push(dram: &mut Dram, write: bool, address: u64, tag: u32) {
    assert!(dram.push(Request { write, address, tag, client: 0 }));
}

/// The tags in order of completion.
fn finish(dram: &mut Dram) -> Vec<u32> {
    let mut tags = vec![];
    while !dram.idle() {
        dram.cycle();
        tags.extend(dram.pop());
    }
    tags
}

fn names(commands: Vec<pellucid_dram::Issued>) -> String {
    let name = |command| match command {
        Command::Activate => 'A',
        Command::Precharge => 'P',
        Command::Read => 'R',
        Command::Write => 'W',
        Command::PrechargeAll | Command::Refresh | Command::RefreshBank => 'F',
    };
    commands.into_iter().map(|issued| name(issued.command)).collect()
}

#[test]
fn who_goes_first() {
    for (scheduler, order, commands) in [
        // The row that requests 2 and 3 need is not closed for request 1.
        (Scheduler::FrFcfs, [0, 2, 3, 1], "ARRRPAR"),
        (Scheduler::Fcfs, [0, 1, 2, 3], "ARPARPARR"),
    ] {
        let mut dram = dram(scheduler, Page::Open);
        for (tag, (row, column)) in [(0, 0), (1, 0), (0, 1), (0, 2)].into_iter().enumerate() {
            push(&mut dram, false, address(row, column), tag as u32);
        }
        assert_eq!(finish(&mut dram), order, "{scheduler}");
        assert_eq!(names(dram.commands()), commands, "{scheduler}");
    }
}

#[test]
fn when_a_row_is_closed() {
    for (page, commands) in [(Page::Open, "ARRRRRR"), (Page::Closed, "ARRRRPARRP")] {
        let mut dram = dram(Scheduler::FrFcfs, page);
        (0..6).for_each(|column| push(&mut dram, false, address(0, column), column as u32));
        assert_eq!(finish(&mut dram), [0, 1, 2, 3, 4, 5]);
        // A row that nobody needs is closed `ras` after it was opened.
        (0..100).for_each(|_| dram.cycle());
        assert_eq!(names(dram.commands()), commands, "{page}");
    }
}

/// Reads that take long come first, up to 26 writes; then writes alone until six are left, and reads again.
#[test]
fn when_writes_are_drained() {
    let mut dram = dram(Scheduler::FrFcfs, Page::Open);
    (0..20).for_each(|row| push(&mut dram, false, address(row, 0), row as u32));
    (0..25).for_each(|column| push(&mut dram, true, address(100, column), 0));
    (0..200).for_each(|_| dram.cycle());
    assert_eq!((dram.statistics().drains, dram.statistics().bytes_written), (0, 0));
    push(&mut dram, true, address(100, 25), 0);
    finish(&mut dram);
    assert_eq!(dram.statistics().drains, 1);
    let names = names(dram.commands());
    let reads: usize = 20 - names.split_once('W').unwrap().0.matches('R').count();
    let expected = ["W".repeat(20), "PAR".repeat(reads), "PAWWWWWW".to_string()].concat();
    assert!(names.ends_with(&expected), "{names}");
}

/// A row that was opened for a read is not closed for a write before the read has had it, though writes are served by then.
#[test]
fn a_row_is_not_opened_in_vain() {
    let mut dram = dram(Scheduler::FrFcfs, Page::Open);
    push(&mut dram, false, address(0, 0), 0);
    dram.cycle();
    (0..26).for_each(|column| push(&mut dram, true, address(1, column), 0));
    finish(&mut dram);
    assert_eq!(names(dram.commands()), format!("ARPA{}", "W".repeat(26)));
    let s = dram.statistics();
    assert_eq!((s.drains, s.row_misses, s.row_conflicts, s.row_hits), (1, 1, 1, 25));
}
