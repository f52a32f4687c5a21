//! The models that Assimp is tested with, as Debian's package `assimp-testmodels` installs them: each plays, or is refused
//! with the words that `assimp.txt` has for it.
//!
//! A line of the table is `plays FRAGMENTS IMAGE FILE`, where the image is the CRC-32 of its red, green and blue bytes row
//! by row, or `refused` or `note` and the sentence. With the environment variable `PELLUCID_UPDATE_ASSIMP=1` the table is
//! written anew, and the images beside the test's program: look at those that are others than before.

#[path = "../command/tests/tools/mod.rs"]
mod tools;

use flate2::Crc;
use pellucid_testbench::golden::Golden;
use pellucid_testbench::image::Image;
use pellucid_testbench::scene::{Options, Scene};
use std::convert::Infallible;
use std::fs;
use std::path::{Path, PathBuf};

const MODELS: &str = "/usr/share/assimp/models";
const EXTENSIONS: [&str; 4] = ["obj", "ply", "gltf", "glb"];

#[test]
fn every_model_plays_or_is_refused_as_the_table_says() {
    if !tools::have(&[MODELS]) {
        return;
    }
    let renewed = std::env::var_os("PELLUCID_UPDATE_ASSIMP").is_some_and(|value| value == "1");
    let images = Path::new(env!("CARGO_TARGET_TMPDIR")).join("assimp");
    let mut found = String::new();
    for file in models() {
        let (lines, image) = outcome(&file);
        found += &lines;
        if let (Some(image), true) = (image, renewed) {
            fs::create_dir_all(&images).unwrap();
            image.write_png(&images.join(file.replace('/', "+") + ".png")).unwrap();
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assimp.txt");
    let table = fs::read_to_string(&path).unwrap();
    let (comments, expected): (Vec<&str>, Vec<&str>) =
        table.lines().partition(|line| line.starts_with('#'));
    if renewed {
        fs::write(&path, comments.join("\n") + "\n" + &found).unwrap();
        println!("the images are in {}", images.display());
        return;
    }
    let found: Vec<&str> = found.lines().collect();
    let only = |some: &[&str], others: &[&str], sign: &str| -> String {
        let only = some.iter().filter(|line| !others.contains(line));
        only.map(|line| format!("{sign}{line}\n")).collect()
    };
    assert!(
        found == expected,
        "the table, -, is another than what was found, +:\n{}{}`PELLUCID_UPDATE_ASSIMP=1` writes it anew",
        only(&expected, &found, "-"),
        only(&found, &expected, "+"),
    );
}

/// The models by their paths from the folder, in their order.
fn models() -> Vec<String> {
    let mut folders = vec![PathBuf::from(MODELS)];
    let mut files = vec![];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
            if path.is_dir() {
                folders.push(path);
            } else if EXTENSIONS.iter().any(|known| extension == *known) {
                // A scene's name is text.
                match path.strip_prefix(MODELS).unwrap().to_str() {
                    Some(path) => files.push(path.to_owned()),
                    None => println!("passed over: {}", path.display()),
                }
            }
        }
    }
    files.sort_unstable();
    files
}

/// What the table has to say of a file, and its image if it plays.
fn outcome(file: &str) -> (String, Option<Image>) {
    // What a test prints is shown when it fails or panics.
    println!("{file}");
    let options = Options {
        width: Some(96),
        height: Some(72),
        memory_limit: Some("1G".parse().unwrap()),
        ..Options::default()
    };
    let said = |kind: &str, sentence: &str| {
        format!("{kind} {}\n", sentence.replace(&format!("{MODELS}/"), ""))
    };
    let scene = match Scene::open(&format!("{MODELS}/{file}"), &options) {
        Ok(scene) => scene,
        Err(error) => return (said("refused", &error.to_string()), None),
    };
    let mut fragments = vec![];
    let Ok(()) = scene.play(&mut |fragment| -> Result<(), Infallible> {
        fragments.push(fragment);
        Ok(())
    });
    let image = Golden::new(scene.info()).of(&fragments).unwrap().image;
    let mut crc = Crc::new();
    image.pixels.iter().for_each(|pixel| crc.update(&pixel.to_be_bytes()[1..]));
    let mut lines = format!("plays {} {:08x} {file}\n", fragments.len(), crc.sum());
    lines.extend(scene.notes().iter().map(|note| said("note", note)));
    (lines, Some(image))
}
