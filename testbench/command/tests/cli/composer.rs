//! The image composition machine.

use super::*;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

const COMPOSER: [&str; 2] = ["--arch", "composer"];

/// The pixel of an image in the middle.
fn middle(path: &Path) -> [u8; 3] {
    let file = std::io::BufReader::new(fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let at = (info.height / 2 * info.width + info.width / 2) as usize * 3;
    [pixels[at], pixels[at + 1], pixels[at + 2]]
}

/// Seed 001, figure 7: 128 of 255 of yellow over blue. The T-buffer says the same.
#[test]
fn where_the_panes_meet_yellow_over_blue_is_green() {
    let folder = folder();
    for arch in ["composer", "tbuffer"] {
        let args = ["--arch", arch, "--scene", "panes", "--out", arch, "--no-wave", "--quiet"];
        exact(run(folder.path(), &args));
        assert_eq!(middle(&folder.path().join(arch).join("image.png")), [128, 128, 127]);
    }
}

/// Red at an alpha of 128, from the one texel of a texture, over the backdrop 244, 241, 234: (128 * 255 + 127 * 244) / 255
/// and so on. To triangles an engine knows no texture: it gets fragments.
#[test]
fn a_texture_looks_the_same_to_every_machine() {
    const PNG: &str = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGP4z8DQAAAEgQGALFXOsAAAAABJRU5Er\
                       kJggg==";
    let folder = folder();
    let corners = [-9.0f32, -9.0, 0.0, 9.0, -9.0, 0.0, 0.0, 9.0, 0.0];
    let mut data = corners.map(f32::to_le_bytes).concat();
    data.resize(60, 0);
    let mesh = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],
        "materials":[{{"alphaMode":"BLEND","extensions":{{"KHR_materials_unlit":{{}}}},
            "pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}],
        "textures":[{{"source":0}}],"images":[{{"uri":"data:image/png;base64,{PNG}"}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
                     {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}}],
        "buffers":[{{"uri":"data:;base64,{}","byteLength":60}}]}}"#,
        STANDARD.encode(data)
    );
    fs::write(folder.path().join("a.gltf"), mesh).unwrap();
    for arch in ["composer", "tbuffer"] {
        let args = ["--arch", arch, "--scene", "a.gltf", "--out", arch, "--no-wave", "--quiet"];
        exact(run(folder.path(), &args));
        assert_eq!(middle(&folder.path().join(arch).join("image.png")), [250, 120, 117]);
    }
}

#[test]
fn what_is_counted_is_in_the_statistics() {
    let folder = folder();
    let set = ["-p", "engines=5", "-p", "beta=7", "-p", "scan_line_engines=3"];
    exact(run(folder.path(), &[&COMPOSER[..], &set, &["--no-wave", "--quiet"]].concat()));
    let stats = stats(&folder.path().join("pellucid-out"));
    assert_eq!(stats["cycles"]["merge"], (40 + 7) * 30 + 4 * 5);
    assert_eq!(stats["composer"]["first_line"], 40 + 7 + 4 * 5);
    assert_eq!(stats["composer"]["last_line"], 40 + 7);
    let engines = stats["memories"].as_array().unwrap();
    let local = engines.iter().find(|m| m["name"] == "merger.engines.local.depth_a").unwrap();
    assert_eq!(local["words"], 5 * 1200);
}

/// Three frames are in flight: a further one takes as long as the longer of drawing and composing.
#[test]
fn frames_overlap() {
    let folder = folder();
    let total = |frames: &str| {
        let args =
            ["--scene", "glass", "--frames", frames, "--no-wave", "--quiet", "--out", frames];
        exact(run(folder.path(), &[&COMPOSER[..], &args].concat()));
        let stats = stats(&folder.path().join(frames));
        ["total", "draw", "compose"].map(|name| stats["cycles"][name].as_u64().unwrap())
    };
    let [one, ..] = total("1");
    let [all, draw, compose] = total("6");
    assert!(all < 6 * one, "{all} cycles for six frames, {one} for one");
    assert!(all < draw + compose, "{all} cycles, {draw} of drawing and {compose} of composing");
}

