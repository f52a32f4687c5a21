//! Frames to feed to an architecture: a built-in scene or a mesh file becomes a stream of fragments.
//!
//! Opening a scene loads and checks everything that can fail; playing it cannot fail except through the receiver.
//! Fragments are made on the fly, one triangle, particle or pixel layer at a time, so that a frame larger than memory
//! can be played. The order of the stream is the order of submission, as a graphics API would see it: nothing is
//! sorted, and opaque geometry may arrive after transparent geometry that it hides.
//!
//! The path of a mesh: `mesh` reads the file into parts, `alpha` gives parts their opacity, `camera` places the
//! eye, `shade` lights the vertices, `clip` and `raster` bring each triangle to the screen, `set_up` makes primitives of
//! it, the fragments are their walk, and `paint` gives these their textures.

mod alpha;
mod built_in;
mod camera;
mod clip;
mod contents;
mod error;
mod flat;
mod geometry;
mod instances;
mod mesh;
mod order;
mod paint;
mod perspective;
mod raster;
mod sequence;
mod set_up;
mod shade;
mod splat;
mod srgb;
mod texture;
mod vary;
mod walk;

pub use alpha::{AlphaRule, AlphaRuleError};
pub use built_in::{BuiltIn, built_in, is_built_in};
pub use camera::{Camera, CameraError};
pub use contents::{Contents, Extension, Handling, PartContents, TextureContents};
pub use error::SceneError;
pub use geometry::AlphaMode;
pub use instances::MOST_INSTANCES;
pub use order::{Order, OrderError};
pub use sequence::Sequence;
pub use set_up::point;
pub use vary::{Varied, Vary, VaryError};
pub use walk::{CameraPath, CameraPathError, Walk};

use crate::room::{Limit, Room};
use crate::source::{DEGREES_PER_FRAME, FRAMES_PER_SECOND};
use built_in::paper::{Frame, Paper};
use built_in::quads::Quads;
use built_in::smoke::Smoke;
use clip::Vertex;
use flat::Flat;
use geometry::{DEFAULT_ALPHA, Part};
use instances::side_by_side;
use pellucid_machine::pixel::{Fragment, MAX_SIDE, Screen};
use pellucid_machine::primitive::Primitive;
use shade::Surface;
use std::sync::Arc;
use vary::Sample;

/// Width of a frame where none is asked for, in pixels.
const DEFAULT_WIDTH: u32 = 640;
/// Height of a frame where none is asked for, in pixels.
const DEFAULT_HEIGHT: u32 = 480;

/// What a user may change about a scene.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Width in pixels, `1..=MAX_SIDE`; 640 if `None`.
    pub width: Option<u32>,
    /// Height in pixels, `1..=MAX_SIDE`; 480 if `None`.
    pub height: Option<u32>,
    /// Where to look from; the scene's own view, or one that fits the mesh, if `None`.
    pub camera: Option<Camera>,
    /// Opacities, applied in this order, so that a later rule wins.
    pub alphas: Vec<AlphaRule>,
    /// How often meshes are there, side by side along x, `1..=`[`MOST_INSTANCES`]; once if `None`. With several, the view fits
    /// all of them if no camera is given.
    pub instances: Option<u32>,
    /// How several frames differ; as [`Scene::later`] says if `None`.
    pub sequence: Option<Sequence>,
    /// In which order the fragments of a triangle, splat or particle come; row by row if `None`.
    pub order: Option<Order>,
    /// The most memory that the scene may take; half of what the computer has left if `None`.
    pub memory_limit: Option<Limit>,
}

/// A loaded scene, ready to play any number of times.
#[derive(Debug)]
pub struct Scene {
    info: Screen,
    content: Content,
    notes: Vec<String>,
    /// Those that the file of a mesh uses.
    extensions: Vec<Extension>,
    /// The file of a mesh that moves, and how it is opened.
    moving: Option<Box<(String, Options)>>,
    /// How frames differ, if it is told, and what they start from.
    course: Option<Box<Course>>,
}

/// Where the frames of a sequence come from.
#[derive(Debug)]
struct Course {
    sequence: Sequence,
    /// The view of the scene alone, if it is made of meshes.
    view: Option<Camera>,
}

#[derive(Debug)]
enum Content {
    Surface(Box<Surface>),
    Flat(Box<Flat>),
    Smoke(Smoke),
    Paper(Paper),
}

