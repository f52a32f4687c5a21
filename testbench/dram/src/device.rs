//! The banks on a data bus: which rows are open, and when each command may come at the earliest.
//!
//! Each bank, bank group and rank has a clock for every command, before which the command must not come. A command that is
//! given raises those that the rules name, so that asking is a maximum of three numbers.

use crate::command::Command;
use crate::config::Config;
use crate::table::{Constraint, Scope};

type Clocks = [u64; Command::COUNT];

/// A rule as it is followed when its first command is given.
struct Rule {
    to: &'static [Command],
    scope: Scope,
    clocks: u64,
    /// Which history it has, where its window is more than one command.
    history: Option<usize>,
}

/// The last commands of a rank that a windowed rule counts.
struct History {
    clocks: Vec<Option<u64>>,
    next: usize,
}

/// An open row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenRow {
    /// Which.
    pub row: u64,
    /// Bursts that were moved since it was opened.
    pub bursts: u32,
}

/// All banks on a data bus.
pub struct Device {
    /// Powers of two: a bank's group and rank are its number, shifted.
    group_shift: u32,
    rank_shift: u32,
    rules: [Vec<Rule>; Command::COUNT],
    banks: Vec<Clocks>,
    groups: Vec<Clocks>,
    rank: Vec<Clocks>,
    histories: Vec<Vec<History>>,
    open: Vec<Option<OpenRow>>,
}

impl Device {
    /// With all banks closed, under the rules of `table`.
    pub fn new(config: &Config, table: &[Constraint]) -> Device {
        let o = &config.part.organisation;
        let banks = config.banks() as usize;
        let mut rules: [Vec<Rule>; Command::COUNT] = Default::default();
        let mut windows = vec![];
        for constraint in table {
            let &Constraint { to, scope, clocks, window, .. } = constraint;
            let history = (window > 1).then_some(windows.len());
            windows.extend(history.map(|_| window));
            for &from in constraint.from {
                rules[from as usize].push(Rule { to, scope, clocks, history });
            }
        }
        let rank_banks = o.rank_banks();
        let history = |&window: &usize| History { clocks: vec![None; window], next: 0 };
        Device {
            group_shift: o.banks.ilog2(),
            rank_shift: rank_banks.ilog2(),
            rules,
            banks: vec![[0; Command::COUNT]; banks],
            groups: vec![[0; Command::COUNT]; banks / o.banks as usize],
            rank: vec![[0; Command::COUNT]; banks / rank_banks],
            histories: (0..banks / rank_banks)
                .map(|_| windows.iter().map(history).collect())
                .collect(),
            open: vec![None; banks],
        }
    }

    /// The first clock at which `command` may come to `bank`; for a command to a rank, to the rank of that bank.
    pub fn earliest(&self, command: Command, bank: usize) -> u64 {
        let of_bank = self.banks[bank][command as usize];
        let of_group = self.groups[bank >> self.group_shift][command as usize];
        let of_rank = self.rank[bank >> self.rank_shift][command as usize];
        of_bank.max(of_group).max(of_rank)
    }

    /// How many banks there are.
    pub fn banks(&self) -> usize {
        self.open.len()
    }

    /// The row that is open.
    pub fn open(&self, bank: usize) -> Option<OpenRow> {
        self.open[bank]
    }

    /// Gives `command` at `clock`. `row` is what an activate opens.
    pub fn issue(&mut self, command: Command, bank: usize, row: u64, clock: u64) {
        let rank = bank >> self.rank_shift;
        for rule in &self.rules[command as usize] {
            let until = match rule.history {
                None => clock + rule.clocks,
                Some(index) => {
                    let history = &mut self.histories[rank][index];
                    let next = (history.next + 1) % history.clocks.len();
                    history.clocks[history.next] = Some(clock);
                    history.next = next;
                    // The oldest of the window; none while fewer have come.
                    match history.clocks[next] {
                        Some(oldest) => oldest + rule.clocks,
                        None => continue,
                    }
                }
            };
            let raise = |clocks: &mut Clocks| {
                for &to in rule.to {
                    clocks[to as usize] = clocks[to as usize].max(until);
                }
            };
            match rule.scope {
                Scope::Bank => raise(&mut self.banks[bank]),
                Scope::Group => raise(&mut self.groups[bank >> self.group_shift]),
                Scope::Rank => raise(&mut self.rank[rank]),
                Scope::OtherRanks => {
                    let others =
                        self.rank.iter_mut().enumerate().filter(|&(other, _)| other != rank);
                    others.for_each(|(_, clocks)| raise(clocks));
                }
            }
        }
        match command {
            Command::Activate => self.open[bank] = Some(OpenRow { row, bursts: 0 }),
            Command::Precharge => self.open[bank] = None,
            Command::PrechargeAll => {
                let (first, end) = (rank << self.rank_shift, (rank + 1) << self.rank_shift);
                self.open[first..end].fill(None);
            }
            Command::Read | Command::Write => {
                self.open[bank].iter_mut().for_each(|open| open.bursts += 1);
            }
            Command::Refresh | Command::RefreshBank => {}
        }
    }
}
