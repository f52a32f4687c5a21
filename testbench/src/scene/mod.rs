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
mod geometry;
mod instances;
mod mesh;
mod order;
mod paint;
mod perspective;
mod raster;
mod set_up;
mod shade;
mod splat;
mod srgb;
mod texture;
mod walk;

pub use alpha::{AlphaRule, AlphaRuleError};
pub use built_in::{BuiltIn, built_in, is_built_in};
pub use camera::{Camera, CameraError};
pub use contents::{Contents, Extension, Handling, PartContents, TextureContents};
pub use error::SceneError;
pub use geometry::AlphaMode;
pub use instances::MOST_INSTANCES;
pub use order::{Order, OrderError};
pub use set_up::point;
pub use walk::{CameraPath, CameraPathError, Walk};

use crate::room::{Limit, Room};
use built_in::paper::{Frame, Paper};
use built_in::quads::Quads;
use built_in::smoke::Smoke;
use clip::Vertex;
use geometry::{DEFAULT_ALPHA, Part};
use instances::side_by_side;
use pellucid_machine::pixel::{Fragment, MAX_SIDE, Screen};
use pellucid_machine::primitive::Primitive;
use shade::{Projected, Surface};
use std::sync::Arc;

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
    /// The way of the camera through several frames; see [`Scene::turned`] and [`Scene::moved`] if `None`.
    pub walk: Option<Walk>,
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
    /// The file of a mesh that moves, and how it is seen.
    moving: Option<Box<(String, Options)>>,
    /// The way of the camera, and the view that it starts from.
    walk: Option<Box<(Walk, Camera)>>,
}

#[derive(Debug)]
enum Content {
    Surface(Box<Surface>),
    Flat(Projected),
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
        Scene::open_at(name, options, 0.0)
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
                    let moving = moves.then(|| {
                        let camera = scene.surface().map(|surface| surface.camera);
                        let options = Options { camera, walk: None, ..options.clone() };
                        Box::new((name.to_owned(), options))
                    });
                    Ok(Scene { notes, extensions, moving, ..scene })
                }
            },
        }
    }

    fn of(info: Screen, content: Content) -> Scene {
        Scene { info, content, notes: vec![], extensions: vec![], moving: None, walk: None }
    }

    /// What is to be said of the file, each as one sentence: what of it is not drawn, or drawn by a rule.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// What it is made of; nothing if it is not made of meshes.
    pub fn contents(&self) -> Option<Contents> {
        self.surface().map(|surface| surface.contents(&self.extensions))
    }

    /// The scene so many seconds later, from this camera or the same as now; nothing if nothing of it moves.
    ///
    /// # Errors
    /// The mesh file, which is read again, is not what it was.
    pub fn moved(&self, seconds: f32, camera: Option<Camera>) -> Result<Option<Scene>, SceneError> {
        let moved = |(name, options): &(String, Options)| {
            let camera = camera.or(options.camera);
            Scene::open_at(name, &Options { camera, ..options.clone() }, seconds)
        };
        self.moving.as_deref().map(moved).transpose()
    }

    /// The first frame of a way of the camera that starts from its view.
    fn along(self, walk: Walk) -> Scene {
        let Content::Surface(surface) = &self.content else { return self };
        let view = surface.camera;
        let first = surface.seen_from(walk.camera(view, 0));
        Scene {
            content: Content::Surface(Box::new(first)),
            walk: Some(Box::new((walk, view))),
            ..self
        }
    }

    /// Where the camera is so many frames later, if it has a way.
    pub fn camera_later(&self, frames: u32) -> Option<Camera> {
        self.walk.as_deref().map(|(walk, view)| walk.camera(*view, frames))
    }

    /// Its meshes, if it is made of such.
    fn surface(&self) -> Option<&Surface> {
        match &self.content {
            Content::Surface(surface) => Some(surface),
            Content::Flat(_) | Content::Smoke(_) | Content::Paper(_) => None,
        }
    }

    /// The scene after its camera has gone round what it looks at by so many degrees, about a vertical axis,
    /// counter-clockwise as seen from above. Only scenes of triangles can be seen so.
    pub fn turned(&self, degrees: f64) -> Option<Scene> {
        self.seen_from(self.surface()?.camera.turned(degrees))
    }

    /// The scene from another camera. Only scenes of triangles can be seen so.
    pub fn seen_from(&self, camera: Camera) -> Option<Scene> {
        let seen = self.surface()?.seen_from(camera);
        Some(Scene::of(self.info, Content::Surface(Box::new(seen))))
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
            Content::Flat(flat) => flat.play(sink),
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
            Content::Flat(flat) => flat.play_primitives(sink),
            Content::Smoke(_) | Content::Paper(_) => {
                self.play(&mut |fragment| sink(point(fragment)))
            }
        }
    }

    /// How many triangles, splats, particles or pixel layers a call of [`Scene::play`] goes through.
    pub fn primitives(&self) -> usize {
        match &self.content {
            Content::Surface(surface) => surface.projected.primitives(),
            Content::Flat(flat) => flat.primitives(),
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
    let surface = Surface::new(Arc::new(parts), camera, info, order);
    let scene = Scene::of(info, Content::Surface(Box::new(surface)));
    Ok(match options.walk {
        None => scene,
        Some(walk) => scene.along(walk),
    })
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
    Ok(Scene::of(info, Content::Flat(Projected::new(vertices, triangles, info, order))))
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
        (options.walk.is_some(), "a path"),
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