impl Scene {
    /// Opens a built-in scene by its name (see [`built_in`]), or a mesh by its path and extension: `.obj`, `.ply`,
    /// `.ply.gz`, `.gltf` or `.glb`, in any case.
    ///
    /// # Errors
    ///
    /// One sentence that names the scene or file, the line where the format has lines, and what was expected.
    pub fn open(name: &str, options: &Options) -> Result<Scene, SceneError> {
        let scene = Scene::open_at(name, options, 0.0)?;
        match options.sequence {
            None => Ok(scene),
            Some(sequence) => scene.first_of(name, sequence),
        }
    }

    /// Opens a scene at a time of what moves in it.
    fn open_at(name: &str, options: &Options, seconds: f32) -> Result<Scene, SceneError> {
        let side = |what, asked: Option<u32>, default| match asked.unwrap_or(default) {
            side @ 1..=MAX_SIDE => Ok(side),
            side => Err(SceneError::Size { what, side }),
        };
        let width = side("width", options.width, DEFAULT_WIDTH)?;
        let height = side("height", options.height, DEFAULT_HEIGHT)?;
        let info = |background| Screen { width, height, background };
        let order = options.order.unwrap_or_default();
        match name {
            "glass" => {
                let camera = own_view(built_in::glass::camera, options);
                let info = info(built_in::glass::BACKGROUND);
                surface(name, built_in::glass::parts(), camera, info, options)
            }
            "plant" => {
                let camera = own_view(built_in::plant::camera, options);
                let info = info(built_in::BACKDROP);
                surface(name, built_in::plant::parts(), camera, info, options)
            }
            "teapot" => surface(
                name,
                built_in::teapot::parts(),
                options.camera,
                info(built_in::BACKDROP),
                options,
            ),
            "cube" => {
                let parts = built_in::cube::parts();
                surface(name, parts, options.camera, info(built_in::BACKDROP), options)
            }
            "smoke" => {
                refuse_meshes(name, options)?;
                let info = info(built_in::smoke::BACKGROUND);
                Ok(Scene::of(info, Content::Smoke(Smoke::new(options.camera, info, order))))
            }
            "panes" => {
                let info = info(built_in::panes::BACKGROUND);
                flat(name, built_in::panes::triangles(), info, options)
            }
            "triangles" => {
                let info = info(built_in::triangles::BACKGROUND);
                flat(name, built_in::triangles::pair(), info, options)
            }
            "rainbow" => {
                let info = info(built_in::triangles::BACKGROUND);
                flat(name, built_in::triangles::rainbow(), info, options)
            }
            "sphere-12288" | "sphere-196608" => {
                let steps = if name == "sphere-12288" { 64 } else { 256 };
                let camera = own_view(built_in::sphere::camera, options);
                let parts = built_in::sphere::parts(steps);
                surface(name, parts, camera, info(built_in::BACKDROP), options)
            }
            _ => match (built_in::paper::frame(name), Quads::parse(name)) {
                (Some(frame), _) => paper(name, frame, info(built_in::paper::BACKGROUND), options),
                (None, Some(quads)) => {
                    let info = info(built_in::BACKDROP);
                    flat(name, quads?.triangles(info), info, options)
                }
                (None, None) => {
                    let mesh::Loaded { parts, mut notes, extensions, has_no_opacity, moves } =
                        mesh::load(name, Room::new(options.memory_limit), seconds)?;
                    if has_no_opacity && options.alphas.is_empty() {
                        notes.push(format!(
                            "{name}: what has no opacity of its own is drawn at {DEFAULT_ALPHA}, `--alpha` sets another"
                        ));
                    }
                    let scene =
                        surface(name, parts, options.camera, info(built_in::BACKDROP), options)?;
                    let moving = moves.then(|| Box::new((name.to_owned(), options.clone())));
                    Ok(Scene { notes, extensions, moving, ..scene })
                }
            },
        }
    }

    fn of(info: Screen, content: Content) -> Scene {
        Scene { info, content, notes: vec![], extensions: vec![], moving: None, course: None }
    }

    /// What is to be said of the file, each as one sentence: what of it is not drawn, or drawn by a rule.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// What it is made of; nothing if it is not made of meshes.
    pub fn contents(&self) -> Option<Contents> {
        self.surface().map(|surface| surface.contents(&self.extensions))
    }

    /// The first frame of a sequence, from which those after it come.
    fn first_of(self, name: &str, sequence: Sequence) -> Result<Scene, SceneError> {
        if let Sequence::Varied(Varied { vary, .. }) = sequence
            && !self.varies_by().contains(&vary)
        {
            return Err(SceneError::vary(name, vary, self.varies_by()));
        }
        let course = Some(Box::new(Course { sequence, view: self.view() }));
        let scene = Scene { course, ..self };
        Ok(match scene.later(0)? {
            Some(Scene { content, .. }) => Scene { content, ..scene },
            None => scene,
        })
    }

