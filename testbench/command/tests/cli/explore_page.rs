//! The page that a study leaves, in a browser.

use super::explore::{STUDY, explore, write};
use super::tools::have;
use super::*;
use pellucid_testbench::html::png_data;
use roxmltree::{Document, ParsingOptions};
use serde_json::json;

/// Points at a design, pins it, draws along an axis, sorts, filters, and says what is seen each time.
const USER: &str = r##"
const seen = {};
const all = (query) => [...document.querySelectorAll(query)];
const mouse = (type, at) => new MouseEvent(type, { bubbles: true, clientX: 50, clientY: at });
const machines = () => all("#designs tr").slice(1).map((row) => row.firstChild.textContent);
seen.dots = all("#scatter circle").length;
seen.front = all("#scatter circle.front").length;
const dot = all("#scatter circle.front")[0];
dot.dispatchEvent(mouse("mousemove", 50));
seen.tip = [getComputedStyle(document.getElementById("tip")).display, document.getElementById("tip").textContent];
dot.dispatchEvent(mouse("mouseleave", 50));
seen.gone = getComputedStyle(document.getElementById("tip")).display;
dot.dispatchEvent(mouse("click", 50));
seen.pinned = all("#pinned section h3").map((head) => head.textContent);
seen.images = all("#pinned img").map((image) => image.src);
seen.commands = all("#pinned pre").map((command) => command.textContent);
all("#pinned button")[0].click();
seen.unpinned = all("#pinned section").length;
document.getElementById("out").click();
seen.withOut = all("#scatter circle").length;
document.getElementById("out").click();
seen.sorted = machines();
const onChip = () => all("#designs th").find((head) => head.textContent.startsWith("storage.on_chip_bytes"));
onChip().click();
seen.bySize = machines();
onChip().click();
seen.bySizeDown = machines();
const filter = document.getElementById("filter");
filter.value = "dfb";
filter.dispatchEvent(new Event("input"));
seen.filtered = machines();
filter.value = "";
filter.dispatchEvent(new Event("input"));
const axes = all("#parallel svg text").map((text) => text.textContent);
seen.axes = axes;
const last = all("#parallel rect[cursor]").at(-1), box = last.getBoundingClientRect();
last.dispatchEvent(mouse("mousedown", box.bottom));
window.dispatchEvent(mouse("mouseup", box.bottom - box.height * 0.3));
seen.brushed = machines();
seen.effects = all("#effects svg").length;
document.body.replaceChildren();
document.body.setAttribute("data-seen", JSON.stringify(seen));
"##;

#[test]
fn a_browser_shows_fronts_and_designs() {
    if !have(&["chromium"]) {
        return;
    }
    let folder = folder();
    write(folder.path(), STUDY);
    exact(explore(folder.path(), &[]));
    let out = folder.path().join("pellucid-explore");
    let page = fs::read_to_string(out.join("explore.html")).unwrap();
    // A page is XML too, and needs nothing beside it.
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(&page, options).unwrap();
    assert!(!page.contains("src=") && !page.contains("@import"), "something is fetched");
    let page = page.replace("</body>", &format!("<script>{USER}</script></body>"));
    let path = folder.path().join("page.html");
    fs::write(&path, page).unwrap();
    let browser = Command::new("chromium")
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--window-size=1200,2000",
            "--dump-dom",
        ])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("file://{}", path.display()))
        .output()
        .unwrap();
    let dom = stdout(&browser);
    let seen = dom.split("data-seen=\"").nth(1).and_then(|rest| rest.split('"').next());
    let seen = seen.unwrap_or_else(|| panic!("the script has not ended: {dom}"));
    let seen: Value =
        serde_json::from_str(&seen.replace("&quot;", "\"").replace("&lt;", "<")).unwrap();

    let mut designs = designs(&out);
    let count = |of: &dyn Fn(&Design) -> bool| designs.iter().filter(|design| of(design)).count();
    assert_eq!(seen["dots"], count(&|design| design.inside), "{seen}");
    assert_eq!(seen["front"], count(&|design| design.front), "{seen}");
    assert_eq!(seen["withOut"], count(&|design| design.bytes.is_some()), "{seen}");
    let pinned = seen["pinned"][0].as_str().unwrap();
    let design = designs.iter().find(|design| design.front && design.name == pinned).unwrap();
    assert_eq!(seen["commands"], json!(design.commands));
    // With the image that each of its commands makes.
    let images = design.commands.iter().map(|command| {
        let words = command.as_str().unwrap().strip_prefix("pellucid ").unwrap();
        let words: Vec<&str> = words.split(' ').chain(["--no-wave", "--quiet"]).collect();
        exact(pellucid(folder.path(), &words));
        png_data(&fs::read(folder.path().join("pellucid-out/image.png")).unwrap())
    });
    assert_eq!(seen["images"], json!(images.collect::<Vec<_>>()));
    assert_eq!(seen["tip"][0], "block");
    let tip = seen["tip"][1].as_str().unwrap();
    let arch = pinned.split(':').next().unwrap();
    assert!(tip.starts_with(arch) && tip.contains("cycles.total"), "{tip}");
    assert_eq!((&seen["gone"], &seen["unpinned"]), (&json!("none"), &json!(0)));
    // What was not run has no figure, and stands at the end.
    let names = |designs: &[Design]| json!(designs.iter().map(|d| &d.name).collect::<Vec<_>>());
    designs.sort_by_key(|design| (design.bytes.is_none(), design.bytes));
    assert_eq!(seen["bySize"], names(&designs));
    let brushed = designs.len();
    designs.sort_by_key(|design| std::cmp::Reverse(design.bytes));
    assert_eq!(seen["bySizeDown"], names(&designs));
    designs.retain(|design| design.name.starts_with("dfb"));
    assert_eq!(seen["filtered"], names(&designs));
    let axes = seen["axes"].to_string();
    assert!(axes.contains("section_capacity") && !axes.contains("outside_latency"), "{axes}");
    let left = seen["brushed"].as_array().unwrap().len();
    assert!(0 < left && left < brushed, "{seen}");
    assert!(seen["effects"].as_u64() > Some(2), "{seen}");
}

/// What the rows of the study say of a design.
struct Design {
    name: String,
    /// The most of all scenes, if all were run.
    bytes: Option<u64>,
    inside: bool,
    front: bool,
    commands: Vec<Value>,
}

fn designs(out: &Path) -> Vec<Design> {
    let text = fs::read_to_string(out.join("points.jsonl")).unwrap();
    let mut designs: Vec<Design> = vec![];
    for row in text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()) {
        let bytes = row["storage.on_chip_bytes"].as_u64();
        if designs.len() as u64 == row["design"].as_u64().unwrap() {
            let name = row["machine"].as_str().unwrap().to_string();
            let front = row["front"] == true;
            designs.push(Design { name, bytes, inside: true, front, commands: vec![] });
        }
        let design = designs.last_mut().unwrap();
        design.bytes = design.bytes.zip(bytes).map(|(a, b)| a.max(b));
        design.inside &= row["status"] == "right" && bytes.is_some_and(|bytes| bytes <= 1 << 20);
        design.commands.push(row["command"].clone());
    }
    designs
}
