//! Where a frame comes from: a scene or a trace.

use crate::scene::{Options, Scene, SceneError, point};
use crate::trace::{Trace, TraceError};
use pellucid_hw::pixel::{Fragment, Screen, Z_FAR};
use pellucid_hw::primitive::Primitive;
use std::path::Path;

/// A frame that can be played any number of times, the same each time.
pub enum Source {
    /// A built-in scene or a mesh.
    Scene(Scene),
    /// A trace file.
    Trace(Trace),
}

/// A frame that cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// From a scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// From a trace.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// An option that only scenes take was given with a trace.
    #[error("`{name}` is a trace: {what} cannot be set, a trace has its own pixels")]
    Fixed {
        /// The trace.
        name: String,
        /// The option.
        what: &'static str,
    },
}

impl Source {
    /// Opens a built-in scene by name, a mesh or a trace by its file name's ending.
    ///
    /// # Errors
    /// One sentence that names what is wrong and what was expected.
    pub fn open(name: &str, options: &Options) -> Result<Source, SourceError> {
        let ending = Path::new(name).extension().map(|e| e.to_ascii_lowercase());
        if !ending.is_some_and(|e| e == "csv" || e == "ptrace") {
            return Ok(Source::Scene(Scene::open(name, options)?));
        }
        let given = [
            (options.width.is_some(), "a width"),
            (options.height.is_some(), "a height"),
            (options.camera.is_some(), "a camera"),
            (!options.alphas.is_empty(), "an alpha"),
        ];
        if let Some((_, what)) = given.into_iter().find(|(given, _)| *given) {
            return Err(SourceError::Fixed { name: name.into(), what });
        }
        Ok(Source::Trace(Trace::open(Path::new(name))?))
    }

    /// The screen.
    pub fn screen(&self) -> Screen {
        match self {
            Source::Scene(scene) => scene.info(),
            Source::Trace(trace) => trace.info(),
        }
    }

    /// Sends every fragment in arrival order.
    ///
    /// # Errors
    /// The receiver's first error, or a trace that turns out to be damaged.
    pub fn play<E: From<SourceError>>(
        &self,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        match self {
            Source::Scene(scene) => scene.play(sink),
            Source::Trace(trace) => {
                let played = trace.play(&mut |fragment| sink(fragment).map_err(Played::Sink));
                played.map_err(|e| match e {
                    Played::Sink(e) => e,
                    Played::Trace(e) => SourceError::from(e).into(),
                })
            }
        }
    }

    /// Sends the same frame as primitives in arrival order: see [`Scene::play_primitives`]. What a trace has at
    /// [`Z_FAR`] is no primitive, since it can never be seen.
    ///
    /// # Errors
    /// As [`Source::play`].
    pub fn play_primitives<E: From<SourceError>>(
        &self,
        sink: &mut dyn FnMut(Primitive) -> Result<(), E>,
    ) -> Result<(), E> {
        match self {
            Source::Scene(scene) => scene.play_primitives(sink),
            Source::Trace(_) => self.play(&mut |fragment| match fragment.z {
                Z_FAR => Ok(()),
                _ => sink(point(fragment)),
            }),
        }
    }
}

/// Tells the receiver's errors from the trace's.
enum Played<E> {
    Sink(E),
    Trace(TraceError),
}

impl<E> From<TraceError> for Played<E> {
    fn from(error: TraceError) -> Played<E> {
        Played::Trace(error)
    }
}
