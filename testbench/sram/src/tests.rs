use super::*;
use proptest::prelude::*;

const NODES: [u32; 3] = [45, 32, 22];

/// The rows of the shipped table, read without the code that is tested: node, ports, width, bytes and the six figures.
fn rows() -> Vec<(u32, Ports, u32, u64, [f64; 6])> {
    let lines = include_str!("cacti7.csv").lines().filter(|line| !line.starts_with('#')).skip(1);
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let ports = if fields[1] == "1rw" { Ports::One } else { Ports::OneReadOneWrite };
        let figures = std::array::from_fn(|k| fields[4 + k].parse().unwrap());
        let whole = |k: usize| fields[k].parse::<u64>().unwrap();
        (whole(0) as u32, ports, whole(2) as u32, whole(3), figures)
    };
    lines.map(row).collect()
}

fn figures(price: &Price) -> [f64; 6] {
    let Price { access_ns, cycle_ns, read_nj, write_nj, leakage_mw, area_mm2 } = *price;
    [access_ns, cycle_ns, read_nj, write_nj, leakage_mw, area_mm2]
}

fn price(node: u32, ports: Ports, words: u64, bits: u32) -> [f64; 6] {
    let table = Table::shipped();
    figures(&table.node(node).unwrap().price(&Memory { words, bits, ports }))
}

#[test]
fn every_point_of_the_table_is_hit() {
    let rows = rows();
    assert_eq!(rows.len(), 3 * 2 * 3 * 9);
    for (node, ports, bits, bytes, expected) in rows {
        assert_eq!(price(node, ports, bytes * 8 / u64::from(bits), bits), expected);
    }
}

/// Energy, leakage and area of the table grow with the size at each width; only the cycle time does not always.
#[test]
fn more_words_never_take_less() {
    for node in NODES {
        for ports in [Ports::One, Ports::OneReadOneWrite] {
            for bits in [1, 20, 32, 47, 64, 96, 128, 129, 200] {
                let mut before = price(node, ports, 1, bits);
                // Steps of an eighth of a doubling, from below the table to far beyond it.
                for step in 1..=200 {
                    let words = 2f64.powf(f64::from(step) / 8.0) as u64;
                    let now = price(node, ports, words, bits);
                    for k in [0, 2, 3, 4, 5] {
                        assert!(now[k] >= before[k] * (1.0 - 1e-12), "{node} {bits} {words} {k}");
                    }
                    before = now;
                }
            }
        }
    }
}

#[test]
fn between_two_points_there_is_a_power_law() {
    let of = |bytes, bits| {
        let found = rows().into_iter().find(|(node, ports, width, size, _)| {
            (*node, *ports, *width, *size) == (22, Ports::One, bits, bytes)
        });
        found.unwrap().4
    };
    // Half way between logarithms: 1536 bytes are log2(1.5) of the way.
    let part = 1.5f64.log2();
    let (low, high, found) = (of(1024, 64), of(2048, 64), price(22, Ports::One, 192, 64));
    for k in 0..6 {
        let expected = (low[k].ln() * (1.0 - part) + high[k].ln() * part).exp();
        assert!((found[k] / expected - 1.0).abs() < 1e-12, "{k}");
    }
    // 48 bits are as far from 32 to 64.
    let (low, high, found) = (of(2048, 32), of(2048, 64), price(22, Ports::One, 2048 * 8 / 48, 48));
    // 341 words of 48 bits are 2046 bytes: the size is a hair below the point.
    for k in 0..6 {
        let expected = (low[k].ln() * (1.0 - part) + high[k].ln() * part).exp();
        assert!((found[k] / expected - 1.0).abs() < 2e-3, "{k}");
    }
}

#[test]
fn what_is_beyond_the_table_goes_by_its_rules() {
    for node in NODES {
        // Below: as the smallest.
        assert_eq!(price(node, Ports::One, 4, 8), price(node, Ports::One, 256, 32));
        // Wider: two slices side by side, each with all words.
        let [one, two] = [128, 256].map(|bits| price(node, Ports::OneReadOneWrite, 1024, bits));
        assert_eq!(two[..2], one[..2]);
        (2..6).for_each(|k| assert_eq!(two[k], 2.0 * one[k]));
        // Larger: banks. The largest has 32768 words of 64 bits.
        let [one, nine] = [1, 9].map(|n| price(node, Ports::One, n * 32768, 64));
        assert_eq!([nine[1], nine[4], nine[5]], [one[1], 9.0 * one[4], 9.0 * one[5]]);
        [0, 2, 3].iter().for_each(|&k| assert_eq!(nine[k], 3.0 * one[k]));
    }
}

