//! The page that a comparison leaves.

use super::compare::{FIGURES, MACHINES, compare, json};
use super::*;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use roxmltree::{Document, ParsingOptions};
use std::io::Cursor;

/// What keeps a page with many machines readable: names that are not broken, a table that scrolls within the window,
/// with its heads in sight.
const STYLE: [&str; 3] = [
    ".name { white-space: nowrap; }",
    "#figures tr:first-child th { background: white; position: sticky; top: 0;",
    ".wide { left: 50%; max-height: 90vh; max-width: 96vw; overflow: auto;",
];

/// A machine that deals what is opaque to engines has an order of its own: what differs for it is told apart from what is
/// wrong.
#[test]
fn a_caption_tells_what_is_wrong_from_what_is_seen_otherwise() {
    let folder = folder();
    // The second and the third are equally deep; the third goes to the same engine as the first.
    let trace = "# pellucid-trace width=2 height=1 background=0,0,0\nx,y,z,r,g,b,a\n\
                 0,0,5,200,0,0,255\n1,0,5,0,200,0,255\n1,0,5,0,0,200,255\n";
    fs::write(folder.path().join("equal.csv"), trace).unwrap();
    let composer = "composer:vc1,engines=2";
    let args = ["compare", "--machine", "tbuffer", "--machine", composer, "--scene", "equal.csv"];
    exact(pellucid(folder.path(), &[&args[..], &["--quiet"]].concat()));
    let out = folder.path().join("pellucid-compare");
    let machines = json(&out)["scenes"][0]["machines"].clone();
    assert_eq!(machines[1]["image"]["mismatched_pixels"], 0);
    let page = fs::read_to_string(out.join("compare.html")).unwrap();
    let caption = format!(
        "The image by {composer}: 0 pixels differ from the exact blend of the fragments as this machine orders them; 1 \
         from the image above."
    );
    assert!(page.contains(&caption));
}

/// A floor and a wall in strong perspective, with a colour and an alpha of its own at each corner.
#[test]
fn machines_of_fragments_and_of_primitives_give_one_image_in_perspective() {
    let folder = folder();
    let mesh = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
                property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
                element face 2\nproperty list uchar int vertex_indices\nend_header\n\
                -40 -1 0.5 255 0 0 255\n40 -1 0.5 0 255 0 255\n40 -1 -80 0 0 255 255\n-40 -1 -80 255 255 255 255\n\
                -3 -0.5 0 255 0 0 255\n5 -0.5 -1 0 255 0 40\n3 3 -40 0 0 255 0\n-20 2 -40 255 255 0 200\n\
                4 0 1 2 3\n4 4 5 6 7\n";
    fs::write(folder.path().join("floor.ply"), mesh).unwrap();
    let machines = ["--machine", "tbuffer", "--machine", "rbuffer", "--machine", "composer"];
    let view = ["--camera", "0,0,1:0,-0.2,-4:60", "--width", "80", "--height", "60", "--quiet"];
    let args = [&["compare", "--scene", "floor.ply"], &machines[..], &view].concat();
    exact(pellucid(folder.path(), &args));
    let page = fs::read_to_string(folder.path().join("pellucid-compare/compare.html")).unwrap();
    let names = "tbuffer:fast; rbuffer:on-chip; composer:vc1.";
    assert!(page.contains(&format!("The same image, bit for bit, came from: {names}<")));
    assert!(!page.contains("pixels differ"));
}

/// Those that take triangles have their own order, and say so.
#[test]
fn machines_of_fragments_and_of_primitives_give_one_image_in_any_order() {
    let folder = folder();
    let machines = ["--machine", "tbuffer", "--machine", "composer", "--order", "morton"];
    let frame = ["--scene", "glass", "--width", "80", "--height", "60", "--quiet"];
    let output = pellucid(folder.path(), &[&["compare"], &machines[..], &frame].concat());
    let note = "composer:vc1 goes through triangles itself, row by row: --order morton is for other machines";
    assert_eq!(stderr(&output), format!("note: {note}\n"));
    assert_eq!(output.status.code(), Some(0));
    let page = fs::read_to_string(folder.path().join("pellucid-compare/compare.html")).unwrap();
    let names = "tbuffer:fast; composer:vc1.";
    assert!(page.contains(&format!("The same image, bit for bit, came from: {names}<")));
}

