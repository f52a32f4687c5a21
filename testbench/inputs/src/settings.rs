//! Settings: the bytes are a configuration file, and each of their lines an option of the command line.
//!
//! A machine that is built tells its parameters' values. The same values set again give the same machine, and a small
//! machine makes the image that the golden model does.

use crate::{lines, write};
use pellucid_hw::ARCHITECTURES;
use pellucid_machine::architecture::{Setting, SettingError};
use pellucid_machine::params::Value;
use pellucid_machine::pixel::{Screen, Z_FAR};
use pellucid_machine::{Architecture, Model};
use pellucid_testbench::progress::Progress;
use pellucid_testbench::scene::{AlphaRule, Camera, Options, Scene};
use pellucid_testbench::settings::{self, SettingsError};
use pellucid_testbench::source::Source;
use pellucid_testbench::trial::Case;
use pellucid_testbench::window::Window;
use std::fmt::{Debug, Display};
use std::str::FromStr;

/// The screen of the machines that run.
const SMALL: Screen = Screen { width: 4, height: 3, background: 0x20_40_60 };
/// The largest screen.
const LARGE: Screen = Screen { width: 8192, height: 8192, background: 0 };
/// A machine runs if none of its parameters is above this, so that it takes little time and memory.
const MOST: u32 = 64;

/// Reads the bytes as a file and as lines, builds every machine with what they set, and runs the small ones.
///
/// # Panics
/// They are not read or refused as they must be, or a machine is at fault.
pub fn check(bytes: &[u8]) {
    let path = write("settings.toml", bytes);
    match settings::read(&path) {
        Ok(settings) => check_machines(&settings),
        Err(error) => {
            let (text, shown) = (error.to_string(), path.display());
            let named = match &error {
                SettingsError::Read { .. } => std::str::from_utf8(bytes).is_err(),
                SettingsError::Line { line, .. } => (1..=lines(bytes)).contains(line),
                SettingsError::Kind { name, .. } => text.contains(&format!("key `{name}`")),
                SettingsError::Form { .. } => false,
            };
            assert!(named && text.contains(&format!("`{shown}`")), "no place is named: {text}");
        }
    }
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let mut given = vec![];
    for line in text.lines() {
        check_again::<Window>(line);
        check_again::<AlphaRule>(line);
        if let Some(camera) = check_again::<Camera>(line) {
            check_view(camera);
        }
        match settings::parse(line, format!("-p {line}")) {
            Ok(setting) => given.push(setting),
            Err(error) => {
                let name = line.split('=').next().unwrap_or_default();
                assert!(!line.contains('=') || name.trim().is_empty(), "refused: {error}");
            }
        }
    }
    check_machines(&given);
}

/// What an option's text means is what its own text means.
fn check_again<T: FromStr<Err: Display> + Display + Debug + PartialEq>(text: &str) -> Option<T> {
    match text.parse::<T>() {
        Ok(value) => {
            let again = value.to_string().parse().ok();
            assert_eq!(again.as_ref(), Some(&value), "`{text}`, written as `{value}`");
            Some(value)
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with(&format!("`{text}`")) && message.contains("expected"));
            None
        }
    }
}

