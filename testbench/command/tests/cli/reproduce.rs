//! `reproduce`: the figures of the T-buffer paper.

use super::*;

/// Pixels with exactly 1, 2, ... transparent fragments in each frame: seed document 000, table 1.
const FRAMES: [(&str, [u64; 5]); 8] = [
    ("paper-0", [5812, 956, 6633, 2279, 189]),
    ("paper-120", [5723, 956, 6634, 2278, 189]),
    ("paper-180", [8713, 956, 6634, 2278, 189]),
    ("paper-240", [32588, 12040, 7235, 2279, 189]),
    ("paper-300", [26082, 2729, 6636, 2179, 121]),
    ("paper-360", [27421, 7094, 7006, 1569, 173]),
    ("paper-420", [15728, 3290, 6770, 1296, 15]),
    ("paper-480", [95226, 8716, 6711, 671, 0]),
];
const PIXELS: u64 = 640 * 480;

/// Accesses and bytes by the formulas of the document's table 2, section capacity 3 and 2.
fn forms(n: &[u64; 5]) -> [[u64; 2]; 3] {
    let sum = |of: fn(u64) -> u64| n.iter().zip(1..).map(|(n, i)| n * of(i)).sum::<u64>();
    let (fragments, pixels) = (sum(|i| i), sum(|_| 1));
    [
        [2 * fragments + pixels, 2 * PIXELS + 20 * sum(|i| i.div_ceil(3))],
        [2 * fragments + sum(|i| i * (i + 1)), 10 * fragments + 4 * PIXELS + 3 * PIXELS / 8],
        [2 * fragments, 14 * (PIXELS + sum(|i| i.div_ceil(2) - 1))],
    ]
}

#[test]
fn the_t_buffer_paper_comes_out() {
    let folder = folder();
    let output = exact(pellucid(folder.path(), &["reproduce", "tbuffer", "--json", "--quiet"]));
    let json: Value = serde_json::from_str(stdout(&output)).unwrap();
    let mut ratios = [0.0; 4];
    for (k, (name, n)) in FRAMES.iter().enumerate() {
        let frame = &json["frames"][k];
        assert_eq!(frame["scene"], *name);
        let forms = forms(n);
        for (arch, [accesses, bytes]) in ["tbuffer", "rbuffer", "mbuffer"].iter().zip(forms) {
            let need = serde_json::json!({ "accesses": accesses, "bytes": bytes });
            assert_eq!(frame[arch]["closed_form"], need, "{name}, {arch}");
            assert_eq!(frame[arch]["counted"], need, "{name}, {arch}");
        }
        let [t, r, m] = forms.map(|need| need.map(|n| n as f64));
        let pairs = [(t[0], r[0]), (t[0], m[0]), (t[1], r[1]), (t[1], m[1])];
        for (ratio, (a, b)) in ratios.iter_mut().zip(pairs) {
            *ratio += a / b / FRAMES.len() as f64;
        }
    }
    for (k, printed) in [-52.0, 27.0, -29.0, -67.0].into_iter().enumerate() {
        let headline = &json["headlines"][k];
        assert_eq!(headline["printed_percent"], printed);
        let found = headline["found_percent"].as_f64().unwrap();
        assert!((found - 100.0 * (ratios[k] - 1.0)).abs() < 1e-9, "{headline}");
        assert!((found - printed).abs() <= 2.0, "{headline}");
    }
    // The remark in the document's section 4.
    let capacities = json["section_capacities"].as_array().unwrap();
    let three = capacities.iter().find(|c| c["section_capacity"] == 3).unwrap();
    assert_eq!(three["frames_above_rbuffer"], serde_json::json!(["paper-480"]));
}

#[test]
fn an_unknown_comparison_is_refused() {
    let folder = folder();
    let output = pellucid(folder.path(), &["reproduce", "paper"]);
    let said = stderr(&output);
    assert!(said.starts_with("error: invalid value 'paper' for '<WHAT>'\n"), "{said}");
    assert!(said.contains("[possible values: tbuffer, composer]"), "{said}");
    assert_eq!(output.status.code(), Some(2));
}

/// Seed document 001, section 3.5, with its formulas for one line.
#[test]
fn the_image_composition_papers_times_come_out() {
    let folder = folder();
    let output = exact(pellucid(folder.path(), &["reproduce", "composer", "--json", "--quiet"]));
    let json: Value = serde_json::from_str(stdout(&output)).unwrap();
    // v, w, t in nanoseconds, n; T_m and T_in in milliseconds as they come out of the formulas.
    let cases = [
        (640u64, 480u64, 80u64, 16u64, 25.349, 0.0579),
        (1280, 1024, 20, 16, 26.625, 0.0273),
        (640, 480, 80, 1024, 25.672, 0.3805),
        (1280, 1024, 20, 1024, 26.706, 0.1079),
    ];
    for (k, (v, w, t, n, merge, first)) in cases.into_iter().enumerate() {
        let case = &json["cases"][k];
        let line = v + 20;
        let lines = case["counted_lines"].as_u64().unwrap();
        assert_eq!(lines, if n == 16 { w } else { 2 });
        let counted = serde_json::json!({
            "merge": line * lines + 4 * n, "first_line": line + 4 * n, "last_line": line
        });
        assert_eq!(case["counted_clocks"], counted);
        assert_eq!(case["closed_form_clocks"], counted);
        let near = |what: &str, expected: f64, digits: f64| {
            let found = case["closed_form"][what].as_f64().unwrap();
            assert!((found - expected).abs() <= digits, "{what}: {found}, expected {expected}");
        };
        near("merge_ms", merge, 0.0006);
        near("first_line_ms", first, 0.00006);
        near("last_line_ms", (line * t) as f64 * 1e-6, 1e-9);
        near("lost_percent", ((2 * line + 4 * n) * t) as f64 * 1e-4 / 33.3, 1e-9);
    }
    // What is printed and does not come out is named.
    assert_eq!(json["cases"][1]["printed"]["first_line_ms"], 0.038);
    assert!(json["cases"][1]["slips"]["first_line_ms"].is_string());
    assert!(json["cases"][0]["slips"]["first_line_ms"].is_null());
}
