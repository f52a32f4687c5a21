//! Whether a sequence of commands is legal for a part: the rules, written once more from the part's numbers, without a word of
//! the scheduler's table. Every command is held against every earlier one that can still matter.

use pellucid_dram::{Command, CommandBuses, Config, Issued, Refresh};
use std::collections::VecDeque;

/// A rule that a command broke.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Breach {
    /// The rule's name in the part's table, or what state of the bank forbids.
    pub rule: &'static str,
    /// The command.
    pub at: Issued,
}

#[derive(Clone, Copy)]
struct Bus {
    /// The end of the last data.
    end: u64,
    /// From or to which rank.
    rank: usize,
}

/// Follows the commands of one channel.
pub struct Checker {
    config: Config,
    rows: Vec<Option<u64>>,
    past: VecDeque<Issued>,
    buses: Vec<Option<Bus>>,
    /// Refreshes of each rank.
    refreshes: Vec<u64>,
    /// Longer than any rule reaches back.
    horizon: u64,
}

impl Checker {
    pub fn new(config: &Config) -> Checker {
        let (o, t) = (&config.part.organisation, &config.part.timing);
        let ranks = (o.pseudo_channels * config.ranks) as usize;
        let bank = t.bank_refresh.map_or(0, |bank| bank.rfc + bank.to_refresh);
        Checker {
            rows: vec![None; ranks * (o.bank_groups * o.banks) as usize],
            past: VecDeque::new(),
            buses: vec![None; o.pseudo_channels as usize],
            refreshes: vec![0; ranks],
            horizon: t.rfc + t.rc + t.faw + t.rtw + t.cwl + t.burst + t.wr + t.wtr_l + bank,
            config: config.clone(),
        }
    }

    fn rank(&self, bank: usize) -> usize {
        bank / (self.config.part.organisation.bank_groups * self.config.part.organisation.banks)
            as usize
    }

    fn group(&self, bank: usize) -> usize {
        bank / self.config.part.organisation.banks as usize
    }

    fn pseudo(&self, bank: usize) -> usize {
        self.rank(bank) / self.config.ranks as usize
    }

    /// How long after `past` the command `next` may come, by each rule that has both.
    fn rules(&self, past: &Issued, next: &Issued) -> Vec<(&'static str, u64)> {
        use Command::*;
        let t = &self.config.part.timing;
        let bank = past.bank == next.bank;
        let group = self.group(past.bank) == self.group(next.bank);
        if self.rank(past.bank) != self.rank(next.bank) {
            return vec![];
        }
        let refresh = t.bank_refresh.as_ref();
        let mut rules = vec![];
        let mut rule = |name, clocks, holds: bool| {
            if holds {
                rules.push((name, clocks));
            }
        };
        let written = t.cwl + t.burst;
        match (past.command, next.command) {
            (Activate, Read) => rule("rcd_read", t.rcd_read, bank),
            (Activate, Write) => rule("rcd_write", t.rcd_write, bank),
            (Activate, Precharge) => rule("ras", t.ras, bank),
            (Activate, PrechargeAll) => rule("ras", t.ras, true),
            (Activate, Activate | RefreshBank) => {
                rule("rc", t.rc, bank);
                rule("rrd_l", t.rrd_l, group);
                rule("rrd_s", t.rrd_s, true);
            }
            (Activate, Refresh) => rule("rc", t.rc, true),
            (Precharge, Activate | RefreshBank) => rule("rp", t.rp, bank),
            (Precharge, Refresh) | (PrechargeAll, Activate | Refresh | RefreshBank) => {
                rule("rp", t.rp, true)
            }
            (Precharge | PrechargeAll, Precharge | PrechargeAll) => rule("ppd", t.ppd, true),
            (Read, Read) | (Write, Write) => {
                rule("ccd_l", t.ccd_l, group);
                rule("ccd_s", t.ccd_s, true);
            }
            (Read, Write) => rule("rtw", t.rtw, true),
            (Write, Read) => {
                rule("wtr_l", written + t.wtr_l, group);
                rule("wtr_s", written + t.wtr_s, true);
            }
            (Read, Precharge) => rule("rtp", t.rtp, bank),
            (Read, PrechargeAll) => rule("rtp", t.rtp, true),
            (Write, Precharge) => rule("wr", written + t.wr, bank),
            (Write, PrechargeAll) => rule("wr", written + t.wr, true),
            (Refresh, Activate | Refresh | RefreshBank) => rule("rfc", t.rfc, true),
            (RefreshBank, Activate) => {
                rule("rfc_bank", refresh.map_or(0, |r| r.rfc), bank);
                rule("pbr2act", refresh.map_or(0, |r| r.to_activate), true);
            }
            (RefreshBank, RefreshBank) => {
                rule("rfc_bank", refresh.map_or(0, |r| r.rfc), bank);
                rule("pbr2pbr", refresh.map_or(0, |r| r.to_refresh), true);
            }
            _ => {}
        }
        rules
    }

