use super::board::{BoardError, behind, settings, split};
use super::timing::DramTiming;
use crate::progress::Progress;
use crate::scene::{Options, Scene};
use crate::source::Source;
use crate::trial::Case;
use pellucid_dram::{Config, Dram, Part};
use pellucid_machine::Model;
use pellucid_machine::architecture::Setting;
use pellucid_machine::board::{Asked, Timing};
use pellucid_tbuffer::architecture::ARCHITECTURE;

fn scene() -> Source {
    let options = Options { width: Some(32), height: Some(24), ..Options::default() };
    Source::Scene(Scene::open("glass", &options).unwrap())
}

fn given(list: &[(&str, &str)]) -> Vec<Setting> {
    let setting = |(name, value): &(&str, &str)| Setting {
        name: name.to_string(),
        value: value.to_string(),
        origin: format!("-p {name}={value}"),
    };
    list.iter().map(setting).collect()
}

/// A T-buffer with little room on chip, and what the settings put behind its port.
fn machine(list: &[(&str, &str)]) -> Result<Box<dyn Model>, BoardError> {
    let all = [&[("sections", "20"), ("outside_sections", "4000")][..], list].concat();
    let (board, parameters) = split(&given(&all), &(ARCHITECTURE.parameters)());
    behind(ARCHITECTURE.build(scene().screen(), None, &parameters).unwrap(), &board)
}

fn refused(list: &[(&str, &str)]) -> String {
    machine(list).err().expect("it is refused").to_string()
}

#[test]
fn every_part_gives_the_image_and_its_figures_add_up() {
    for part in Part::NAMES {
        let model = machine(&[("outside", part), ("dram_channels", "2")]).unwrap();
        let mut progress = Progress::new("", None, true);
        let case = Case::new("glass", scene(), &*model, &mut progress).unwrap();
        let trial = case.run("tbuffer", &*model, None, &mut progress).unwrap();
        assert!(trial.verdict.passes(false), "{part}: {:?}", trial.verdict.faults());
        let tally = trial.report.tally();
        let figure = |name: &str| {
            let of = tally.outside.iter().find(|figure| figure.name == name);
            of.unwrap_or_else(|| panic!("no figure `{name}`")).value
        };
        let memory = tally.memory("chains.sections.outside").unwrap().info;
        assert!(memory.reads > 100 && memory.writes > 100, "{memory:?}");
        // A fragment of 56 bits lies in 8 bytes.
        assert_eq!(figure("bytes_asked"), 8 * (memory.reads + memory.writes), "{part}");
        let bursts = ["row_hits", "row_misses", "row_conflicts"].map(figure).iter().sum::<u64>();
        let organisation = Part::named(part).unwrap().organisation;
        assert_eq!(figure("bytes_moved"), bursts * organisation.burst_bytes(), "{part}");
        // What is still in the queue at the end was not moved.
        let gathered = ["reads_gathered", "reads_forwarded", "writes_coalesced"].map(figure);
        let asked = memory.reads + memory.writes - gathered.iter().sum::<u64>();
        assert!(bursts <= asked && asked <= bursts + 64 * 4, "{part}: {bursts} of {asked}");
        assert!(figure("busy_bus_clocks") < figure("bus_clocks"), "{part}");
    }
}

fn timing() -> DramTiming {
    DramTiming::new(Dram::new(Config::new(Part::named("ddr4-3200").unwrap())).unwrap(), 56)
}

/// Asks for what `ask` says, a request in each cycle in which one is taken; gives the cycles in which reads are answered.
fn answered(timing: &mut DramTiming, ask: &[(bool, u32)]) -> Vec<u64> {
    let mut ask = ask.iter();
    let reads = ask.clone().filter(|(write, _)| !write).count();
    let mut seen = vec![];
    for cycle in 0.. {
        assert!(cycle < 100_000, "reads are not answered: {seen:?}");
        if seen.len() == reads && ask.len() == 0 {
            break;
        }
        let answers = timing.answers();
        seen.extend(answers.then_some(cycle));
        let next = if timing.ready() { ask.next() } else { None };
        timing.cycle(next.map(|&(write, address)| Asked { write, address }), answers);
    }
    seen
}