/// Said once, and of machines that count vertices alone.
#[test]
fn a_trace_has_no_vertices() {
    let folder = folder();
    let trace = "# pellucid-trace width=2 height=1 background=0,0,0\nx,y,z,r,g,b,a\n\
                 0,0,5,9,9,9,100\n1,0,7,9,9,9,100\n";
    fs::write(folder.path().join("two.csv"), trace).unwrap();
    let note = "note: `two.csv` is a trace and has no vertices: each of its fragments counts as a point of three\n";
    let said = |args: &[&str]| {
        let output = pellucid(folder.path(), args);
        assert_eq!(output.status.code(), Some(0));
        (stderr(&output), output)
    };
    let run = |arch| said(&["run", "--scene", "two.csv", "--arch", arch, "--json"]);
    let (of_run, output) = run("fbuffer");
    assert_eq!(of_run, note);
    let json: Value = serde_json::from_str(stdout(&output)).unwrap();
    // Two points, three passes of `glass`.
    assert_eq!(json["fbuffer"]["vertices"], 2 * 3 * 3);
    assert_eq!(run("composer").0, "");
    let machines =
        ["--machine", "fbuffer:x800", "--machine", "fbuffer:r9800", "--machine", "tbuffer"];
    let compare = [&["compare", "--scene", "two.csv", "--quiet"], &machines[..]].concat();
    assert_eq!(said(&compare).0, note);
}

/// The colours of an embedded PNG, three bytes a pixel, and its size.
fn pixels(uri: &str) -> (u32, u32, Vec<u8>) {
    let data = uri.strip_prefix("data:image/png;base64,").unwrap();
    let bytes = STANDARD.decode(data).unwrap();
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width, info.height, pixels)
}

#[test]
fn the_page_is_whole_and_shows_everything() {
    let folder = folder();
    // Three pixels: none, one and two layers.
    let trace = "# pellucid-trace width=3 height=1 background=0,0,0\nx,y,z,r,g,b,a\n\
                 1,0,5,200,0,0,128\n2,0,5,0,200,0,128\n2,0,6,0,0,200,128\n";
    fs::write(folder.path().join("a&b<c>.csv"), trace).unwrap();
    let args = ["--machine", MACHINES[0].0, "--machine", MACHINES[1].0, "--scene", "a&b<c>.csv"];
    exact(pellucid(folder.path(), &[&["compare", "-q"], &args[..]].concat()));
    let source = fs::read_to_string(folder.path().join("pellucid-compare/compare.html")).unwrap();
    assert!(!source.contains("http"), "a page that stands alone");
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let page = Document::parse_with_options(&source, options).unwrap();
    let all = |tag: &'static str| page.descendants().filter(move |node| node.has_tag_name(tag));
    let texts = |tag| all(tag).filter_map(|node| node.text()).collect::<Vec<_>>();

    assert_eq!(texts("title"), ["Pellucid: machines compared"]);
    assert_eq!(
        texts("pre"),
        ["pellucid compare --machine tbuffer:fast,section_capacity=2 --machine tbuffer:paper \
          --scene 'a&b<c>.csv'"]
    );
    assert!(texts("h2").contains(&"Scene a&b<c>.csv"));
    // A setting a line, none of them broken.
    let heads = all("th").filter(|th| th.attribute("class") == Some("machine"));
    let heads: Vec<Vec<&str>> = heads
        .map(|th| th.descendants().filter(|n| n.is_text()).filter_map(|n| n.text()).collect())
        .collect();
    assert_eq!(heads, [vec!["tbuffer:fast,", "section_capacity=2"], vec!["tbuffer:paper"]]);
    assert!(STYLE.iter().all(|rule| source.contains(rule)));
    let json = json(&folder.path().join("pellucid-compare"));
    let value = |machine: usize, figure: &str| {
        let (group, name) = figure.split_once('.').unwrap();
        json["scenes"][0]["machines"][machine][group][name].clone()
    };
    let folded = |node: &roxmltree::Node| node.ancestors().any(|n| n.has_tag_name("details"));
    for figure in FIGURES {
        let label = match figure {
            "accesses.seed" => "accesses as the paper counts",
            "storage.seed_bytes" => "storage as the paper counts",
            "storage.seed_bytes_used" => "storage as the paper counts, in use",
            figure => figure,
        };
        let row = all("tr").find(|tr| tr.first_element_child().unwrap().text() == Some(label));
        let row = row.unwrap();
        let cells = row.children().filter_map(|cell| cell.text());
        let cells: Vec<String> = cells.map(|text| text.trim().replace(',', "")).collect();
        let values = [0, 1].map(|machine| value(machine, figure).to_string());
        // What is equal everywhere is said once, and folded.
        let equal = values[0] == values[1];
        assert_eq!(folded(&row), equal, "{figure}");
        let cells: Vec<&String> = cells.iter().skip(1).filter(|text| !text.is_empty()).collect();
        assert_eq!(cells, values.iter().take(if equal { 1 } else { 2 }).collect::<Vec<_>>());
    }
    assert_eq!(all("details").count(), 1);
    // Every figure has a caption; nine plots of figures and the histogram.
    assert_eq!(all("figure").count(), all("figcaption").count());
    assert_eq!(all("svg").count(), 10);
    let plotted = [
        "storage.seed_bytes",
        "storage.seed_bytes_used",
        "accesses.seed",
        "accesses.full",
        "cycles.total",
        "time.frame",
        "energy.total",
        "energy.on_chip",
        "area.memories",
    ];
    let mut plots = all("svg").map(|svg| {
        let bars = svg.descendants().filter(|node| node.has_tag_name("rect"));
        bars.map(|bar| bar.attribute("height").unwrap().parse().unwrap()).collect::<Vec<f64>>()
    });
    for figure in plotted {
        let bars = plots.next().unwrap();
        let values = [0, 1].map(|machine| value(machine, figure).as_f64().unwrap());
        let (low, high) = if values[0] <= values[1] { (0, 1) } else { (1, 0) };
        // Heights are whole pixels; the higher bar has some 240 of them.
        let (bar, figures) = (bars[low] / bars[high], values[low] / values[high]);
        assert!((bar - figures).abs() < 0.02, "{figure}: {bars:?}");
        assert_eq!(bars.len(), 2);
    }
    // One pixel with a layer, one with two.
    let bars = plots.next().unwrap();
    assert!(bars.len() == 2 && bars[0] == bars[1], "{bars:?}");
    let labels = texts("text");
    assert_eq!(labels.iter().filter(|text| text.trim() == "a&b<c>.csv").count(), 9);
    let images: Vec<_> = all("img").map(|img| pixels(img.attribute("src").unwrap())).collect();
    // (128 * 200 + 127 * 0) / 255 is 100; over it, for the third pixel, blue 127 / 255 * 100 is 50.
    assert_eq!(images[0], (3, 1, vec![0, 0, 0, 100, 0, 0, 0, 100, 50]));
    // White for none, then the two ends of the scale.
    let heat = vec![255, 255, 255, 0x44, 0x01, 0x54, 0xfd, 0xe7, 0x25];
    assert_eq!(images[1..], [(3, 1, heat)]);
}

