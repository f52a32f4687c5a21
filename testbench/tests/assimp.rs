//! The models that Assimp is tested with, as Debian's package `assimp-testmodels` installs them: each plays, or is refused
//! with the words that `assimp.txt` has for it.
//!
//! An entry of the table is a file with the CRC-32 of its bytes, then `plays FRAGMENTS IMAGE` with the CRC-32 of the red,
//! green and blue bytes of the image row by row, or `refused` and the sentence, then notes. A file that is another one in the
//! package's version at hand is played, and its outcome not compared. With the environment variable
//! `PELLUCID_UPDATE_ASSIMP=1` the table is written anew, and the images beside the test's program: look at those that are
//! others than before.

#[path = "../command/tests/tools/mod.rs"]
mod tools;

use flate2::Crc;
use pellucid_testbench::golden::Golden;
use pellucid_testbench::image::Image;
use pellucid_testbench::scene::{Options, Scene};
use std::collections::HashMap;
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
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/assimp.txt");
    let table = fs::read_to_string(&path).unwrap();
    let mut entries = table.trim_end().split("\n\n");
    let comment = entries.next().unwrap();
    let expected: HashMap<&str, &str> = entries.filter_map(|e| e.split_once('\n')).collect();
    let (mut renewed_table, mut known, mut faults) = (comment.to_owned(), 0, String::new());
    for file in models() {
        // What a test prints is shown when it fails or panics.
        println!("{file}");
        let model =
            format!("{file} {:08x}", crc(&fs::read(Path::new(MODELS).join(&file)).unwrap()));
        let (lines, image) = outcome(&file);
        match expected.get(model.as_str()) {
            Some(expected) => {
                known += 1;
                if lines != *expected {
                    faults += &format!("{model}\nexpected: {expected}\nfound: {lines}\n");
                }
            }
            None => println!("not in the table: {model}"),
        }
        renewed_table += &format!("\n\n{model}\n{lines}");
        if let (Some(image), true) = (image, renewed) {
            fs::create_dir_all(&images).unwrap();
            image.write_png(&images.join(file.replace('/', "+") + ".png")).unwrap();
        }
    }
    if renewed {
        fs::write(&path, renewed_table + "\n").unwrap();
        println!("the images are in {}", images.display());
        return;
    }
    assert!(faults.is_empty(), "{faults}`PELLUCID_UPDATE_ASSIMP=1` writes the table anew");
    assert!(
        2 * known > expected.len(),
        "{known} of the table's {} files are there",
        expected.len()
    );
}

/// The CRC-32 of bytes.
fn crc(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
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
    let options = Options {
        width: Some(96),
        height: Some(72),
        memory_limit: Some("1G".parse().unwrap()),
        ..Options::default()
    };
    let said = |kind: &str, sentence: &str| {
        format!("{kind} {}", sentence.replace(&format!("{MODELS}/"), ""))
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
    let colours: Vec<u8> =
        image.pixels.iter().flat_map(|pixel| pixel.to_be_bytes().into_iter().skip(1)).collect();
    let mut lines = vec![format!("plays {} {:08x}", fragments.len(), crc(&colours))];
    lines.extend(scene.notes().iter().map(|note| said("note", note)));
    (lines.join("\n"), Some(image))
}