fn figure(timing: &DramTiming, name: &str) -> u64 {
    timing.figures().into_iter().find(|figure| figure.name == name).unwrap().value
}

#[test]
fn words_of_one_burst_move_it_once() {
    // Eight words of 8 bytes in a burst of 64.
    let mut timing = timing();
    let seen = answered(&mut timing, &(0..16).map(|k| (false, k)).collect::<Vec<_>>());
    assert_eq!(figure(&timing, "bytes_moved"), 2 * 64);
    assert_eq!(figure(&timing, "reads_gathered"), 14);
    assert_eq!(figure(&timing, "bytes_asked"), 16 * 8);
    // Once the first burst is there its words follow one a cycle.
    assert_eq!(seen[..8], (seen[0]..seen[0] + 8).collect::<Vec<_>>());
    // The first answer, in device clocks as the machine's: rcd, cl and a burst, after the cycle in which it was asked.
    assert_eq!(seen[0], 1 + 22 + 22 + 4);
}

#[test]
fn a_write_to_the_burst_that_was_read_ends_the_gathering() {
    let mut timing = timing();
    answered(&mut timing, &[(false, 0), (true, 100), (false, 1), (true, 2), (false, 3)]);
    assert_eq!(figure(&timing, "reads_gathered"), 1);
}

#[test]
fn a_reset_forgets_reads_and_counting_anew_forgets_figures() {
    let mut timing = timing();
    for address in 0..5 {
        timing.cycle(Some(Asked { write: false, address: address * 1000 }), false);
    }
    timing.reset();
    assert!(!timing.answers());
    timing.count_anew();
    assert!(timing.figures().iter().all(|figure| figure.value == 0), "{:?}", timing.figures());
    assert_eq!(answered(&mut timing, &[(false, 7)]).len(), 1);
    assert_eq!(figure(&timing, "bytes_asked"), 8);
}

#[test]
fn without_a_part_nothing_is_added() {
    for list in [&[][..], &[("outside", "fixed")]] {
        let values = machine(list).unwrap().values();
        assert!(values.iter().all(|(name, _)| name != "outside"));
    }
    let values = machine(&[("outside", "hbm3-6400"), ("clock_mhz", "750")]).unwrap().values();
    let value = |name: &str| values.iter().find(|(n, _)| n == name).unwrap().1.to_string();
    assert_eq!([value("outside"), value("clock_mhz")], ["hbm3-6400", "750"]);
    // Each is one of those that are listed.
    assert!(settings().iter().all(|param| values.iter().any(|(name, _)| *name == param.name)));
}

#[test]
fn what_a_file_says_of_a_dram_goes_where_fixed_is_said_over_it() {
    let list = [("outside", "ddr4-3200"), ("dram_page", "closed"), ("outside", "fixed")];
    assert!(machine(&list).unwrap().values().iter().all(|(name, _)| name != "outside"));
    let after = [&list[..], &[("dram_refresh", "per-bank")]].concat();
    assert_eq!(
        refused(&after),
        "-p dram_refresh=per-bank: `dram_refresh` needs a DRAM: expected `outside=` and a part"
    );
}

#[test]
fn a_clock_without_a_dram_is_the_machines() {
    let values = machine(&[("clock_mhz", "750")]).unwrap().values();
    assert_eq!(values.last().unwrap().1.to_string(), "750");
    assert!(values.iter().all(|(name, _)| name != "outside"));
    assert!(machine(&[("clock_mhz", "750")]).unwrap().latency().is_some());
    let fixed = [("outside", "ddr4-3200"), ("clock_mhz", "600"), ("outside", "fixed")];
    assert_eq!(machine(&fixed).unwrap().values().last().unwrap().1.to_string(), "600");
    assert_eq!(
        refused(&[("clock_mhz", "0")]),
        "-p clock_mhz=0: parameter `clock_mhz` is 0: expected a whole number from 1 to 100000"
    );
}

