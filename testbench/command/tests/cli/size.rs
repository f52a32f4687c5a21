//! `pellucid size`, and defaults that are as large as the frame needs.

use super::*;

/// Sizes a machine for the small frame; gives the file's text.
fn sized(folder: &Path, args: &[&str]) -> String {
    let output = exact(pellucid(folder, &[&["size", "--quiet"], &SMALL[..], args].concat()));
    stdout(&output).to_string()
}

/// A key's value in such a file.
#[track_caller]
fn value(text: &str, key: &str) -> u64 {
    let table: toml::Table = text.parse().unwrap();
    let table = toml::Value::Table(table);
    let found = key.split('.').try_fold(&table, |table, part| table.get(part));
    let number = found.and_then(toml::Value::as_integer);
    number.unwrap_or_else(|| panic!("{key} in {text}")).try_into().unwrap()
}

/// Fragments dropped by a run of the small frame with that file, and with these parameters over it.
fn dropped(folder: &Path, text: &str, args: &[&str]) -> u64 {
    fs::write(folder.join("sized.toml"), text).unwrap();
    run(folder, &[&["--config", "sized.toml", "--no-wave", "--allow-drops"], args].concat());
    stats(&folder.join("pellucid-out"))["fragments"]["dropped"].as_u64().unwrap()
}

#[test]
fn the_smallest_machine_drops_nothing_and_one_smaller_does() {
    let folder = folder();
    let cases = [
        ("tbuffer", &["sections"][..], "-p section_capacity=2"),
        ("mbuffer", &["overflow_sections"], "-p section_capacity=1"),
        ("accumulate", &["tbuffer.sections"], "-p tbuffer.section_capacity=2"),
        ("rbuffer", &["queue"], "-p overflow=outside"),
        ("dfb", &["fragments"], "-p overflow=drop"),
        ("ppll", &["pages"], "-p overflow=drop"),
        ("b3d", &["layers"], "-p overflow=drop"),
    ];
    for (arch, names, param) in cases {
        let param: Vec<&str> = param.split(' ').collect();
        let args = [&["--arch", arch, "--margin", "0"], &param[..]].concat();
        let text = sized(folder.path(), &args);
        assert_eq!(dropped(folder.path(), &text, &[]), 0, "{text}");
        for name in names {
            let less = format!("{name}={}", value(&text, name) - 1);
            assert!(dropped(folder.path(), &text, &["-p", &less]) > 0, "{less} of {text}");
        }
    }
}

#[test]
fn a_budget_parts_what_is_on_chip_from_what_is_outside() {
    let folder = folder();
    for (arch, name, outside, budget) in [
        ("tbuffer", "sections", "outside_sections", 22_000),
        ("mbuffer", "overflow_sections", "outside_sections", 37_500),
        ("rbuffer", "queue", "outside_queue", 22_000),
        ("dfb", "fragments", "outside_fragments", 24_000),
    ] {
        let args = ["--arch", arch];
        let whole = sized(folder.path(), &args);
        assert_eq!(value(&whole, outside), 0, "{whole}");
        let bound = budget.to_string();
        let part = sized(folder.path(), &[&args[..], &["--budget", &bound]].concat());
        let all = value(&part, name) + value(&part, outside);
        assert_eq!(all, value(&whole, name), "{part}");
        assert!(value(&part, outside) > 0, "{part}");
        let bytes = |more: &[&str]| {
            assert_eq!(dropped(folder.path(), &part, more), 0);
            stats(&folder.path().join("pellucid-out"))["storage"]["on_chip_bytes"].as_u64().unwrap()
        };
        assert!(bytes(&[]) <= budget, "{part}");
        let more = format!("{name}={}", value(&part, name) + 1);
        let less = format!("{outside}={}", value(&part, outside) - 1);
        assert!(bytes(&["-p", &more, "-p", &less]) > budget, "{part}");
    }
}

/// A DRAM has something in it, a machine of few sections need not be larger, and one that needs none has none.
#[test]
fn what_goes_with_few_sections_is_sized() {
    let folder = folder();
    let budget = ["--budget", "24000", "-p", "outside=ddr4-3200"];
    assert!(value(&sized(folder.path(), &budget), "outside_sections") > 0);
    let text = sized(folder.path(), &["-p", "allocator=bitmap"]);
    assert_eq!(dropped(folder.path(), &text, &[]), 0, "{text}");
    let one_layer = ["--arch", "mbuffer", "--scene", "quads-1-50"];
    assert_eq!(value(&sized(folder.path(), &one_layer), "overflow_sections"), 0);
}

