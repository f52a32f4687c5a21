//! Points: a design on a scene, and what came of it. Each is kept in a file whose name is a hash of all that it depends on, so
//! that no study does what another one, or the same one before, has done.

use anyhow::Context;
use pellucid_machine::params::Value;
use pellucid_testbench::image::Image;
use pellucid_testbench::output::{OutputError, create_dir, put};
use serde_json::{Map, Value as Json, json};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::env;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// What came of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The image and all counts are what they must be.
    Right,
    /// Fragments were dropped.
    Lossy,
    /// The image or a count is wrong.
    Wrong,
    /// The run ended early.
    Failed,
    /// The parameters do not go together.
    Refused,
    /// Excluded by a constraint before it was run.
    Excluded,
}

/// The file that says what figures are.
const ABOUT: &str = "figures.json";

const STATUSES: [(&str, Status); 6] = [
    ("right", Status::Right),
    ("lossy", Status::Lossy),
    ("wrong", Status::Wrong),
    ("failed", Status::Failed),
    ("refused", Status::Refused),
    ("excluded", Status::Excluded),
];

impl Status {
    /// Its name.
    pub fn name(self) -> &'static str {
        STATUSES.iter().find(|(_, status)| *status == self).map_or("", |(name, _)| name)
    }
}

/// What came of a point, with its figures if it was run to the end.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// In a word.
    pub status: Status,
    /// Why it is not right.
    pub reason: String,
    /// All figures that are one number, `group.name`, in the order of the report.
    pub figures: Vec<(String, f64)>,
    /// The file with its image, in the folder of points; of several frames with the last one.
    pub image: Option<String>,
}

impl Outcome {
    /// One that was not run to the end.
    pub fn without(status: Status, reason: String) -> Outcome {
        Outcome { status, reason, figures: vec![], image: None }
    }

    /// Of that name.
    pub fn figure(&self, name: &str) -> Option<f64> {
        self.figures.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }
}

/// All figures of a report that are one number.
pub fn figures(report: &Json) -> Vec<(String, f64)> {
    let groups = report.as_object().into_iter().flatten();
    let groups = groups.filter(|(name, _)| !matches!(name.as_str(), "config" | "about"));
    let figures = groups.flat_map(|(group, figures)| {
        figures
            .as_object()
            .into_iter()
            .flatten()
            .filter_map(move |(name, value)| Some((format!("{group}.{name}"), value.as_f64()?)))
    });
    figures.collect()
}

/// Where points are kept.
pub struct Points {
    folder: PathBuf,
    program: String,
    digests: Mutex<HashMap<PathBuf, String>>,
    /// Unit and meaning of every figure that a point of this program has.
    about: Mutex<Map<String, Json>>,
}

/// All that a point depends on, with its name.
pub struct Key {
    what: Json,
    hash: String,
}

impl Points {
    /// Points below a folder, of this program alone.
    ///
    /// # Errors
    /// The program cannot be read, or the folder not be made.
    pub fn new(folder: &Path) -> anyhow::Result<Points> {
        let program = env::current_exe().context("the running program has no path")?;
        let program =
            digest(&program).with_context(|| format!("cannot read `{}`", program.display()))?;
        let folder = folder.join(format!("{}-{}", env!("CARGO_PKG_VERSION"), &program[..8]));
        create_dir(&folder)?;
        let points = Points { folder, program, digests: Mutex::default(), about: Mutex::default() };
        points.learn();
        Ok(points)
    }

    /// Takes up what others have kept of what figures are.
    pub fn learn(&self) {
        let said = fs::read(self.folder.join(ABOUT)).ok();
        let said: Option<Map<String, Json>> = said.and_then(|t| serde_json::from_slice(&t).ok());
        // A thread that panicked while it held the table has ended the work anyway.
        if let (Some(said), Ok(mut about)) = (said, self.about.lock()) {
            about.extend(said);
        }
    }