#[test]
fn bad_parameters_are_refused() {
    let folder = folder();
    let message = |args: &[&str], message: &str| {
        refused(folder.path(), &[&["run"], &SMALL[..], &COMPOSER, args].concat(), message);
    };
    message(
        &["-p", "engines=0"],
        "-p engines=0: parameter `engines` is `0`: expected a whole number from 1 to 1024",
    );
    message(
        &["-p", "scan_line_engines=31"],
        "parameter `scan_line_engines` is 31: expected at most 30, the rows of the screen",
    );
    message(
        &["-p", "distribution=are"],
        "-p distribution=are: parameter `distribution` is `are`: expected `round_robin` or `area`",
    );
}

/// What finds no place is told of, and nothing else is wrong.
#[test]
fn primitives_without_a_place_are_counted() {
    let folder = folder();
    for few in ["primitives=40", "line_primitives=3"] {
        let output = run(folder.path(), &[&COMPOSER[..], &["-p", few, "--no-wave"]].concat());
        assert_eq!(output.status.code(), Some(1));
        let text = stderr(&output);
        assert!(
            text.contains(" fragments were dropped, a frame or a line had too many primitives"),
            "{text}"
        );
        assert_eq!(text.lines().count(), 1, "{text}");
    }
}

/// The stores that can stand behind the merger give the image and counts that they should, frame by frame.
#[test]
fn a_fragment_store_behind_the_merger() {
    let folder = folder();
    let shared = ["--frames", "2", "--no-wave", "--quiet", "--out"];
    for (store, memory) in [
        ("tbuffer", "transparency.store.chains.sections.on_chip"),
        ("rbuffer", "transparency.store.queue.on_chip"),
        ("mbuffer", "transparency.store.chains.sections.on_chip"),
    ] {
        let args = ["-p", &format!("transparency={store}")];
        exact(run(folder.path(), &[&COMPOSER[..], &args, &shared, &[store]].concat()));
        let stats = stats(&folder.path().join(store));
        assert_eq!(stats["cycles"]["merge"], 2 * ((40 + 20) * 30 + 4 * 16));
        // Each is written once for each fragment that is stored, at least.
        let memories = stats["memories"].as_array().unwrap();
        let writes =
            |name| memories.iter().find(|m| m["name"] == name).map(|m| m["writes"].as_u64());
        let stored = stats["fragments"]["stored"].as_u64().unwrap();
        assert!(stored > 0 && writes(memory).flatten() >= Some(stored), "{store}");
        assert_eq!(writes("transparency.engines.lines"), None);
    }
}

#[test]
fn a_store_has_its_own_parameters() {
    let folder = folder();
    let replay = "transparency = \"rbuffer\"\n[rbuffer]\nqueue = 40\noverflow = \"replay\"\n";
    fs::write(folder.path().join("store.toml"), replay).unwrap();
    let args = ["--config", "store.toml", "-p", "rbuffer.queue=50", "--no-wave", "--quiet"];
    exact(run(folder.path(), &[&COMPOSER[..], &args].concat()));
    let stats = stats(&folder.path().join("pellucid-out"));
    assert_eq!(stats["config"]["rbuffer.queue"], 50);
    assert!(stats["composer"]["rounds"].as_u64() > Some(1));
    // What does not fit is sent again from the primitives that the machine holds.
    assert!(stats["composer"]["replayed"].as_u64() > Some(0));

    let message = |args: &[&str], message: &str| {
        refused(folder.path(), &[&["run"], &SMALL[..], &COMPOSER, args].concat(), message);
    };
    message(
        &["-p", "tbuffer.sections=0"],
        "-p tbuffer.sections=0: parameter `tbuffer.sections` is `0`: expected a whole number from 1 to 268435456",
    );
    message(
        &["-p", "transparency=tbuffer", "-p", "tbuffer.allocator=bitmap"],
        "parameter `tbuffer.sections` is 262144: expected at most 4096 with `tbuffer.allocator=bitmap`",
    );
    message(
        &["-p", "transparency=dfb"],
        "-p transparency=dfb: parameter `transparency` is `dfb`: expected `scanline`, `tbuffer`, `rbuffer` or `mbuffer`",
    );
}

