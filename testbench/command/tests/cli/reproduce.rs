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
            // The R-buffer sends fragments round: of the three it reads and writes most.
            let accesses_nj = |arch: &str| frame["costs"][arch]["accesses_nj"].as_f64().unwrap();
            assert!(accesses_nj(arch) > 0.0 && accesses_nj(arch) <= accesses_nj("rbuffer"));
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
    assert!(
        said.contains("[possible values: tbuffer, composer, dfb, fbuffer, accumulation]"),
        "{said}"
    );
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

/// What the paper's formulas say, from what the frames are: quads are over whole pixels, each as many layers deep as there are
/// quads.
#[test]
fn the_dynamic_fragment_buffers_figures_come_out() {
    let folder = folder();
    let output = exact(pellucid(folder.path(), &["reproduce", "dfb", "--json", "--quiet"]));
    let json: Value = serde_json::from_str(stdout(&output)).unwrap();
    let number = |value: &Value| value.as_u64().unwrap();
    let machine = |frames: &Value, name: &str| {
        let machines = frames["machines"].as_array().unwrap();
        machines.iter().find(|machine| machine["machine"] == name).unwrap().clone()
    };
    let all = json["frames"].as_array().unwrap();
    let mut figures = std::collections::BTreeMap::new();
    for frames in all {
        *figures.entry(frames["figure"].as_str().unwrap()).or_insert(0) += 1;
        let scene = frames["scene"].as_str().unwrap();
        let Some((quads, percent)) = scene.strip_prefix("quads-").and_then(|s| s.split_once('-'))
        else {
            continue;
        };
        let [quads, percent]: [u64; 2] = [quads, percent].map(|n| n.parse().unwrap());
        let pixels = number(&frames["width"]) * number(&frames["height"]);
        // Whole rows and a part of one.
        let covered = number(&frames["need"]["fragments"]) / quads;
        assert!((pixels * percent).abs_diff(100 * covered) < 100, "{scene}: {covered} of {pixels}");
        let layers = if percent == 0 { 0 } else { quads };
        let bytes = |name| {
            let machine = machine(frames, name);
            assert_eq!(machine["bytes"], machine["bytes_counted"], "{scene}, {name}");
            number(&machine["bytes"])
        };
        assert_eq!(bytes("dfb:fast"), 16 * quads * covered + 8 * pixels, "{scene}");
        assert_eq!(bytes("b3d"), 16 * pixels * layers.max(1), "{scene}");
        assert_eq!(bytes("ppll4"), 68 * covered * quads.div_ceil(4) + 4 * pixels, "{scene}");
        assert_eq!(bytes("pll"), 20 * covered * quads + 4 * pixels, "{scene}");
        // A scan takes a cycle for each word, and one more.
        for (name, lanes) in [("dfb:fast", 16), ("dfb:paper", 1)] {
            let cycles = machine(frames, name)["cycles"].clone();
            assert_eq!(number(&cycles["scan"]), pixels.div_ceil(lanes) + 1, "{scene}, {name}");
        }
        // Pages are doubled from a slot a pixel on until they are enough.
        for (name, page) in [("ppll4", 4_u64), ("pll", 1)] {
            let need = covered * quads.div_ceil(page);
            let begin = (pixels / page).min(need.max(1));
            let rebuilds = (0..).find(|n| begin << n >= need).unwrap();
            assert_eq!(number(&machine(frames, name)["plays"]), 1 + rebuilds, "{scene}, {name}");
        }
    }
    let expected = [("Table I", 3), ("Figures 5 and 6", 45), ("Figure 7", 9), ("Figure 8", 1)];
    assert_eq!(figures, expected.into());
    // Printed.
    assert_eq!(json["table_1_printed"][2]["frames_per_second"]["pll"], 74);
    let holds = |what: &str| {
        let claims = json["claims"].as_array().unwrap();
        claims.iter().find(|c| c["claim"].as_str().unwrap().contains(what)).unwrap()["holds"]
            .clone()
    };
    assert_eq!(holds("depends on the resolution alone"), true);
    assert_eq!(holds("B3D cannot hold the power plant"), true);

    // What is there is kept, but for what is damaged or of something else; the figures are the same.
    let out = folder.path().join("pellucid-reproduce");
    let files = ["dfb.html", "dfb.json", "dfb.csv"].map(|name| fs::read(out.join(name)).unwrap());
    assert_eq!(elements(&files[0], "svg"), 9 + 6 + 2 * 3 + 1);
    let run = |name: &str| out.join("runs/scene-quads-1-10-width-80-height-80").join(name);
    fs::write(run("pll.json"), "{").unwrap();
    let change = |name: &str, what: &str, to: &str| {
        let text = fs::read_to_string(run(name)).unwrap();
        assert!(text.contains(what), "{text}");
        fs::write(run(name), text.replacen(what, to, 1)).unwrap();
    };
    change("b3d.json", "layers=1", "layers=2");
    change("ppll4.json", "\"total\": ", "\"total\": 9");
    change("dfb-fast.json", "\"faults\": []", "\"faults\": [\"wrong\"]");
    change("dfb-paper.json", " bytes of ", " bytes of 1");
    let output = pellucid(folder.path(), &["reproduce", "dfb"]);
    assert_eq!(output.status.code(), Some(0));
    let runs = all.iter().flat_map(|frames| frames["machines"].as_array().unwrap());
    let runs = runs.filter(|machine| machine["lacks"].is_null()).count();
    let note = format!("note: {} runs are those of an earlier time;", runs - 5);
    assert!(stderr(&output).contains(&note), "{note}: {}", stderr(&output));
    assert!(stdout(&output).contains("Every image is right, and every count its closed form."));
    let again = ["dfb.html", "dfb.json", "dfb.csv"].map(|name| fs::read(out.join(name)).unwrap());
    assert!(files == again);
}

