//! Lights the vertices of a scene and plays its triangles.
//!
//! One key light over the viewer's left shoulder, a sky that is brighter above, and a highlight on glossy parts. Both
//! sides of a surface are lit alike, since the inside of transparent things shows.

use super::Screen;
use super::camera::{Camera, View};
use super::clip::Vertex;
use super::contents::{Contents, Extension};
use super::geometry::Part;
use super::order::Order;
use super::paint::Paint;
use super::raster::Raster;
use super::set_up::point;
use super::splat::Ellipse;
use super::vary::{Sample, aspect};
use glam::{Vec2, Vec3, Vec4};
use pellucid_machine::pixel::Fragment;
use pellucid_machine::primitive::Primitive;
use std::ops::Range;
use std::sync::Arc;

/// Direction of the key light in the camera's right, up and back axes.
const KEY_LIGHT: Vec3 = Vec3::new(-0.45, 0.75, 0.6);
/// Radius of the light, in its distance.
const LIGHT_RADIUS: f32 = 0.3;
/// Sharpness of a highlight.
const SHININESS: i32 = 48;
/// Highest alpha that a rim or highlight gives to a transparent part.
const MOST_RIM_ALPHA: f32 = 0.95;

/// Parts as a camera sees them, lit.
#[derive(Debug)]
pub(super) struct Surface {
    parts: Arc<Vec<Part>>,
    /// Where they are seen from.
    pub camera: Camera,
    info: Screen,
    /// Their triangles.
    pub projected: Projected,
}

/// Projected triangles and splats in order of submission, with the colours of their corners.
#[derive(Debug)]
pub(super) struct Projected {
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
    /// In the order of their triangles.
    painted: Vec<Painted>,
    splats: Vec<Ellipse>,
    raster: Raster,
    info: Screen,
    order: Order,
}

/// What sends what becomes of a triangle.
type TriangleTo<T, E> =
    fn(&Raster, [Vertex; 3], &mut dyn FnMut(T) -> Result<(), E>) -> Result<(), E>;

/// Triangles of one part whose fragments are painted.
#[derive(Debug)]
struct Painted {
    triangles: Range<usize>,
    first_vertex: u32,
    paint: Arc<Paint>,
}

impl Surface {
    /// Lights the parts as seen by the camera, or by one that shows all of them if `None`, where what varies is at `sample`.
    pub fn new(
        parts: Arc<Vec<Part>>,
        camera: Option<Camera>,
        info: Screen,
        order: Order,
        sample: &Sample,
    ) -> Surface {
        let points: Vec<Vec3> = parts.iter().flat_map(|part| &part.positions).copied().collect();
        let aspect = aspect(info);
        let camera = camera.unwrap_or_else(|| Camera::framing(&points, aspect));
        let view = sample.seen(&camera, camera.view(&points, aspect), info);
        let light = light(&view, sample.light.as_vec2());
        let mut vertices = Vec::with_capacity(points.len());
        let mut triangles = Vec::with_capacity(parts.iter().map(|part| part.triangles.len()).sum());
        let (mut painted, mut splats) = (vec![], vec![]);
        for part in &*parts {
            if !part.splats.is_empty() {
                let seen = |i: usize| {
                    Ellipse::new(part.positions[i], part.splats[i], part.colours[i], &view, info)
                };
                splats.extend((0..part.splats.len()).filter_map(seen));
                continue;
            }
            let first = vertices.len() as u32;
            let first_triangle = triangles.len();
            triangles.extend(part.triangles.iter().map(|corners| corners.map(|i| first + i)));
            let normals = part.unit_normals();
            vertices.extend((0..part.positions.len()).map(|i| Vertex {
                clip: view.clip * part.positions[i].as_dvec3().extend(1.0),
                colour: lit(part, i, normals[i], &view, light),
            }));
            if let Some(paint) = part.paint.clone() {
                let triangles = first_triangle..triangles.len();
                painted.push(Painted { triangles, first_vertex: first, paint });
            }
        }
        let projected = Projected::new(vertices, triangles, info, order);
        let raster = projected.raster.sending_all(parts.iter().any(|part| part.sent_whole));
        let projected = Projected { painted, splats, raster, ..projected };
        Surface { parts, camera, info, projected }
    }

    /// What it is made of, with these extensions.
    pub fn contents(&self, extensions: &[Extension]) -> Contents {
        Contents::new(self.camera, &self.parts, extensions)
    }

    /// The same parts as another camera sees them, where what varies is at `sample`.
    pub fn seen_from(&self, camera: Camera, sample: &Sample) -> Surface {
        let (parts, order) = (self.parts.clone(), self.projected.order);
        Surface::new(parts, Some(camera), self.info, order, sample)
    }

    /// Whether light falls on any of it.
    pub fn is_lit(&self) -> bool {
        self.parts.iter().any(|part| part.splats.is_empty() && !part.unlit)
    }
}

impl Projected {
    /// Triangles by the numbers of their corners; the fragments of each come in this order.
    pub fn new(
        vertices: Vec<Vertex>,
        triangles: Vec<[u32; 3]>,
        info: Screen,
        order: Order,
    ) -> Projected {
        let (painted, splats, raster) = (vec![], vec![], Raster::new(info, order));
        Projected { vertices, triangles, painted, splats, raster, info, order }
    }

