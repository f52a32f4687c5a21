//! What values of a part contradict each other.

use super::Part;

/// Expects `[key, sum]` pairs: the first at least as large as the second.
struct AtLeast {
    key: &'static str,
    value: u64,
    sum: &'static str,
    least: u64,
}

/// The first contradiction, as a sentence.
pub fn contradiction(part: &Part) -> Option<String> {
    let (o, t) = (&part.organisation, &part.timing);
    if o.columns < o.burst_length {
        return Some(format!(
            "`organisation.columns` is {}: expected at least `organisation.burst_length`, {}",
            o.columns, o.burst_length
        ));
    }
    let banks = u64::from(o.bank_groups * o.banks);
    let rule = |key, value, sum, least| AtLeast { key, value, sum, least };
    let mut rules = vec![
        rule("rc", t.rc, "ras + rp", t.ras + t.rp),
        rule("ras", t.ras, "rcd_read", t.rcd_read),
        rule("ccd_s", t.ccd_s, "burst", t.burst),
        rule("ccd_l", t.ccd_l, "ccd_s", t.ccd_s),
        rule("rrd_l", t.rrd_l, "rrd_s", t.rrd_s),
        rule("faw", t.faw, "rrd_s", t.rrd_s),
        rule("wtr_l", t.wtr_l, "wtr_s", t.wtr_s),
        // Else a write's data would meet those of the read before it.
        rule("rtw + cwl", t.rtw + t.cwl, "cl + burst", t.cl + t.burst),
        // Else a rank would do nothing but refresh.
        rule(
            "refi",
            t.refi,
            "rfc + rc + cwl + burst + wr + rp",
            t.rfc + t.rc + t.cwl + t.burst + t.wr + t.rp,
        ),
    ];
    if let Some(bank) = &t.bank_refresh {
        rules.push(rule("rfc", t.rfc, "rfc_bank", bank.rfc));
        rules.push(rule("rfc_bank", bank.rfc, "pbr2act", bank.to_activate));
        rules.push(rule(
            "refi",
            t.refi,
            "pbr2pbr + rrd_l for each bank",
            banks * (bank.to_refresh + t.rrd_l),
        ));
        // Else activates would never come between refreshes.
        rules.push(rule(
            "refi",
            t.refi,
            "faw + pbr2act + rrd_l for each bank",
            banks * (t.faw + bank.to_activate + t.rrd_l),
        ));
    }
    let broken = rules.iter().find(|rule| rule.value < rule.least)?;
    let AtLeast { key, value, sum, least } = broken;
    Some(format!("`timing.{key}` is {value}: expected at least {sum}, {least}"))
}
