//! Where a frame comes from: a scene or a trace.

use crate::scene::{Contents, Options, Scene, SceneError, Sequence, Varied, Vary, point};
use crate::trace::{Trace, TraceError};
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_machine::primitive::Primitive;
use pellucid_machine::{Item, Kind};
use std::path::Path;

/// A frame that can be played any number of times, the same each time.
pub enum Source {
    /// A built-in scene or a mesh.
    Scene(Scene),
    /// A frame of a trace file.
    Trace(Trace),
    /// Fragments in memory, in arrival order.
    Fragments(Screen, Vec<Fragment>),
    /// What is opaque of a frame, then what is transparent, each in its order. The frame is played twice, so that nothing of it
    /// is held.
    OpaqueFirst(Box<Source>),
}

/// Degrees by which the camera goes on from frame to frame.
pub const DEGREES_PER_FRAME: u32 = 3;
/// Frames for which a mesh that moves takes a second.
pub const FRAMES_PER_SECOND: u32 = 24;

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
            (options.order.is_some(), "an order of fragments"),
            (options.instances.is_some(), "a number of instances"),
            (matches!(options.sequence, Some(Sequence::Walk(_))), "a path"),
        ];
        if let Some((_, what)) = given.into_iter().find(|(given, _)| *given) {
            return Err(SourceError::Fixed { name: name.into(), what });
        }
        let trace = Trace::open(Path::new(name))?;
        Ok(Source::Trace(match options.sequence {
            Some(Sequence::Varied(Varied { vary: Vary::None, .. })) => trace.alone(),
            Some(Sequence::Varied(Varied { vary, .. })) => {
                return Err(SceneError::vary(name, vary, &[Vary::None]).into());
            }
            _ => trace,
        }))
    }

    /// How many frames are recorded in it; nothing if it is no trace.
    pub fn recorded(&self) -> Option<u32> {
        match self {
            Source::OpaqueFirst(frame) => frame.recorded(),
            Source::Trace(trace) => Some(trace.frames()),
            Source::Scene(_) | Source::Fragments(..) => None,
        }
    }

    /// The same frame with all of its opaque items before all transparent ones. By the rules of the golden model the image is the
    /// same.
    #[must_use]
    pub fn opaque_first(self) -> Source {
        Source::OpaqueFirst(Box::new(self))
    }

    /// The same without any other frame.
    #[must_use]
    pub fn repeated(self) -> Source {
        match self {
            Source::OpaqueFirst(frame) => frame.repeated().opaque_first(),
            Source::Scene(scene) => Source::Scene(scene.repeated()),
            Source::Trace(trace) => Source::Trace(trace.alone()),
            Source::Fragments(..) => self,
        }
    }

    /// What is to be said of the file, each as one sentence.
    pub fn notes(&self) -> &[String] {
        match self {
            Source::OpaqueFirst(frame) => frame.notes(),
            Source::Scene(scene) => scene.notes(),
            Source::Trace(_) | Source::Fragments(..) => &[],
        }
    }

    /// Whether it is a trace.
    pub fn is_trace(&self) -> bool {
        match self {
            Source::OpaqueFirst(frame) => frame.is_trace(),
            Source::Trace(_) => true,
            Source::Scene(_) | Source::Fragments(..) => false,
        }
    }

    /// What it is made of; nothing if it is not made of meshes.
    pub fn contents(&self) -> Option<Contents> {
        match self {
            Source::OpaqueFirst(frame) => frame.contents(),
            Source::Scene(scene) => scene.contents(),
            Source::Trace(_) | Source::Fragments(..) => None,
        }
    }

    /// The screen.
    pub fn screen(&self) -> Screen {
        match self {
            Source::OpaqueFirst(frame) => frame.screen(),
            Source::Scene(scene) => scene.info(),
            Source::Trace(trace) => trace.info(),
            Source::Fragments(screen, _) => *screen,
        }
    }

    /// The frame so many frames later: the next ones of a trace, of a scene see [`Scene::later`]. Nothing if it is the same frame
    /// again, as where the source is one alone. To be asked of the first frame.
    ///
    /// # Errors
    /// The file of a mesh that moves cannot be read any more, or a trace does not have so many frames.
    pub fn later(&self, frames: u32) -> Result<Option<Source>, SourceError> {
        Ok(match self {
            Source::OpaqueFirst(frame) => frame.later(frames)?.map(Source::opaque_first),
            Source::Scene(scene) => scene.later(frames)?.map(Source::Scene),
            Source::Trace(trace) => trace.later(frames)?.map(Source::Trace),
            Source::Fragments(..) => None,
        })
    }

    /// Hands so many frames to `each`, in order, with their numbers from 0.
    ///
    /// # Errors
    /// As [`Source::later`], and the first one of `each`.
    pub fn each_frame<E: From<SourceError>>(
        &self,
        frames: u32,
        each: &mut dyn FnMut(u32, &Source) -> Result<(), E>,
    ) -> Result<(), E> {
        for number in 0..frames {
            let later = if number > 0 { self.later(number)? } else { None };
            each(number, later.as_ref().unwrap_or(self))?;
        }
        Ok(())
    }

    /// Sends every item in arrival order, of the kind that is asked for.
    ///
    /// # Errors
    /// The receiver's first error, or a trace that turns out to be damaged.
    pub fn play<E: From<SourceError>>(
        &self,
        kind: Kind,
        sink: &mut dyn FnMut(&Item) -> Result<(), E>,
    ) -> Result<(), E> {
        match kind {
            Kind::Fragments => self.play_fragments(&mut |fragment| sink(&fragment.into())),
            Kind::Primitives => self.play_primitives(&mut |primitive| sink(&primitive.into())),
        }
    }

    /// Sends every fragment in arrival order.
    ///
    /// # Errors
    /// As [`Source::play`].
    pub fn play_fragments<E: From<SourceError>>(
        &self,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        match self {
            Source::OpaqueFirst(frame) => [true, false].into_iter().try_for_each(|opaque| {
                let of_turn = |fragment: &Fragment| fragment.is_opaque() == opaque;
                frame.play_fragments(&mut |fragment| {
                    if of_turn(&fragment) { sink(fragment) } else { Ok(()) }
                })
            }),
            Source::Scene(scene) => scene.play(sink),
            Source::Fragments(_, fragments) => fragments.iter().try_for_each(|f| sink(*f)),
            Source::Trace(trace) => {
                let played = trace.play(&mut |fragment| sink(fragment).map_err(Stopped::Sink));
                played.map_err(|e| match e {
                    Stopped::Sink(e) => e,
                    Stopped::Trace(e) => SourceError::from(e).into(),
                })
            }
        }
    }

    /// Sends the same frame as primitives in arrival order: see [`Scene::play_primitives`]. Of a frame that is given as
    /// fragments each is one.
    ///
    /// # Errors
    /// As [`Source::play`].
    pub fn play_primitives<E: From<SourceError>>(
        &self,
        sink: &mut dyn FnMut(Primitive) -> Result<(), E>,
    ) -> Result<(), E> {
        match self {
            Source::OpaqueFirst(frame) => [true, false].into_iter().try_for_each(|opaque| {
                let of_turn = |primitive: &Primitive| primitive.opaque == opaque;
                frame.play_primitives(&mut |primitive| {
                    if of_turn(&primitive) { sink(primitive) } else { Ok(()) }
                })
            }),
            Source::Scene(scene) => scene.play_primitives(sink),
            Source::Trace(_) | Source::Fragments(..) => {
                self.play_fragments(&mut |fragment| sink(point(fragment)))
            }
        }
    }
}