    /// The scene without later frames.
    #[must_use]
    pub fn repeated(self) -> Scene {
        let sequence = Sequence::Varied(Varied { vary: Vary::None, frames: 1 });
        Scene { course: Some(Box::new(Course { sequence, view: None })), ..self }
    }

    /// What can vary in it.
    fn varies_by(&self) -> &'static [Vary] {
        match &self.content {
            Content::Surface(surface) if surface.is_lit() => &Vary::ALL,
            Content::Surface(_) => &[Vary::None, Vary::Aa, Vary::Focus, Vary::Motion],
            Content::Smoke(_) => &[Vary::None, Vary::Aa, Vary::Focus],
            Content::Flat(_) => &[Vary::None, Vary::Aa],
            Content::Paper(_) => &[Vary::None],
        }
    }

    /// The frame so many frames later: as its sequence has it, else a mesh that moves has moved on, by [`FRAMES_PER_SECOND`], and
    /// round any other the camera has gone by [`DEGREES_PER_FRAME`] each. Nothing if it is the same frame, or the scene is one
    /// alone. To be asked of the first frame.
    ///
    /// # Errors
    /// The file of a mesh that moves, which is read again, is not what it was.
    pub fn later(&self, frames: u32) -> Result<Option<Scene>, SceneError> {
        let time = f64::from(frames);
        let Some(Course { sequence, view }) = self.course.as_deref() else {
            return self.gone(time, self.onward(self.view(), time));
        };
        match sequence {
            Sequence::Walk(walk) => self.gone(time, view.map(|view| walk.camera(view, frames))),
            Sequence::Varied(varied) => {
                let sample = varied.sample(frames);
                match varied.vary {
                    Vary::None => Ok(None),
                    Vary::Motion => self.gone(sample.gone, self.onward(*view, sample.gone)),
                    Vary::Aa | Vary::Focus | Vary::Light => Ok(self.sampled(*view, &sample)),
                }
            }
        }
    }

    /// Where a camera without a way is after the time of so many frames: in its place where something moves, else farther round.
    fn onward(&self, view: Option<Camera>, frames: f64) -> Option<Camera> {
        let round = |view: Camera| view.turned(frames * f64::from(DEGREES_PER_FRAME));
        if self.moving.is_some() { view } else { view.map(round) }
    }

    /// The scene after the time of so many frames, from this camera; nothing if it has none.
    fn gone(&self, frames: f64, camera: Option<Camera>) -> Result<Option<Scene>, SceneError> {
        let Some((name, options)) = self.moving.as_deref().filter(|_| frames > 0.0) else {
            return Ok(camera.and_then(|camera| self.seen_from(camera)));
        };
        let seconds = frames / f64::from(FRAMES_PER_SECOND);
        let options = Options { camera, ..options.clone() };
        Scene::open_at(name, &options, seconds as f32).map(Some)
    }

    /// The scene from another camera. Only scenes of triangles can be seen so.
    fn seen_from(&self, camera: Camera) -> Option<Scene> {
        self.sampled(Some(camera), &Sample::default())
    }

    /// The scene where what varies is at `sample`, one of triangles from this camera.
    fn sampled(&self, view: Option<Camera>, sample: &Sample) -> Option<Scene> {
        let content = match &self.content {
            Content::Surface(surface) => Content::Surface(Box::new(
                surface.seen_from(view.unwrap_or(surface.camera), sample),
            )),
            Content::Smoke(smoke) => Content::Smoke(smoke.sampled(sample)),
            Content::Flat(flat) => Content::Flat(Box::new(flat.sampled(sample))),
            Content::Paper(_) => return None,
        };
        Some(Scene::of(self.info, content))
    }

    /// Where it is seen from, if it is made of meshes.
    fn view(&self) -> Option<Camera> {
        self.surface().map(|surface| surface.camera)
    }

    /// Its meshes, if it is made of such.
    fn surface(&self) -> Option<&Surface> {
        match &self.content {
            Content::Surface(surface) => Some(surface),
            Content::Flat(_) | Content::Smoke(_) | Content::Paper(_) => None,
        }
    }

    /// The frame's size and background.
    pub fn info(&self) -> Screen {
        self.info
    }

    /// Plays the frame in arrival order, the fragments of each triangle, splat or particle in the order asked for, the same
    /// fragments at every call; all of them lie on the screen with a depth below [`pellucid_machine::pixel::Z_FAR`].
    ///
    /// # Errors
    ///
    /// The receiver's first error, after which nothing more is sent.
    pub fn play<E>(&self, sink: &mut dyn FnMut(Fragment) -> Result<(), E>) -> Result<(), E> {
        match &self.content {
            Content::Surface(surface) => surface.projected.play(sink),
            Content::Flat(flat) => flat.projected.play(sink),
            Content::Smoke(smoke) => smoke.play(sink),
            Content::Paper(paper) => paper.play(sink),
        }
    }

    /// Plays the frame as primitives, in the order of [`Scene::play`]: triangles set up for an engine, which goes through
    /// each row by row. Fragments that are no triangle's are each a [`point`], and so are those that a texture or a cutoff
    /// of alpha makes, since an engine knows neither.
    ///
    /// # Errors
    ///
    /// The receiver's first error, after which nothing more is sent.
    pub fn play_primitives<E>(
        &self,
        sink: &mut dyn FnMut(Primitive) -> Result<(), E>,
    ) -> Result<(), E> {
        match &self.content {
            Content::Surface(surface) => surface.projected.play_primitives(sink),
            Content::Flat(flat) => flat.projected.play_primitives(sink),
            Content::Smoke(_) | Content::Paper(_) => {
                self.play(&mut |fragment| sink(point(fragment)))
            }
        }
    }

    /// How many triangles, splats, particles or pixel layers a call of [`Scene::play`] goes through.
    pub fn primitives(&self) -> usize {
        match &self.content {
            Content::Surface(surface) => surface.projected.primitives(),
            Content::Flat(flat) => flat.projected.primitives(),
            Content::Smoke(smoke) => smoke.particles(),
            Content::Paper(paper) => paper.layers(),
        }
    }
}