/// What the fullest frame of a walk takes, of all scenes.
#[test]
fn all_frames_of_all_scenes_count() {
    let folder = folder();
    let sections = |args: &[&str]| {
        let args = [&["--margin", "0"], args].concat();
        value(&sized(folder.path(), &args), "sections")
    };
    let [glass, smoke] = ["glass", "smoke"].map(|scene| sections(&["--scene", scene]));
    assert_ne!(glass, smoke);
    assert_eq!(sections(&["--scene", "glass", "--scene", "smoke"]), glass.max(smoke));
    let walk = ["--frames", "3", "--path", "zoom"];
    let text = sized(folder.path(), &[&["--margin", "0"], &walk[..]].concat());
    let peak = |args: &[&str]| {
        exact(run(folder.path(), &[args, &["--no-wave"]].concat()));
        let stats = stats(&folder.path().join("pellucid-out"));
        stats["tbuffer"]["peak_sections"].as_u64().unwrap()
    };
    assert_eq!(peak(&walk), value(&text, "sections"));
    // By default there is a tenth more.
    let roomy = value(&sized(folder.path(), &[]), "sections");
    assert_eq!(roomy, (glass * 11).div_ceil(10));
}

#[test]
fn what_cannot_be_sized_is_said() {
    let folder = folder();
    let size = |args: &[&'static str]| [&["size", "--quiet"], &SMALL[..], args].concat();
    refused(
        folder.path(),
        &size(&["--arch", "fbuffer"]),
        "`fbuffer` has no parameter that says how much of a frame it holds: there is nothing to size",
    );
    refused(
        folder.path(),
        &size(&["-p", "sections=9"]),
        "-p sections=9: `sections` is what is looked for here, leave it out",
    );
    let output = pellucid(folder.path(), &size(&["--budget", "1k"]));
    let said = stderr(&output);
    assert!(
        said.starts_with("error: --budget 1,000: with `sections=1` the machine has "),
        "{said}"
    );
    // A cache of that size is larger than the table.
    assert!(said.ends_with("`front.display.frame_buffer.colour_a` 3,600\n"), "{said}");
    let few = ["--budget", "1k", "-p", "ssa_sets=4"];
    let said = stderr(&pellucid(folder.path(), &size(&few)));
    assert!(said.ends_with("; `-p ssa=cached` has less there\n"), "{said}");
    let output = pellucid(folder.path(), &size(&["--budget", "much"]));
    assert!(stderr(&output).contains("expected bytes, and perhaps KiB, "), "{}", stderr(&output));
}

/// Where nobody says how large memory outside is, no frame is too large for it.
/// Planes on the chip are part of a budget, and it is said that they could lie outside; the frames of an image are those of `-p frames`.
#[test]
fn planes_of_an_accumulated_image_are_sized() {
    let folder = folder();
    let args = ["--arch", "accumulate", "-p", "frames=4"];
    let few = [&["size", "--quiet"], &SMALL[..], &args, &["--budget", "1k"]].concat();
    let output = pellucid(folder.path(), &few);
    assert!(
        stderr(&output).contains("; `-p planes=outside` has less there"),
        "{}",
        stderr(&output)
    );
    let text = sized(folder.path(), &[&args[..], &["-p", "planes=outside"]].concat());
    assert!(text.contains("planes = \"outside\""), "{text}");
    assert_eq!(dropped(folder.path(), &text, &[]), 0, "{text}");
}

#[test]
fn what_lies_outside_is_as_large_as_the_frame_needs() {
    let folder = folder();
    // 1,310,720 sections of one fragment each are there if nothing is known of the frame.
    let screen = ["--width", "840", "--height", "840", "--scene", "quads-2-100", "--no-wave"];
    let args = [&["run"], &screen[..], &["-p", "section_capacity=1"]].concat();
    exact(pellucid(folder.path(), &args));
    let stats = stats(&folder.path().join("pellucid-out"));
    assert_eq!(stats["tbuffer"]["peak_sections"], 2 * 840 * 840);
    assert_eq!(stats["config"]["outside_sections"], 2 * 840 * 840 - 262_144);
}