/// Over the last two doublings of the table energy and time grow by less than the root of the size, on average, and area by
/// the size: what larger memories go by.
#[test]
fn the_rule_for_banks_is_near_what_the_table_does() {
    let rows = rows();
    let mut exponents = [0.0; 6];
    for (node, ports, bits, _, large) in rows.iter().filter(|row| row.3 == 262_144) {
        let small =
            rows.iter().find(|row| (row.0, row.1, row.2, row.3) == (*node, *ports, *bits, 65_536));
        let small = small.unwrap().4;
        (0..6).for_each(|k| exponents[k] += (large[k] / small[k]).log2() / 2.0 / 18.0);
    }
    let [access, _, read, write, leakage, area] = exponents;
    for (found, expected) in
        [(access, 0.43), (read, 0.46), (write, 0.45), (leakage, 0.96), (area, 1.0)]
    {
        assert!((found - expected).abs() < 0.01, "{exponents:?}");
    }
}

/// How far a point is from what its neighbours at half and twice the size say: at most so much the interpolation can be off,
/// which goes half as far.
#[test]
fn how_far_interpolation_is_off() {
    let rows = rows();
    let mut most = [0.0f64; 6];
    for (node, ports, bits, bytes, here) in &rows {
        let at = |size: u64| {
            rows.iter().find(|row| (row.0, row.1, row.2, row.3) == (*node, *ports, *bits, size))
        };
        let (Some(half), Some(twice)) = (at(bytes / 2), at(bytes * 2)) else { continue };
        for k in 0..6 {
            most[k] = most[k].max(((half.4[k] * twice.4[k]).sqrt() / here[k] - 1.0).abs());
        }
    }
    // Access, read, write, leakage and area, as the book says.
    let percent = [0, 2, 3, 4, 5].map(|k| (most[k] * 100.0).ceil() as u32);
    assert_eq!(percent, [16, 24, 20, 11, 15]);
}

fn refused(text: &str) -> String {
    Table::parse("my.csv", text).unwrap_err().to_string()
}

#[test]
fn what_is_wrong_with_a_file_is_named() {
    let shipped = include_str!("cacti7.csv");
    let header = table::HEADER;
    assert_eq!(refused(""), format!("my.csv: no line: expected the header `{header}`"));
    assert_eq!(
        refused("# x\na,b\n"),
        format!("my.csv: line 2: `a,b`: expected the header `{header}`")
    );
    assert_eq!(refused(header), "my.csv: no row: expected a row for each memory");
    let with = |row: &str| refused(&format!("{header}\n{row}\n"));
    assert_eq!(with("22,1rw"), format!("my.csv: line 2: 2 fields: expected 10, {header}"));
    assert_eq!(
        with("22,2rw,64,1024,1,1,1,1,1,1"),
        "my.csv: line 2: column ports is `2rw`: expected 1rw or 1r1w"
    );
    assert_eq!(
        with("22,1rw,64,-1,1,1,1,1,1,1"),
        "my.csv: line 2: column bytes is `-1`: expected a whole number from 1 to 1099511627776"
    );
    for value in ["", "nan", "-1", "inf", "0", "x"] {
        assert_eq!(
            with(&format!("22,1rw,64,1024,1,1,1,1,1,{value}")),
            format!("my.csv: line 2: column area_mm2 is `{value}`: expected a number above 0")
        );
    }
    assert_eq!(
        with("22,1rw,64,1024,1,1,1,1,1,1"),
        "my.csv: node 22 has no row of ports 1r1w: expected 1rw and 1r1w"
    );
    let row = shipped.lines().find(|line| line.starts_with("32,1r1w,64,4096,")).unwrap();
    assert_eq!(
        refused(&shipped.replace(&format!("{row}\n"), "")),
        "my.csv: node 32, 1r1w: no row with 64 word_bits and 4096 bytes: expected every size with every width"
    );
    assert_eq!(
        refused(&format!("{shipped}{row}\n")),
        "my.csv: line 166: a row of that node, ports, word_bits and bytes stands above: expected one"
    );
    assert_eq!(
        Table::shipped().node(28).unwrap_err().to_string(),
        "unknown node `28`; known are `22`, `32`, `45` (nm, of CACTI 7)"
    );
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.csv");
    let error = Table::open(&path).unwrap_err().to_string();
    assert_eq!(error, format!("{}: No such file or directory (os error 2)", path.display()));
    std::fs::write(&path, include_str!("cacti7.csv")).unwrap();
    assert!(Table::open(&path).unwrap().node(45).is_ok());
}

proptest! {
    #[test]
    fn every_memory_has_a_price(words in 1u64..1 << 34, bits in 1u32..5000, node in 0usize..3) {
        for ports in [Ports::One, Ports::OneReadOneWrite] {
            let price = price(NODES[node], ports, words, bits);
            prop_assert!(price.iter().all(|figure| figure.is_finite() && *figure > 0.0));
        }
    }
}