    fn state(&mut self, c: &Issued) -> Option<&'static str> {
        let banks = (self.config.part.organisation.bank_groups
            * self.config.part.organisation.banks) as usize;
        let first = self.rank(c.bank) * banks;
        let open = self.rows[c.bank];
        let rank_open = self.rows[first..first + banks].iter().any(Option::is_some);
        match c.command {
            Command::Activate if open.is_some() => return Some("activate of an open bank"),
            Command::Activate => self.rows[c.bank] = Some(c.row),
            Command::Precharge => self.rows[c.bank] = None,
            Command::PrechargeAll => self.rows[first..first + banks].fill(None),
            Command::Read | Command::Write if open != Some(c.row) => {
                return Some("burst of a row that is not open");
            }
            Command::Read | Command::Write => {}
            Command::Refresh if rank_open => return Some("refresh of an open bank"),
            Command::RefreshBank if open.is_some() => return Some("refresh of an open bank"),
            Command::Refresh | Command::RefreshBank => {
                let rank = self.rank(c.bank);
                let order = self.refreshes[rank] as usize % banks;
                if c.command == Command::RefreshBank && c.bank != first + order {
                    return Some("refresh out of turn");
                }
                self.refreshes[rank] += 1;
            }
        }
        None
    }

    fn data(&mut self, c: &Issued) -> Option<&'static str> {
        let t = &self.config.part.timing;
        let begin = match c.command {
            Command::Read => c.clock + t.cl,
            Command::Write => c.clock + t.cwl,
            _ => return None,
        };
        let (rank, pseudo) = (self.rank(c.bank), self.pseudo(c.bank));
        let last = self.buses[pseudo].replace(Bus { end: begin + t.burst, rank })?;
        if begin < last.end {
            Some(if last.rank == rank { "burst" } else { "rank_switch" })
        } else if last.rank != rank && begin < last.end + t.rank_switch {
            Some("rank_switch")
        } else {
            None
        }
    }

    /// The next command of the channel; the rules that it breaks.
    pub fn command(&mut self, c: Issued) -> Vec<Breach> {
        let breach = |rule| Breach { rule, at: c };
        let mut breaches = vec![];
        while self.past.front().is_some_and(|past| past.clock + self.horizon < c.clock) {
            self.past.pop_front();
        }
        for past in &self.past {
            let broken = self.rules(past, &c).into_iter().filter(|(_, n)| past.clock + n > c.clock);
            breaches.extend(broken.map(|(rule, _)| breach(rule)));
        }
        let opens = |c: &Issued| matches!(c.command, Command::Activate | Command::RefreshBank);
        let in_window = |past: &&Issued| {
            opens(past)
                && self.rank(past.bank) == self.rank(c.bank)
                && past.clock + self.config.part.timing.faw > c.clock
        };
        if opens(&c) && self.past.iter().filter(in_window).count() >= 4 {
            breaches.push(breach("faw"));
        }
        let buses = self.config.part.organisation.command_buses;
        let same_bus = |past: &Issued| {
            buses == CommandBuses::One || past.command.is_column() == c.command.is_column()
        };
        if self.past.iter().any(|past| past.clock >= c.clock && same_bus(past)) {
            breaches.push(breach("command bus"));
        }
        breaches.extend(self.data(&c).map(breach));
        breaches.extend(self.state(&c).map(breach));
        self.past.push_back(c);
        breaches
    }

    /// Holds the refreshes of every rank to their times, after `clocks`: each comes within two row cycles after it was due.
    pub fn refreshed(&self, clocks: u64) -> Result<(), String> {
        let o = &self.config.part.organisation;
        let t = &self.config.part.timing;
        let parts = match self.config.refresh {
            Refresh::AllBank => 1,
            Refresh::PerBank => u64::from(o.bank_groups * o.banks),
        };
        let late = 2 * (t.rc + t.cwl + t.burst + t.wr + t.rp);
        for (rank, &done) in self.refreshes.iter().enumerate() {
            // The first is due within twice an interval, as the ranks are spread over it.
            let least = (clocks.saturating_sub(late) * parts / t.refi).saturating_sub(1);
            let most = clocks * parts / t.refi;
            if !(least..=most).contains(&done) {
                return Err(format!(
                    "rank {rank} had {done} refreshes in {clocks} clocks: expected {least} to {most}"
                ));
            }
        }
        Ok(())
    }
}

/// The commands of all channels; the rules that they break.
pub fn check(
    config: &Config,
    commands: &[Issued],
    clocks: u64,
) -> (Vec<Breach>, Result<(), String>) {
    let mut breaches = vec![];
    let mut refreshed = Ok(());
    for channel in 0..config.channels as usize {
        let mut checker = Checker::new(config);
        for &command in commands.iter().filter(|c| c.channel == channel) {
            breaches.extend(checker.command(command));
        }
        refreshed = refreshed.and(checker.refreshed(clocks));
    }
    (breaches, refreshed)
}