#[test]
fn a_store_tells_what_it_lost() {
    let folder = folder();
    let lossy = |few: &str, said: &str| {
        let args = ["-p", "transparency=tbuffer", "-p", few, "-p", "tbuffer.outside_sections=0"];
        let output = run(folder.path(), &[&COMPOSER[..], &args, &["--no-wave"]].concat());
        assert_eq!(output.status.code(), Some(1));
        let text = stderr(&output);
        assert!(text.contains(&format!(" fragments were dropped, {said}")), "{text}");
        assert_eq!(text.lines().count(), 1, "{text}");
    };
    lossy("primitives=40", "a frame had too many transparent primitives (see `primitives`)");
    lossy("tbuffer.sections=7", "no section was free");
}

/// A frame of a trace, in a file of that name.
fn trace(folder: &Path, name: &str, size: [u32; 2], fragments: &str) {
    let [width, height] = size;
    let header = format!("# pellucid-trace width={width} height={height} background=1,2,3\n");
    fs::write(folder.join(name), format!("{header}x,y,z,r,g,b,a\n{fragments}")).unwrap();
}

/// With next to nothing to do, merging takes the overhead of its last line all the same.
#[test]
fn a_frame_of_next_to_nothing_is_merged_to_its_end() {
    let folder = folder();
    let (empty, one) = ("", "0,0,5,9,8,7,100\n");
    for (name, size, fragments) in
        [("a.csv", [1, 1], empty), ("b.csv", [1, 1], one), ("c.csv", [37, 3], empty)]
    {
        trace(folder.path(), name, size, fragments);
        for store in ["scanline", "tbuffer", "rbuffer", "mbuffer"] {
            for beta in [0, 20, 1023] {
                let set = [format!("transparency={store}"), format!("beta={beta}")];
                let set = ["-p", &set[0], "-p", &set[1], "-p", "engines=1", "-p", "primitives=1"];
                let args = [&["--scene", name, "--no-wave", "--quiet"][..], &COMPOSER, &set];
                exact(pellucid(folder.path(), &args.concat()));
                let stats = stats(&folder.path().join("pellucid-out"));
                let [width, height] = size;
                assert_eq!(stats["cycles"]["merge"], (width + beta) * height + 4, "{set:?}");
            }
        }
    }
}

/// What lies at the far plane is never seen, and counted by all alike.
#[test]
fn fragments_at_the_far_plane_are_counted() {
    let folder = folder();
    let far = "0,0,16777215,9,8,7,100\n1,0,16777215,9,8,7,255\n1,0,16777214,9,8,7,100\n";
    trace(folder.path(), "far.csv", [2, 1], far);
    let machines: [&[&str]; 5] = [
        &["--arch", "tbuffer"],
        &["--arch", "rbuffer"],
        &["--arch", "mbuffer"],
        &["--arch", "composer"],
        &["--arch", "composer", "-p", "transparency=tbuffer"],
    ];
    for machine in machines {
        let args = [&["--scene", "far.csv", "--no-wave", "--quiet"], machine].concat();
        exact(pellucid(folder.path(), &args));
        let stats = stats(&folder.path().join("pellucid-out"));
        let counted = |group: &str, names: &[&str]| -> Vec<u64> {
            names.iter().map(|name| stats[group][name].as_u64().unwrap()).collect()
        };
        assert_eq!(counted("frame", &["fragments", "opaque", "transparent"]), [3, 1, 2]);
        let names = ["drawn", "hidden", "stored", "culled", "blended"];
        assert_eq!(counted("fragments", &names), [0, 1, 1, 1, 1], "{machine:?}");
    }
}

/// Four million primitives in each of many engines.
#[test]
#[cfg(unix)]
fn memories_that_find_no_room_are_refused() {
    let folder = folder();
    let set = "-p primitives=4194304 -p line_primitives=1048576 -p scan_line_engines=30";
    for command in ["run --no-wave", "export"] {
        let line = format!(
            "ulimit -v 2000000; exec {} {command} --width 40 --height 30 --arch composer {set}",
            env!("CARGO_BIN_EXE_pellucid")
        );
        let output = Command::new("sh").args(["-c", &line]).current_dir(&folder).output().unwrap();
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        let said = "error: the machine's memories find no room in this computer: `";
        assert!(text.starts_with(said) && text.lines().count() == 1, "{text}");
    }
}
