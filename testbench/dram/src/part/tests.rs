//! Files of parts: those that are shipped, and what is wrong with a user's.

use super::*;

/// What is said of DDR4's file with `old` replaced by `new`.
fn message(old: &str, new: &str) -> String {
    let text = Part::file("ddr4-3200").unwrap();
    assert!(text.contains(old), "{old}");
    Part::parse("my.toml", &text.replacen(old, new, 1)).unwrap_err().to_string()
}

#[test]
fn the_shipped_ones() {
    for name in Part::NAMES {
        let part = Part::named(name).unwrap();
        assert_eq!(part.name, name);
        // Words of a burst on both edges of the data clock, whose ratio to the device's clock is a power of two.
        let (o, t) = (part.organisation, part.timing);
        assert!((u64::from(o.burst_length) / t.burst).is_power_of_two());
        let bytes = o.rank_banks() as u64 * u64::from(o.rows) * o.bursts() * o.burst_bytes();
        // GB/s and MiB of a data bus, as the standards have them.
        let rate = o.burst_bytes() as f64 * 1000.0 / (t.burst * t.tck_ps) as f64;
        let expected = match name {
            "ddr4-3200" => ("25.60", 8 << 10),
            "lpddr5-6400" => ("12.80", 1 << 10),
            "gddr6-14000" => ("28.07", 512),
            "hbm3-6400" => ("25.60", 256),
            _ => unreachable!(),
        };
        assert_eq!((format!("{rate:.2}").as_str(), bytes >> 20), expected, "{name}");
    }
}

#[test]
fn unknown_names() {
    assert_eq!(
        Part::named("ddr4-3201").unwrap_err().to_string(),
        "unknown part `ddr4-3201` (did you mean `ddr4-3200`?); known are `ddr4-3200`, `lpddr5-6400`, `gddr6-14000`, \
         `hbm3-6400`"
    );
    let message = message("rcd_read =", "rcd_reed =");
    assert!(
        message.starts_with("my.toml: unknown key `timing.rcd_reed` (did you mean `rcd_read`?); known are `tck_ps`, `burst`"),
        "{message}"
    );
    assert_eq!(
        self::message("name =", "nam = 1\nname ="),
        "my.toml: unknown key `nam` (did you mean `name`?); known are `name`, `organisation`, `timing`, `energy`"
    );
}

#[test]
fn values_out_of_range() {
    for (old, new, expected) in [
        ("cl = 22", "", "`timing.cl` is missing: expected a whole number from 1 to 1000000"),
        ("cl = 22", "cl = 0", "`timing.cl` is `0`: expected a whole number from 1 to 1000000"),
        ("cl = 22", "cl = -1", "`timing.cl` is `-1`: expected a whole number from 1 to 1000000"),
        (
            "cl = 22",
            "cl = 22.0",
            "`timing.cl` is `22.0`: expected a whole number from 1 to 1000000",
        ),
        (
            "cl = 22",
            "cl = \"22\"",
            "`timing.cl` is `22`: expected a whole number from 1 to 1000000",
        ),
        (
            "tck_ps = 625",
            "tck_ps = 1000001",
            "`timing.tck_ps` is `1000001`: expected a whole number from 1 to 1000000",
        ),
        (
            "rows = 65536",
            "rows = 65535",
            "`organisation.rows` is `65535`: expected a power of two from 1 to 16777216",
        ),
        (
            "banks = 4",
            "banks = 128",
            "`organisation.banks` is `128`: expected a power of two from 1 to 64",
        ),
        (
            "\"one\"",
            "\"two\"",
            "`organisation.command_buses` is `two`: expected one of `one`, `row-and-column`",
        ),
        ("name = \"ddr4-3200\"", "", "`name` is missing: expected a text"),
        ("name = \"ddr4-3200\"", "name = \"\"", "`name` is ``: expected a text"),
        (
            "[organisation]",
            "[timing.organisation]",
            "`organisation` is missing: expected a section `[organisation]`",
        ),
        (
            "rfc = 560",
            "rfc = 560\npbr2act = 9",
            "`timing.rfc_bank` is missing: expected a whole number from 1 to 1000000",
        ),
    ] {
        assert_eq!(message(old, new), format!("my.toml: {expected}"));
    }
    assert!(message("cl = 22", "cl = ").starts_with("my.toml: TOML parse error at line"));
    let error = Part::open(Path::new("/nowhere/my.toml")).unwrap_err().to_string();
    assert!(error.starts_with("/nowhere/my.toml: "), "{error}");
}

#[test]
fn contradictions() {
    for (old, new, expected) in [
        ("rc = 74", "rc = 73", "`timing.rc` is 73: expected at least ras + rp, 74"),
        ("faw = 34", "faw = 3", "`timing.faw` is 3: expected at least rrd_s, 4"),
        ("ccd_s = 4", "ccd_s = 3", "`timing.ccd_s` is 3: expected at least burst, 4"),
        ("ccd_l = 8", "ccd_l = 3", "`timing.ccd_l` is 3: expected at least ccd_s, 4"),
        ("rrd_l = 8", "rrd_l = 3", "`timing.rrd_l` is 3: expected at least rrd_s, 4"),
        ("wtr_l = 12", "wtr_l = 3", "`timing.wtr_l` is 3: expected at least wtr_s, 4"),
        ("rcd_read = 22", "rcd_read = 53", "`timing.ras` is 52: expected at least rcd_read, 53"),
        ("rtw = 12", "rtw = 9", "`timing.rtw + cwl` is 25: expected at least cl + burst, 26"),
        (
            "refi = 12480",
            "refi = 699",
            "`timing.refi` is 699: expected at least rfc + rc + cwl + burst + wr + rp, 700",
        ),
        (
            "columns = 1024",
            "columns = 4",
            "`organisation.columns` is 4: expected at least `organisation.burst_length`, 8",
        ),
        (
            "rfc = 560",
            "rfc = 560\nrfc_bank = 561\npbr2pbr = 9\npbr2act = 9",
            "`timing.rfc` is 560: expected at least rfc_bank, 561",
        ),
        (
            "rfc = 560",
            "rfc = 560\nrfc_bank = 99\npbr2pbr = 773\npbr2act = 9",
            "`timing.refi` is 12480: expected at least pbr2pbr + rrd_l for each bank, 12496",
        ),
        (
            "rfc = 560",
            "rfc = 760\nrfc_bank = 750\npbr2pbr = 9\npbr2act = 740",
            "`timing.refi` is 12480: expected at least faw + pbr2act + rrd_l for each bank, 12512",
        ),
    ] {
        assert_eq!(message(old, new), format!("my.toml: {expected}"));
    }
}
