//! The rules of a device as one table: how long after which command another one may come.

use crate::command::Command::{self, *};
use crate::config::{Config, Refresh};

/// Where a rule holds, seen from the first command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// In the same bank.
    Bank,
    /// In every bank of the same bank group.
    Group,
    /// In every bank of the same rank. What holds between bank groups stands here, as the groups' own rules are longer.
    Rank,
    /// In the other ranks on the same data bus.
    OtherRanks,
}

/// A rule: a command of `to` comes at least `clocks` after one of `from`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Constraint {
    /// Its name in the part's table, or the sum of such names.
    pub name: &'static str,
    /// What goes before.
    pub from: &'static [Command],
    /// What comes after.
    pub to: &'static [Command],
    /// Where.
    pub scope: Scope,
    /// How long after, device clocks.
    pub clocks: u64,
    /// After which of the commands before: 1 the last, 4 the fourth last. Above 1 only for [`Scope::Rank`].
    pub window: usize,
}

/// The rules of a memory. Those that would let the second command come before the first one are left out.
pub fn constraints(config: &Config) -> Vec<Constraint> {
    use Scope::*;
    let t = &config.part.timing;
    let written = t.cwl + t.burst;
    let mut table = vec![];
    let mut rule = |name, from, to, scope, clocks| {
        table.push(Constraint { name, from, to, scope, clocks, window: 1 });
    };
    rule("rcd_read", &[Activate], &[Read], Bank, t.rcd_read);
    rule("rcd_write", &[Activate], &[Write], Bank, t.rcd_write);
    rule("ras", &[Activate], &[Precharge], Bank, t.ras);
    rule("rc", &[Activate], &[Activate, RefreshBank], Bank, t.rc);
    rule("rp", &[Precharge], &[Activate, RefreshBank], Bank, t.rp);
    rule("rtp", &[Read], &[Precharge], Bank, t.rtp);
    rule("cwl + burst + wr", &[Write], &[Precharge], Bank, written + t.wr);

    rule("ccd_l", &[Read], &[Read], Group, t.ccd_l);
    rule("ccd_l", &[Write], &[Write], Group, t.ccd_l);
    rule("cwl + burst + wtr_l", &[Write], &[Read], Group, written + t.wtr_l);
    rule("rrd_l", &[Activate], &[Activate, RefreshBank], Group, t.rrd_l);

    rule("ccd_s", &[Read], &[Read], Rank, t.ccd_s);
    rule("ccd_s", &[Write], &[Write], Rank, t.ccd_s);
    rule("cwl + burst + wtr_s", &[Write], &[Read], Rank, written + t.wtr_s);
    rule("rtw", &[Read], &[Write], Rank, t.rtw);
    rule("rrd_s", &[Activate], &[Activate, RefreshBank], Rank, t.rrd_s);
    rule("ppd", &[Precharge, PrechargeAll], &[Precharge, PrechargeAll], Rank, t.ppd);
    rule("ras", &[Activate], &[PrechargeAll], Rank, t.ras);
    rule("rtp", &[Read], &[PrechargeAll], Rank, t.rtp);
    rule("cwl + burst + wr", &[Write], &[PrechargeAll], Rank, written + t.wr);
    rule("rp", &[PrechargeAll], &[Activate], Rank, t.rp);
    rule("rp", &[Precharge, PrechargeAll], &[Refresh], Rank, t.rp);
    rule("rc", &[Activate], &[Refresh], Rank, t.rc);
    rule("rfc", &[Refresh], &[Activate, Refresh], Rank, t.rfc);

    // The data bus changes from one rank to another.
    rule("burst + rank_switch", &[Read], &[Read], OtherRanks, t.burst + t.rank_switch);
    rule("burst + rank_switch", &[Write], &[Write], OtherRanks, t.burst + t.rank_switch);
    let turn = t.cl + t.burst + t.rank_switch;
    rule(
        "cl + burst + rank_switch - cwl",
        &[Read],
        &[Write],
        OtherRanks,
        turn.saturating_sub(t.cwl),
    );
    let turn = written + t.rank_switch;
    rule(
        "cwl + burst + rank_switch - cl",
        &[Write],
        &[Read],
        OtherRanks,
        turn.saturating_sub(t.cl),
    );

    if let (Refresh::PerBank, Some(bank)) = (config.refresh, &t.bank_refresh) {
        rule("rfc_bank", &[RefreshBank], &[Activate, RefreshBank], Bank, bank.rfc);
        rule("pbr2pbr", &[RefreshBank], &[RefreshBank], Rank, bank.to_refresh);
        rule("pbr2act", &[RefreshBank], &[Activate], Rank, bank.to_activate);
    }
    table.retain(|constraint| constraint.clocks > 0);
    // A bank that is refreshed opens rows, too.
    let opening = &[Activate, RefreshBank];
    table.push(Constraint {
        name: "faw",
        from: opening,
        to: opening,
        scope: Rank,
        clocks: t.faw,
        window: 4,
    });
    table
}
