//! A rule of the scheduler's table that is one clock too short is told by the checker, each in turn.

use crate::checker::{Breach, check};
use crate::traffic::{Kind, requests, run};
use pellucid_dram::Command::{PrechargeAll, Refresh};
use pellucid_dram::Refresh::{AllBank, PerBank};
use pellucid_dram::{Config, Constraint, Dram, Mapping, Page, Part, constraints};

/// A part on which every rule binds: none follows from others. Refreshes are frequent.
const PART: &str = r#"
name = "all-bind"
[organisation]
bus_bits = 64
burst_length = 8
pseudo_channels = 1
bank_groups = 4
banks = 2
rows = 16
columns = 64
command_buses = "one"
[timing]
tck_ps = 1000
burst = 4
cl = 11
cwl = 9
rcd_read = 10
rcd_write = 8
rp = 9
ras = 26
rc = 41
rtp = 8
wr = 12
ccd_s = 5
ccd_l = 7
rrd_s = 5
rrd_l = 7
faw = 26
wtr_s = 4
wtr_l = 8
rtw = 14
rank_switch = 2
ppd = 4
refi = 480
rfc = 60
rfc_bank = 45
pbr2pbr = 53
pbr2act = 11
"#;

fn traffic(config: &Config, table: &[Constraint]) -> Vec<Breach> {
    let mut breaches = vec![];
    for (writes, gap, mapping, page) in [
        (85, 0, Mapping::RowBankColumnGroup, Page::Open),
        (128, 0, Mapping::RowBankColumn, Page::Open),
        (85, 3, Mapping::RowColumnBank, Page::Closed),
        (85, 30, Mapping::BankRowColumn, Page::Closed),
        (128, 100, Mapping::RowBankColumnGroup, Page::Closed),
    ] {
        for kind in [Kind::Random, Kind::Streaming] {
            let config = Config { mapping, page, ..config.clone() };
            let requests = requests(kind, 2000, writes, 64, 3);
            let dram = Dram::with_constraints(config.clone(), table).unwrap();
            let run = run(dram, &requests, gap);
            breaches.extend(check(&config, &run.commands, run.statistics.clocks).0);
        }
    }
    breaches
}

#[test]
fn each_is_told() {
    let part = Part::parse("all-bind", PART).unwrap();
    for &refresh in pellucid_dram::Refresh::ALL {
        let config = Config { ranks: 2, refresh, ..Config::new(part.clone()) };
        let table = constraints(&config);
        assert_eq!(traffic(&config, &table), []);
        let mut missed = vec![];
        for index in 0..table.len() {
            let mut faulty = table.clone();
            faulty[index].clocks -= 1;
            let name = table[index].name;
            // A rank's rows are closed at once only before its refresh, from which an activate must wait for longer. Where
            // single banks are refreshed there are no commands to a rank. The pairs hold these rules.
            let rank =
                |commands: &[_]| commands.iter().all(|c| matches!(c, PrechargeAll | Refresh));
            let (from, to) = (rank(table[index].from), rank(table[index].to));
            let idle = match config.refresh {
                AllBank => table[index].from == [PrechargeAll] && !to,
                PerBank => from || to,
            };
            let told = traffic(&config, &faulty);
            let own = told.iter().any(|breach| name.split(' ').any(|word| word == breach.rule));
            if !own && !idle {
                let others: Vec<&str> = told.iter().map(|breach| breach.rule).collect();
                missed.push(format!("{:?}, told of {others:?}", table[index]));
            }
        }
        assert!(missed.is_empty(), "{refresh}: not told of\n{}", missed.join("\n"));
    }
}