    /// Where they are.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// How many points other versions have left beside these.
    pub fn of_others(&self) -> usize {
        let beside = self.folder.parent().and_then(|parent| fs::read_dir(parent).ok());
        let others = beside.into_iter().flatten().flatten().map(|entry| entry.path());
        let others = others.filter(|path| *path != self.folder && path.is_dir());
        others.map(|path| fs::read_dir(path).map_or(0, Iterator::count)).sum()
    }

    /// The key of a machine with these values on a scene of these arguments. Of these files, and of those that values name, the
    /// content counts.
    pub fn key<'a>(
        &self,
        arch: &str,
        values: &'a [(String, Value)],
        scene: &str,
        files: impl IntoIterator<Item = &'a Path>,
    ) -> Key {
        let config: Map<String, Json> =
            values.iter().map(|(name, value)| (name.clone(), json!(value.to_string()))).collect();
        let texts = values.iter().filter_map(|(_, value)| match value {
            Value::Text(text) => Some(Path::new(text)),
            Value::Number(_) | Value::Choice(_) => None,
        });
        let files: Map<String, Json> = files
            .into_iter()
            .chain(texts)
            .filter_map(|file| Some((file.display().to_string(), json!(self.of_file(file)?))))
            .collect();
        let program = &self.program;
        let what = json!({ "program": program, "arch": arch, "config": config, "scene": scene, "files": files });
        let hash = hex(&Sha256::digest(what.to_string()))[..32].to_string();
        Key { what, hash }
    }

    /// The digest of a file, which is read once; nothing if there is none.
    fn of_file(&self, path: &Path) -> Option<String> {
        // A thread that panicked while it held the table has ended the work anyway.
        let mut digests = self.digests.lock().ok()?;
        if let Some(known) = digests.get(path) {
            return Some(known.clone());
        }
        let found = digest(path).ok()?;
        digests.insert(path.to_owned(), found.clone());
        Some(found)
    }

    /// The file of a point.
    pub fn path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{}.json", key.hash))
    }

    /// What is kept of a point.
    pub fn get(&self, key: &Key) -> Option<Outcome> {
        let json: Json = serde_json::from_slice(&fs::read(self.path(key)).ok()?).ok()?;
        let status = STATUSES.iter().find(|(name, _)| json["status"] == *name)?.1;
        let reason = json["reason"].as_str()?.to_string();
        let figures = figures(&json["report"]);
        let image = json["image"].as_str().map(str::to_string);
        (json["key"] == key.what).then_some(Outcome { status, reason, figures, image })
    }

    /// Keeps a point with its report, whole or not at all. What is said of the figures is kept once.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn put(
        &self,
        key: &Key,
        command: &str,
        outcome: &Outcome,
        mut report: Json,
    ) -> Result<(), OutputError> {
        if let Some(Json::Object(about)) = report.as_object_mut().and_then(|r| r.remove("about")) {
            self.tell(about)?;
        }
        let Outcome { status, reason, image, .. } = outcome;
        let json = json!({
            "key": key.what, "command": command, "status": status.name(), "reason": reason, "image": image,
            "report": report,
        });
        put(&self.path(key), &format!("{json}\n"))
    }

    /// Keeps an image, once for all points that have it; its file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn keep(&self, image: &Image) -> Result<String, OutputError> {
        let mut hasher = Sha256::new();
        hasher.update(image.width.to_le_bytes());
        image.pixels.iter().for_each(|pixel| hasher.update(pixel.to_le_bytes()));
        let name = format!("images/{}.png", &hex(&hasher.finalize())[..32]);
        let path = self.folder.join(&name);
        if !path.exists() {
            create_dir(&self.folder.join("images"))?;
            image.write_png(&path)?;
        }
        Ok(name)
    }

    /// An image that is kept, as PNG.
    pub fn image(&self, name: &str) -> Option<Vec<u8>> {
        fs::read(self.folder.join(name)).ok()
    }

    /// Adds what is said of figures.
    fn tell(&self, said: Map<String, Json>) -> Result<(), OutputError> {
        let is_known =
            |about: &Map<String, Json>| said.keys().all(|figure| about.contains_key(figure));
        if self.about.lock().is_ok_and(|about| is_known(&about)) {
            return Ok(());
        }
        self.learn();
        // A thread that panicked while it held the table has ended the work anyway.
        let Ok(mut about) = self.about.lock() else { return Ok(()) };
        about.extend(said);
        put(&self.folder.join(ABOUT), &format!("{:#}\n", Json::Object(about.clone())))
    }

    /// Unit and meaning of a figure.
    pub fn about(&self, figure: &str) -> [String; 2] {
        let about = self.about.lock().ok();
        let about = about.as_ref().and_then(|about| about.get(figure));
        ["unit", "about"].map(|what| {
            about.and_then(|about| about[what].as_str()).unwrap_or_default().to_string()
        })
    }
}