/// A triangle as the camera sees it lies on the screen.
fn check_view(camera: Camera) {
    let path = write("triangle.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let name = path.to_str().expect("a temporary folder has a plain name");
    let (width, height) = (Some(SMALL.width), Some(SMALL.height));
    let options = Options { width, height, camera: Some(camera), ..Options::default() };
    let scene = Scene::open(name, &options).expect("a triangle");
    let Ok(()) = scene.play::<std::convert::Infallible>(&mut |f| {
        let inside = f.x < SMALL.width && f.y < SMALL.height && f.z < Z_FAR;
        assert!(inside, "{f:?} outside the screen");
        Ok(())
    });
}

fn check_machines(settings: &[Setting]) {
    for arch in ARCHITECTURES {
        let mut ran = vec![];
        for (preset, _) in (arch.presets)() {
            let built = arch.build(SMALL, Some(preset), settings);
            if let (Ok(small), Ok(large)) = (&built, arch.build(LARGE, Some(preset), settings)) {
                assert_eq!(small.values(), large.values(), "the screen changes a parameter");
            }
            match built {
                Ok(machine) => {
                    check_values(arch, settings, &*machine);
                    if is_small(&*machine) && !ran.contains(&machine.values()) {
                        check_frame(arch, &*machine);
                        ran.push(machine.values());
                    }
                }
                Err(error) => check_refusal(arch, preset, settings, &error),
            }
        }
    }
}

/// The values are what was set last, and set again they give the same.
fn check_values(arch: &Architecture, settings: &[Setting], machine: &dyn Model) {
    let values = machine.values();
    let names = || (arch.parameters)().into_iter().map(|parameter| parameter.name);
    assert!(values.iter().map(|(name, _)| name.clone()).eq(names()), "the parameters' names");
    for (name, value) in &values {
        if let Some(last) = settings.iter().rfind(|setting| setting.name == *name) {
            let same = match value {
                Value::Number(number) => last.value.parse() == Ok(*number),
                Value::Choice(_) | Value::Text(_) => last.value == value.to_string(),
            };
            assert!(same, "`{name}` is {value}, set to `{}`", last.value);
        }
    }
    let mut file = String::new();
    for (name, value) in &values {
        file += &match value {
            Value::Number(number) => format!("{name} = {number}\n"),
            Value::Choice(_) | Value::Text(_) => format!("{name} = \"{value}\"\n"),
        };
    }
    let again = settings::read(&write("again.toml", file.as_bytes())).expect("values in a file");
    for (preset, _) in (arch.presets)() {
        let machine = arch.build(SMALL, Some(preset), &again).expect("the values once more");
        assert_eq!(machine.values(), values, "the values set again over `{preset}`");
    }
}

/// A refusal names the first setting that is wrong, or parameters that do not go together.
fn check_refusal(arch: &Architecture, preset: &str, settings: &[Setting], error: &SettingError) {
    match error {
        SettingError::Setting { origin, .. } => {
            let wrong = settings.iter().position(|setting| setting.origin == *origin);
            let before = &settings[..wrong.expect("a setting that was given is named")];
            let built = arch.build(SMALL, Some(preset), before);
            assert!(!matches!(built, Err(SettingError::Setting { .. })), "not the first: {error}");
        }
        SettingError::Together(error) => {
            let text = error.to_string();
            let named = |name: &str| text.contains(&format!("`{name}`"));
            assert!((arch.parameters)().iter().any(|p| named(&p.name)), "none is named: {text}");
        }
        _ => panic!("refused by {error:?}"),
    }
}

/// Whether none of the parameters that matter is large: those of a part do not, unless the part is chosen.
fn is_small(machine: &dyn Model) -> bool {
    let values = machine.values();
    let chosen = |part: &str| values.iter().any(|(_, value)| value.to_string() == part);
    values.iter().all(|(name, value)| match value {
        Value::Number(number) => {
            *number <= MOST || name.split_once('.').is_some_and(|(part, _)| !chosen(part))
        }
        Value::Choice(_) | Value::Text(_) => true,
    })
}

/// A frame through the machine gives the golden model's image, or is lossy and says so.
fn check_frame(arch: &Architecture, machine: &dyn Model) {
    let name = write("frame.csv", frame().as_bytes());
    let name = name.to_str().expect("a temporary folder has a plain name");
    let source = Source::open(name, &Options::default()).expect("the frame");
    let mut progress = Progress::new("", None, true);
    let case = Case::new(name, source, machine, &mut progress).expect("the frame");
    let trial = case.run(arch.name, machine, None, &mut progress);
    let verdict = trial.unwrap_or_else(|error| panic!("{}: {error}", arch.name)).verdict;
    assert!(
        verdict.passes(true),
        "{} with {:?}: {:?}",
        arch.name,
        machine.values(),
        verdict.faults()
    );
}

/// A trace with deep pixels and empty ones, and opaque fragments before and behind transparent ones.
fn frame() -> String {
    let Screen { width, height, .. } = SMALL;
    let mut text = format!(
        "# pellucid-trace width={width} height={height} background=32,64,96\nx,y,z,r,g,b,a\n"
    );
    for i in 0..40 {
        let (x, y, z) = (i * i % width, i % height, i * 7919 % 97);
        let alpha = if i % 13 == 5 { 255 } else { i * 37 % 255 };
        text += &format!("{x},{y},{z},{},{},{},{alpha}\n", i * 6, 255 - i * 5, i * 50 % 256);
    }
    text
}