/// The curves of a page: of each plot that has some its caption, and how many points each line has.
fn curves(page: &str) -> Vec<(String, Vec<usize>)> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(page, options).unwrap();
    let named = |tag| document.descendants().filter(move |node| node.has_tag_name(tag));
    let curve = |figure: roxmltree::Node| {
        let inside = |tag| figure.descendants().filter(move |node| node.has_tag_name(tag));
        // Axes are lines of two points, without circles.
        let colours: Vec<&str> = inside("circle").filter_map(|c| c.attribute("fill")).collect();
        let mut lines: Vec<&str> = colours.clone();
        lines.dedup();
        let points = |line: &&str| colours.iter().filter(|colour| *colour == line).count();
        let caption = inside("figcaption").next()?.text()?.to_string();
        (!lines.is_empty()).then(|| (caption, lines.iter().map(points).collect()))
    };
    named("figure").filter_map(curve).collect()
}

#[test]
fn machines_that_differ_by_a_number_are_drawn_over_it() {
    let folder = folder();
    let machines = ["composer,engines=4", "composer,engines=1", "composer,engines=2"];
    let args: Vec<&str> = machines.iter().flat_map(|machine| ["--machine", machine]).collect();
    exact(compare(folder.path(), &[&args[..], &["--quiet"]].concat()));
    let out = folder.path().join("pellucid-compare");
    let page = fs::read_to_string(out.join("compare.html")).unwrap();
    assert!(page.contains("<h2>Scene glass over engines</h2>"));
    // Total, and what the image composition machine counts: draw, merge, compose.
    assert_eq!(
        curves(&page),
        [
            ("Speed-up: cycles with engines=1, over cycles.".to_string(), vec![3; 4]),
            (
                "Load balance: the mean work of an engine, over that of the busiest one."
                    .to_string(),
                vec![3; 2]
            ),
        ]
    );
    // Figures that only this architecture has are compared too.
    let json = json(&out);
    let draw = |k: usize| json["scenes"][0]["machines"][k]["cycles"]["draw"].as_u64().unwrap();
    assert!(draw(1) > draw(2) && draw(2) > draw(0));
}

/// Figures that not all machines have are left out, and there is nothing to draw over.
#[test]
fn the_merger_with_what_can_stand_behind_it() {
    let folder = folder();
    let machines = ["composer", "composer,transparency=tbuffer"];
    let args: Vec<&str> = machines.iter().flat_map(|machine| ["--machine", machine]).collect();
    exact(compare(folder.path(), &[&args[..], &["--quiet"]].concat()));
    let out = folder.path().join("pellucid-compare");
    let machines = json(&out)["scenes"][0]["machines"].clone();
    for (k, own) in ["scan_line_work", "peak_sections"].iter().enumerate() {
        let single =
            ["--arch", "composer", "-p", &format!("transparency={}", ["scanline", "tbuffer"][k])];
        exact(run(folder.path(), &[&single[..], &["--out", "run", "--no-wave", "-q"]].concat()));
        let single = stats(&folder.path().join("run"));
        assert!(single["composer"][own].is_u64() && machines[k]["composer"][own].is_null());
        assert_eq!(machines[k]["composer"]["engine_work"], single["composer"]["engine_work"]);
    }
    assert_eq!(curves(&fs::read_to_string(out.join("compare.html")).unwrap()), []);
}