/// Tells the receiver's errors from the trace's.
enum Stopped<E> {
    Sink(E),
    Trace(TraceError),
}

impl<E> From<TraceError> for Stopped<E> {
    fn from(error: TraceError) -> Stopped<E> {
        Stopped::Trace(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::BenchError;
    use crate::golden::Golden;
    use crate::golden::primitive::fragments;
    use pellucid_sim::Label;
    use proptest::prelude::*;

    /// All items of a frame in their order.
    fn items(source: &Source, kind: Kind) -> Vec<Item> {
        let mut items = vec![];
        source
            .play::<BenchError>(kind, &mut |item| {
                items.push(*item);
                Ok(())
            })
            .unwrap();
        items
    }

    /// The opaque items of a frame as it comes, then the others.
    fn check_opaque_first(open: impl Fn() -> Source) {
        for kind in [Kind::Fragments, Kind::Primitives] {
            let (opaque, transparent): (Vec<Item>, Vec<Item>) =
                items(&open(), kind).into_iter().partition(Item::is_opaque);
            let sent = items(&open().opaque_first(), kind);
            let seen_transparent = sent.iter().position(|item| !item.is_opaque());
            let first = seen_transparent.unwrap_or(sent.len());
            assert!(sent[first..].iter().all(|item| !item.is_opaque()), "{kind:?}");
            assert!(sent == [opaque, transparent].concat(), "{kind:?}");
        }
    }

    #[test]
    fn opaque_items_of_scenes_come_first_in_every_frame() {
        let options = Options { width: Some(40), height: Some(30), ..Options::default() };
        for name in ["glass", "panes", "smoke", "quads-3-50"] {
            check_opaque_first(|| Source::open(name, &options).unwrap());
        }
        let glass = || Source::open("glass", &options).unwrap();
        check_opaque_first(|| glass().later(7).unwrap().unwrap());
        let later = glass().opaque_first().later(7).unwrap().unwrap();
        let expected = glass().later(7).unwrap().unwrap().opaque_first();
        assert!(items(&later, Kind::Primitives) == items(&expected, Kind::Primitives));
    }

    proptest! {
        /// In memory and as a trace; few places and depths, so that ties are common.
        #[test]
        fn opaque_fragments_come_first_and_the_image_stays(
            frame in prop::collection::vec((0u32..3, 0u32..2, 0u32..4, any::<u32>(), any::<bool>()), 0..60),
        ) {
            let fragment = |(x, y, z, rgba, opaque): (u32, u32, u32, u32, bool)| {
                let rgba = if opaque { rgba | 0xff } else { rgba };
                Fragment { x, y, z, rgba, label: Label::NONE }
            };
            let screen = Screen { width: 3, height: 2, background: 0x10_2030 };
            let frame: Vec<Fragment> = frame.into_iter().map(fragment).collect();
            check_opaque_first(|| Source::Fragments(screen, frame.clone()));
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("frame.ptrace");
            let mut writer = crate::trace::TraceWriter::create(&path, screen, 1).unwrap();
            frame.iter().for_each(|fragment| writer.push(*fragment).unwrap());
            writer.finish().unwrap();
            let trace = || Source::open(path.to_str().unwrap(), &Options::default()).unwrap();
            check_opaque_first(trace);
            let mut sent = vec![];
            trace().opaque_first().play_fragments::<BenchError>(&mut |fragment| {
                sent.push(fragment);
                Ok(())
            }).unwrap();
            let image = |frame: &[Fragment]| Golden::new(screen).of(frame).unwrap().image;
            prop_assert_eq!(image(&sent), image(&frame));
        }
    }

    #[test]
    fn a_trace_plays_as_points_and_so_does_what_is_never_seen() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("three.csv");
        let text = "# pellucid-trace width=4 height=3 background=0,0,0\nx,y,z,r,g,b,a\n\
                    1,2,5,6,7,8,255\n0,0,16777215,1,1,1,9\n3,0,16777214,1,2,3,0\n";
        std::fs::write(&path, text).unwrap();
        let source = Source::open(path.to_str().unwrap(), &Options::default()).unwrap();
        let mut all: Vec<Fragment> = vec![];
        source
            .play_fragments::<BenchError>(&mut |fragment| {
                all.push(fragment);
                Ok(())
            })
            .unwrap();
        let mut of_primitives: Vec<Fragment> = vec![];
        source
            .play_primitives::<BenchError>(&mut |primitive| {
                of_primitives.extend(fragments(&primitive, 4));
                Ok(())
            })
            .unwrap();
        assert_eq!(all.len(), 3);
        assert_eq!(of_primitives, all);
    }
}
