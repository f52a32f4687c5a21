//! Every preset of every machine against the golden model, on scenes.

use pellucid_hw::{ARCHITECTURES, architecture};
use pellucid_machine::params::Value;
use pellucid_machine_properties::presets::all_presets;
use pellucid_testbench::scene::{Options, built_in};
use pellucid_testbench::source::{Source, SourceError};
use std::path::Path;

fn everywhere(scene: &str) {
    ARCHITECTURES.iter().for_each(|arch| all_presets(arch, scene));
}

#[test]
fn presets_are_right_on_glass() {
    everywhere("glass");
}

#[test]
fn presets_are_right_on_the_teapot() {
    everywhere("teapot");
}

#[test]
fn presets_are_right_on_a_scanned_mesh() {
    let mesh =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/meshes/dragon_vrip_res4.ply.gz");
    if Path::new(mesh).exists() {
        everywhere(mesh);
    } else {
        println!("skipped: there is no file {mesh}");
    }
}

/// What its presets have room for, and what the built-in scenes need of it: each transparent primitive has a place in the frame and one on each of its lines.
/// `plant` is deeper than they are sure to hold.
#[test]
fn the_composers_presets_have_room_for_every_built_in_scene_but_plant() {
    let composer = architecture("composer").unwrap();
    for scene in built_in().iter().filter(|scene| scene.name != "plant") {
        let source = Source::open(scene.example, &Options::default()).unwrap();
        let screen = source.screen();
        let (mut primitives, mut lines) = (0_u32, vec![0_u32; screen.height as usize]);
        let played = source.play_primitives::<SourceError>(&mut |primitive| {
            if !primitive.opaque {
                primitives += 1;
                let rows = primitive.row as usize..=primitive.last_row as usize;
                lines[rows].iter_mut().for_each(|line| *line += 1);
            }
            Ok(())
        });
        played.unwrap();
        let line_primitives = lines.into_iter().max().unwrap();
        for (preset, _) in (composer.presets)() {
            let values = composer.build(screen, Some(preset), &[]).unwrap().values();
            for (name, needed) in [("primitives", primitives), ("line_primitives", line_primitives)]
            {
                let value = values.iter().find(|(of, _)| of == name).map(|(_, value)| value);
                assert!(
                    matches!(value, Some(Value::Number(room)) if *room >= needed),
                    "{}, {preset}: {name} is {value:?}, {needed} are needed",
                    scene.name
                );
            }
        }
    }
}