/// How many elements of that name a page has.
fn elements(page: &[u8], name: &str) -> usize {
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let page = str::from_utf8(page).unwrap();
    let page = roxmltree::Document::parse_with_options(page, options).unwrap();
    page.descendants().filter(|node| node.has_tag_name(name)).count()
}

#[test]
fn what_is_asked_of_another_comparison_is_refused() {
    let folder = folder();
    let said = |args: &[&str]| {
        let output = pellucid(folder.path(), &[&["reproduce"], args].concat());
        assert_eq!(output.status.code(), Some(2));
        stderr(&output).to_string()
    };
    assert_eq!(
        said(&["tbuffer", "--full"]),
        "error: --full: is for `reproduce dfb`, `reproduce fbuffer` and `reproduce accumulation`; the others have one size and \
         leave no files\n"
    );
    assert_eq!(
        said(&["fbuffer", "--scene", "glass"]),
        "error: --scene: is for `reproduce dfb`; the others have scenes of their own\n"
    );
    assert_eq!(said(&["dfb", "--scene", "none.ply"]), "error: none.ply: no such file\n");
    assert!(said(&["dfb", "--scene", "glas"]).contains("did you mean `glass`?"));
    assert_eq!(
        said(&["dfb", "--scene", "quads-1-50"]),
        "error: --scene quads-1-50: expected a mesh, `glass`, `teapot` or `plant`, round which a camera can go\n"
    );
}

/// Windows and submissions from what a frame has, and the numbers that are printed.
#[test]
fn the_f_buffers_counts_come_out() {
    let folder = folder();
    let output = exact(pellucid(folder.path(), &["reproduce", "fbuffer", "--json", "--quiet"]));
    let json: Value = serde_json::from_str(stdout(&output)).unwrap();
    let number = |value: &Value| value.as_u64().unwrap();
    let mut printed = vec![];
    for frames in json["frames"].as_array().unwrap() {
        let vertices = match frames["scene"].as_str().unwrap() {
            "sphere-12288" => 12_288,
            "sphere-196608" => 196_608,
            _ => 6,
        };
        for run in frames["runs"].as_array().unwrap() {
            let places = number(&run["size"]).pow(2);
            let fragments = number(&run["fragments"]);
            let submissions = 3 * fragments.div_ceil(places);
            assert_eq!(number(&run["submissions"]["counted"]), submissions);
            assert_eq!(number(&run["vertices"]), vertices * submissions);
            assert_eq!(number(&run["shaded"]), 3 * fragments);
            assert_eq!(number(&run["bytes"]), 16 * number(&run["targets"]) * places);
            if let Some(n) = run["submissions"]["printed"].as_u64() {
                assert_eq!(n, submissions);
                printed.push(n);
            }
        }
    }
    assert_eq!(printed, [69, 489, 33, 33]);
    let page = fs::read(folder.path().join("pellucid-reproduce/fbuffer.html")).unwrap();
    // Figure 1's two pictures and Figure 2's five; the plots of Figure 4 and of sorts.
    assert_eq!((elements(&page, "img"), elements(&page, "svg")), (7, 2));

    // One fragment for each pixel, 64 x 64 of them in smaller buffers too.
    let mut sorts = vec![];
    for sort in json["sorts"].as_array().unwrap() {
        let [fragments, places] = [number(&sort["fragments"]), number(&sort["size"]).pow(2)];
        let windows = fragments.div_ceil(places).pow(2);
        assert_eq!(number(&sort["windows"]["counted"]), windows);
        assert_eq!(number(&sort["submissions"]), 1 + windows);
        let passes = number(&sort["sort_passes"]["counted"]);
        if windows == 1 {
            let k = u64::from(fragments.ilog2());
            assert_eq!(1 << k, fragments);
            assert_eq!(passes, k * (k + 1) / 2);
            let cycles = passes * (fragments / 8 + 1) + fragments + 2;
            assert_eq!(number(&sort["cycles"]["sort"]), cycles);
        }
        sorts.push((fragments, places, passes));
    }
    assert!(sorts.contains(&(65_536, 65_536, 136)));
    assert_eq!(sorts.iter().filter(|(fragments, ..)| *fragments == 4096).count(), 3);
    let wrong = |k: usize| number(&json["figure_1"][k]["wrong_pixels"]);
    assert_eq!(wrong(0), 0);
    assert!(wrong(1) > 0);
    let claims = json["claims"].as_array().unwrap();
    let not: Vec<&str> = claims
        .iter()
        .filter(|c| c["holds"] == false)
        .map(|c| c["claim"].as_str().unwrap())
        .collect();
    assert_eq!(
        not,
        ["Time is the larger of what vertices and what fragments take: within a tenth"]
    );
}