    /// How many triangles and splats a play goes through.
    pub fn primitives(&self) -> usize {
        self.triangles.len() + self.splats.len()
    }

    /// Sends the fragments of all triangles, then of all splats, in order of submission.
    pub fn play<E>(&self, sink: &mut dyn FnMut(Fragment) -> Result<(), E>) -> Result<(), E> {
        self.play_as(Raster::draw, |fragment| fragment, sink)
    }

    /// Sends all triangles, set up, or each fragment of those that are painted as a [`point`], then each fragment of the
    /// splats so, in order of submission.
    pub fn play_primitives<E>(
        &self,
        sink: &mut dyn FnMut(Primitive) -> Result<(), E>,
    ) -> Result<(), E> {
        self.play_as(Raster::set_up, point, sink)
    }

    /// Sends what `triangle` makes of the triangles, and `other` of each fragment that is none of theirs.
    fn play_as<T, E>(
        &self,
        triangle: TriangleTo<T, E>,
        other: fn(Fragment) -> T,
        sink: &mut dyn FnMut(T) -> Result<(), E>,
    ) -> Result<(), E> {
        for (triangles, painted) in self.runs() {
            for corners in &self.triangles[triangles] {
                match painted {
                    None => triangle(&self.raster, self.vertices(corners), sink)?,
                    Some(painted) => {
                        self.draw_painted(painted, corners, &mut |fragment| sink(other(fragment)))?
                    }
                }
            }
        }
        let mut each = |fragment| sink(other(fragment));
        self.splats.iter().try_for_each(|splat| splat.draw(self.info, self.order, &mut each))
    }

    fn vertices(&self, corners: &[u32; 3]) -> [Vertex; 3] {
        corners.map(|i| self.vertices[i as usize])
    }

    fn draw_painted<E>(
        &self,
        Painted { first_vertex, paint, .. }: &Painted,
        corners: &[u32; 3],
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        let vertices = self.vertices(corners);
        let corners = corners.map(|i| (i - first_vertex) as usize);
        let mut paint = paint.paint(corners, &vertices, self.info, sink);
        self.raster.draw(vertices, &mut paint)
    }

    /// All triangles in order, in runs that are painted alike.
    fn runs(&self) -> impl Iterator<Item = (Range<usize>, Option<&Painted>)> {
        let starts = std::iter::once(0).chain(self.painted.iter().map(|p| p.triangles.end));
        let nexts = self.painted.iter().map(Some).chain([None]);
        starts.zip(nexts).flat_map(|(start, next)| {
            let end = next.map_or(self.triangles.len(), |next| next.triangles.start);
            let painted = next.map(|next| (next.triangles.clone(), Some(next)));
            [(start..end, None)].into_iter().chain(painted)
        })
    }
}

/// The direction of the key light from this place of it, in its radii.
fn light(view: &View, place: Vec2) -> Vec3 {
    let [right, up, back] = view.axes.map(|axis| axis.as_vec3());
    let (distance, (u, v)) = (KEY_LIGHT.length(), KEY_LIGHT.normalize().any_orthonormal_pair());
    let from = KEY_LIGHT + LIGHT_RADIUS * distance * (place.x * u + place.y * v);
    (from.x * right + from.y * up + from.z * back).normalize()
}

/// Colour of vertex `i`, 0..=255 per channel; of a part that is painted, what multiplies it.
fn lit(part: &Part, i: usize, normal: Vec3, view: &View, light: Vec3) -> Vec4 {
    let to_eye =
        (view.eye - part.positions[i].as_dvec3()).try_normalize().unwrap_or(view.axes[2]).as_vec3();
    let normal = if normal.dot(to_eye) < 0.0 { -normal } else { normal };

    let sky = 0.5 + 0.5 * normal.y;
    let diffuse = normal.dot(light).max(0.0);
    let brightness = if part.unlit { 1.0 } else { 0.46 + 0.14 * sky + 0.5 * diffuse };
    if part.paint.is_some() {
        return Vec4::splat(brightness);
    }
    let base = part.colours.get(i).copied().unwrap_or_else(|| by_normal(normal).extend(part.alpha));
    let highlight =
        part.gloss * normal.dot((light + to_eye).normalize_or_zero()).max(0.0).powi(SHININESS);
    let colour = base.truncate() * brightness + highlight;
    let edge_on = (1.0 - normal.dot(to_eye).clamp(0.0, 1.0)).powi(2);
    let more = part.rim * (edge_on + highlight).min(1.0) * (MOST_RIM_ALPHA - base.w).max(0.0);
    // A whole number of 255ths, so that a uniform alpha comes out of the interpolation as one value.
    let alpha = (255.0 * (base.w + more)).round();
    (255.0 * colour.clamp(Vec3::ZERO, Vec3::ONE)).extend(alpha)
}

/// A soft colour that tells where a surface faces.
fn by_normal(normal: Vec3) -> Vec3 {
    Vec3::new(0.62, 0.66, 0.72) + Vec3::new(0.3, 0.26, 0.24) * normal
}
