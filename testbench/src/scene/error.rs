//! What can be wrong with a scene, each as one sentence.

use super::vary::Vary;
use crate::output::reason;
use crate::room::Full;
use pellucid_machine::params::did_you_mean;
use std::io;

/// Why a scene cannot be opened.
#[derive(thiserror::Error, Debug)]
pub enum SceneError {
    /// Neither a built-in scene nor a path.
    #[error(
        "unknown scene `{name}`{}; known are {known}, or a file: {FILES}",
        did_you_mean(nearest)
    )]
    Unknown {
        /// What was asked for.
        name: String,
        /// The built-in scene with the name most like it.
        nearest: Option<&'static str>,
        /// All built-in scenes, separated by commas.
        known: String,
    },
    /// A name like `quads-5-50` with other numbers than it may have.
    #[error(
        "unknown scene `{scene}`: expected quads-N-P with N from 1 to {most}, the number of quads, and P from 0 to 100, the \
         percentage of the screen"
    )]
    Quads {
        /// What was asked for.
        scene: String,
        /// The most quads.
        most: u32,
    },
    /// The path leads nowhere.
    #[error("{path}: no such file")]
    Missing {
        /// The path as given.
        path: String,
    },
    /// The path leads to a directory.
    #[error("{path}: is a directory, expected a file: {FILES}")]
    Directory {
        /// The path as given.
        path: String,
    },
    /// The path leads to a device or a pipe.
    #[error("{path}: is no regular file, expected {FILES}")]
    Device {
        /// The path as given.
        path: String,
    },
    /// No loader for such a file.
    #[error("{path}: unknown kind of file, expected {FILES}")]
    Extension {
        /// The path as given.
        path: String,
    },
    /// The system refuses to hand the file over, or its compressed data is damaged.
    #[error("{path}: cannot be read: {}", reason(source))]
    Unreadable {
        /// The path of the file that failed, which may be one that the mesh refers to.
        path: String,
        /// The system's or the decompressor's reason.
        source: io::Error,
    },
    /// The file's content is not a usable mesh.
    #[error("{path}{}: {what}", line.map(|line| format!(", line {line}")).unwrap_or_default())]
    Mesh {
        /// The path as given.
        path: String,
        /// The line, from 1, in formats that have lines.
        line: Option<usize>,
        /// What is wrong and what was expected.
        what: String,
    },
    /// The scene takes more memory than it may.
    #[error("{path}: {source}")]
    Memory {
        /// The path as given.
        path: String,
        /// What it may take.
        source: Full,
    },
    /// Width or height outside `1..=MAX_SIDE`.
    #[error("{what} {side} is out of range: expected 1..={}", super::MAX_SIDE)]
    Size {
        /// `width` or `height`.
        what: &'static str,
        /// What was asked for, in pixels.
        side: u32,
    },
    /// Another size for a scene that has only one.
    #[error("scene `{scene}` is always 640x480: {what} {side} cannot be had")]
    FixedSize {
        /// The scene's name.
        scene: String,
        /// `width` or `height`.
        what: &'static str,
        /// What was asked for, in pixels.
        side: u32,
    },
    /// A camera, or an order of fragments, for a scene that is given as pixels.
    #[error("scene `{scene}` is a list of pixels: {what} cannot be set")]
    Pixels {
        /// The scene's name.
        scene: String,
        /// What was asked for.
        what: &'static str,
    },
    /// What only meshes take, for a scene without meshes.
    #[error("scene `{scene}` has no meshes: {what} cannot be set")]
    NoMeshes {
        /// The scene's name.
        scene: String,
        /// What was asked for.
        what: &'static str,
    },
    /// A way of varying that there is nothing for in the scene.
    #[error("`{scene}` has nothing that `{vary}` varies: expected {ways}")]
    Vary {
        /// The scene's name or path.
        scene: String,
        /// What was asked for.
        vary: Vary,
        /// The ways that there are, as a message lists them.
        ways: String,
    },
    /// No instances, or too many.
    #[error("{instances} instances are out of range: expected 1..={}", super::MOST_INSTANCES)]
    Instances {
        /// What was asked for.
        instances: u32,
    },
    /// Instances that lie beyond what a coordinate can be.
    #[error(
        "{scene}: {instances} instances side by side do not fit into the range of coordinates, expected fewer"
    )]
    Beyond {
        /// The scene's name or path.
        scene: String,
        /// What was asked for.
        instances: u32,
    },
    /// An alpha rule for a mesh that the scene does not have.
    #[error(
        "{scene}: no mesh, group or material is named `{name}`{}; known are {known}",
        did_you_mean(nearest)
    )]
    UnknownPart {
        /// The scene's name or path.
        scene: String,
        /// The name in the rule.
        name: String,
        /// The nearest name that the scene has.
        nearest: Option<String>,
        /// All names of the scene, separated by commas.
        known: String,
    },
}

impl SceneError {
    /// A way of varying that is none of these.
    pub(crate) fn vary(scene: &str, vary: Vary, ways: &[Vary]) -> SceneError {
        let names: Vec<String> = ways.iter().map(Vary::to_string).collect();
        let (last, before) = names.split_last().expect("any frame can be repeated");
        let ways = match before {
            [] => last.clone(),
            _ => format!("{} or {last}", before.join(", ")),
        };
        SceneError::Vary { scene: scene.into(), vary, ways }
    }
}

/// The files that a frame can come from, as a message lists them.
const FILES: &str = "a mesh (.obj, .ply, .ply.gz, .gltf or .glb) or a trace (.csv or .ptrace)";