/// The camera that is asked for, or the view that a scene is made for, unless there are several of it.
fn own_view(view: fn() -> Camera, options: &Options) -> Option<Camera> {
    let alone = options.instances.is_none_or(|instances| instances == 1);
    options.camera.or_else(|| alone.then(view))
}

fn surface(
    name: &str,
    mut parts: Vec<Part>,
    camera: Option<Camera>,
    info: Screen,
    options: &Options,
) -> Result<Scene, SceneError> {
    alpha::apply(name, &mut parts, &options.alphas)?;
    let room = Room::new(options.memory_limit);
    let parts = side_by_side(name, parts, options.instances.unwrap_or(1), room)?;
    let order = options.order.unwrap_or_default();
    let surface = Surface::new(Arc::new(parts), camera, info, order, &Sample::default());
    Ok(Scene::of(info, Content::Surface(Box::new(surface))))
}

/// Triangles that lie on the screen.
fn flat(
    name: &str,
    (vertices, triangles): (Vec<Vertex>, Vec<[u32; 3]>),
    info: Screen,
    options: &Options,
) -> Result<Scene, SceneError> {
    refuse_meshes(name, options)?;
    refuse(name, "a camera", options.camera.is_some())?;
    let order = options.order.unwrap_or_default();
    let flat = Flat::new(vertices, triangles, info, order, &Sample::default());
    Ok(Scene::of(info, Content::Flat(Box::new(flat))))
}

fn paper(name: &str, frame: Frame, info: Screen, options: &Options) -> Result<Scene, SceneError> {
    let scene = || name.to_owned();
    refuse_meshes(name, options)?;
    refuse(name, "a camera", options.camera.is_some())?;
    refuse(name, "an order of fragments", options.order.is_some())?;
    if info.width != DEFAULT_WIDTH {
        return Err(SceneError::FixedSize { scene: scene(), what: "width", side: info.width });
    }
    if info.height != DEFAULT_HEIGHT {
        return Err(SceneError::FixedSize { scene: scene(), what: "height", side: info.height });
    }
    Ok(Scene::of(info, Content::Paper(Paper::new(frame))))
}

/// Refuses what only meshes take, if it is given.
fn refuse_meshes(name: &str, options: &Options) -> Result<(), SceneError> {
    let given = [
        (!options.alphas.is_empty(), "an alpha"),
        (options.instances.is_some(), "a number of instances"),
        (matches!(options.sequence, Some(Sequence::Walk(_))), "a path"),
    ];
    match given.into_iter().find(|(given, _)| *given) {
        None => Ok(()),
        Some((_, what)) => Err(SceneError::NoMeshes { scene: name.into(), what }),
    }
}

/// Refuses what a list of pixels does not take, if it is given.
fn refuse(name: &str, what: &'static str, given: bool) -> Result<(), SceneError> {
    match given {
        false => Ok(()),
        true => Err(SceneError::Pixels { scene: name.into(), what }),
    }
}

#[cfg(test)]
mod tests;