/// Of a file's content, which may be larger than memory.
fn digest(path: &Path) -> std::io::Result<String> {
    let mut file = BufReader::with_capacity(1 << 16, File::open(path)?);
    let mut hasher = Sha256::new();
    loop {
        let part = file.fill_buf()?;
        if part.is_empty() {
            return Ok(hex(&hasher.finalize()));
        }
        hasher.update(part);
        let length = part.len();
        file.consume(length);
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_found_again_unless_something_differs() {
        let folder = tempfile::tempdir().unwrap();
        let points = Points::new(folder.path()).unwrap();
        let image = Image { width: 2, height: 1, pixels: vec![0x00ff_0000, 0x0000_00ff] };
        let mesh = folder.path().join("mesh.obj");
        fs::write(&mesh, "v 0 0 0\n").unwrap();
        let files = [&*mesh];
        let values = [("n".to_string(), Value::Number(3))];
        let key = points.key("tbuffer", &values, "--width 4", files);
        let report = json!({
            "arch": "tbuffer", "config": { "n": 3 }, "cycles": { "total": 12, "rate": 0.5 }, "frames": [1],
            "about": { "cycles.total": { "unit": "cycles", "about": "All." } },
        });
        let outcome = Outcome {
            status: Status::Lossy,
            reason: "3 dropped".into(),
            figures: vec![("cycles.total".to_string(), 12.0), ("cycles.rate".to_string(), 0.5)],
            image: Some(points.keep(&image).unwrap()),
        };
        assert_eq!(figures(&report), outcome.figures);
        assert_eq!(points.get(&key), None);
        points.put(&key, "pellucid run", &outcome, report).unwrap();
        assert_eq!(points.get(&key).as_ref(), Some(&outcome));
        assert_eq!(outcome.figure("cycles.rate"), Some(0.5));
        // The same image once, whoever has it.
        assert_eq!(points.keep(&image).unwrap(), *outcome.image.as_ref().unwrap());
        assert_eq!(points.image(outcome.image.as_ref().unwrap()), Some(image.png().unwrap()));
        let turned = Image { width: 1, height: 2, ..image };
        assert_ne!(points.keep(&turned).unwrap(), *outcome.image.as_ref().unwrap());
        let again = Points::new(folder.path()).unwrap();
        assert_eq!(again.about("cycles.total"), ["cycles", "All."]);
        let other = [("n".to_string(), Value::Number(4))];
        for key in [
            points.key("rbuffer", &values, "--width 4", files),
            points.key("tbuffer", &other, "--width 4", files),
            points.key("tbuffer", &values, "--width 5", files),
        ] {
            assert_eq!(points.get(&key), None);
        }
        // Another content of the same file.
        fs::write(&mesh, "v 0 0 1\n").unwrap();
        let points = Points::new(folder.path()).unwrap();
        assert_eq!(points.get(&points.key("tbuffer", &values, "--width 4", files)), None);
        // One that is damaged is none.
        fs::write(points.path(&key), "{").unwrap();
        assert_eq!(points.get(&key), None);
    }

    #[test]
    fn what_other_versions_left_is_counted() {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join("0.0.1-00000000");
        fs::create_dir(&other).unwrap();
        fs::write(other.join("a.json"), "{}").unwrap();
        assert_eq!(Points::new(folder.path()).unwrap().of_others(), 1);
    }
}
