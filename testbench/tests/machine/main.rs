//! Every machine against the golden model, frame by frame.

mod failures;
mod frames;
mod mbuffer;
mod presets;
mod rbuffer;
mod tbuffer;

use pellucid_testbench::arch::ARCHITECTURES;
use presets::all_presets;
use std::path::Path;

fn everywhere(scene: &str) {
    ARCHITECTURES.iter().for_each(|arch| all_presets(arch.name, scene));
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
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/meshes/dragon_vrip_res4.ply.gz");
    if Path::new(mesh).exists() {
        everywhere(mesh);
    } else {
        println!("skipped: there is no file {mesh}");
    }
}