/// What the counted commands take, by the figures of the part's file.
#[test]
fn the_energy_of_a_dram_is_that_of_its_commands() {
    let mut timing = timing();
    answered(&mut timing, &(0..16).map(|k| (false, k)).collect::<Vec<_>>());
    let energy = |name: &str| figure(&timing, name);
    // Two bursts in two bank groups, a row of each, and no refresh yet.
    assert_eq!(energy("activates"), 2 * 4200);
    assert_eq!(energy("reads"), 2 * 2784);
    assert_eq!([energy("writes"), energy("refreshes")], [0, 0]);
    // The board's clock is the device's, 625 ps.
    assert_eq!(energy("background"), 499 * figure(&timing, "bus_clocks") * 625 / 1000);
    timing.count_anew();
    assert_eq!([figure(&timing, "activates"), figure(&timing, "background")], [0, 0]);
}

#[test]
fn what_is_wrong_is_named() {
    assert_eq!(
        refused(&[("outsid", "ddr4-3200")]),
        "-p outsid=ddr4-3200: unknown parameter `outsid` (did you mean `outside`?); known are `outside`, \
         `dram_channels`, `dram_ranks`, `dram_mapping`, `dram_scheduler`, `dram_page`, `dram_refresh`, `dram_energy`, `clock_mhz`"
    );
    assert_eq!(
        refused(&[("outside", "ddr4-3200"), ("dram_ranks", "16")]),
        "-p dram_ranks=16: a data bus of `ddr4-3200` with 16 ranks has 256 banks: expected at most 128"
    );
    assert_eq!(
        refused(&[("outside", "ddr5")]),
        "-p outside=ddr5: unknown memory `ddr5` (did you mean `lpddr5-6400`?); known are `fixed`, `ddr4-3200`, \
         `lpddr5-6400`, `gddr6-14000`, `hbm3-6400`, and the files of parts (.toml)"
    );
    assert_eq!(
        refused(&[("dram_ranks", "2")]),
        "-p dram_ranks=2: `dram_ranks` needs a DRAM: expected `outside=` and a part"
    );
    assert_eq!(
        refused(&[("outside", "ddr4-3200"), ("dram_chanels", "2")]),
        "-p dram_chanels=2: unknown parameter `dram_chanels` (did you mean `dram_channels`?); known are `outside`, \
         `dram_channels`, `dram_ranks`, `dram_mapping`, `dram_scheduler`, `dram_page`, `dram_refresh`, `dram_energy`, `clock_mhz`"
    );
    assert_eq!(
        refused(&[("outside", "ddr4-3200"), ("clock_mhz", "0")]),
        "-p clock_mhz=0: parameter `clock_mhz` is 0: expected a whole number from 1 to 100000"
    );
    assert_eq!(
        refused(&[("outside", "ddr4-3200"), ("dram_channels", "3")]),
        "-p dram_channels=3: parameter `dram_channels` is 3: expected a power of two from 1 to 64"
    );
    assert_eq!(
        refused(&[("outside", "ddr4-3200"), ("dram_page", "opn")]),
        "-p dram_page=opn: unknown page policy `opn` (did you mean `open`?); known are `open`, `closed`"
    );
    let none = refused(&[("outside", "ddr4-3200"), ("outside_sections", "0")]);
    assert!(none.starts_with("-p outside=ddr4-3200: the machine has no port"), "{none}");
}

#[test]
fn a_burst_holds_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("narrow.toml");
    let text = Part::file("ddr4-3200").unwrap();
    let line = |key| text.lines().find(|line| line.starts_with(key)).unwrap();
    let text = text.replacen(line("bus_bits"), "bus_bits = 8", 1).replacen(
        line("burst_length"),
        "burst_length = 4",
        1,
    );
    std::fs::write(&path, text).unwrap();
    let error = refused(&[("outside", path.to_str().unwrap())]);
    assert!(error.contains("is 4 bytes: expected at least 8, a word of the machine"), "{error}");
}

#[test]
fn a_part_must_have_room_for_the_machine() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tiny.toml");
    let text = Part::file("ddr4-3200").unwrap();
    let rows = text.lines().find(|line| line.starts_with("rows")).unwrap();
    std::fs::write(&path, text.replacen(rows, "rows = 1", 1)).unwrap();
    let path = path.to_str().unwrap();
    // A row of 8 KiB in each of 16 banks.
    let error = refused(&[("outside", path), ("outside_sections", "6000")]);
    let expected = "the machine needs 144000 bytes outside: expected at most 131072, as many as";
    assert!(error.contains(expected), "{error}");
    assert!(machine(&[("outside", path)]).is_ok());
}