/// Passes, planes and bounds as the paper has them, from N and the inputs of a node.
#[test]
fn the_accumulation_trees_figures_come_out() {
    let folder = folder();
    let output =
        exact(pellucid(folder.path(), &["reproduce", "accumulation", "--json", "--quiet"]));
    let json: Value = serde_json::from_str(stdout(&output)).unwrap();
    let number = |value: &Value| value.as_u64().unwrap();
    let mut table = vec![];
    for frames in json["frames"].as_array().unwrap() {
        let n = number(&frames["frames"]);
        let run = |name: &str| {
            let runs = frames["runs"].as_array().unwrap();
            runs.iter().find(|run| run["method"] == name).cloned()
        };
        for (name, inputs) in [("tree 2", 2u64), ("tree 4", 4)] {
            let levels = u64::from(n.ilog(inputs));
            let Some(run) = run(name) else {
                assert!(
                    inputs == 4 && (4u64.pow(n.ilog(4)) != n || frames["figure"] == "Figure 3")
                );
                continue;
            };
            assert_eq!(number(&run["passes"]["counted"]), n + (n - 1) / (inputs - 1));
            assert_eq!(number(&run["planes"]["counted"]), (inputs - 1) * levels + 1);
            let lost = if inputs == 2 { 0.5 } else { 0.75 } * levels as f64;
            assert!(number(&run["error"]["counted"]) as f64 <= lost + 0.5, "{name}, {n}");
            assert_eq!(number(&run["error"]["bound"]), (lost + 0.5) as u64, "{name}, {n}");
        }
        if frames["figure"] == "Table 1" {
            table.push(n);
            // A sweep for each pass, and what is drawn before the first.
            let cycles = |name: &str| number(&run(name).unwrap()["cycles"]);
            let pixels = number(&frames["width"]) * number(&frames["height"]);
            assert!(cycles("tree 2") >= (2 * n - 1) * pixels && cycles("blend") >= n * pixels);
        } else {
            // Of 255 so much is left of equal frames; the background is the brightest that all of its channels are.
            let black = run("blend").unwrap();
            let background = 0xf4;
            assert!(number(&black["error"]["counted"]) >= background - n * (background / n));
            assert_eq!(number(&run("buffer").unwrap()["error"]["counted"]), 0);
        }
    }
    assert_eq!(table, [2, 4, 8, 16, 32, 64, 128, 256, 512, 1024]);
    let holds = |what: &str| {
        let claims = json["claims"].as_array().unwrap();
        claims.iter().find(|c| c["claim"].as_str().unwrap().contains(what)).unwrap()["holds"]
            .clone()
    };
    for claim in ["2 N", "textures", "more inputs are faster", "0.5 log2 N", "come out black"] {
        assert_eq!(holds(claim), true, "{claim}");
    }
    assert_eq!(holds("100 times"), false);
    let page = fs::read(folder.path().join("pellucid-reproduce/accumulation.html")).unwrap();
    // Figure 3 by three methods, a plot of cycles and two of errors.
    assert_eq!((elements(&page, "img"), elements(&page, "svg")), (9, 3));
}
