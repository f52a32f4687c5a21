//! The same meshes several times, side by side.

use super::SceneError;
use super::contents::around;
use super::geometry::{Part, TRIANGLE_BYTES, VERTEX_BYTES};
use crate::room::Room;
use glam::Vec3;

/// The most instances.
pub const MOST_INSTANCES: u32 = 1000;

/// So many instances of the parts along x, all parts of one before those of the next. Each begins where the bounding box of the
/// one before ends; boxes without a width are as far apart as their longest side.
///
/// # Errors
/// There are none or too many of them, they find no room, or their places are beyond single precision.
pub(super) fn side_by_side(
    name: &str,
    parts: Vec<Part>,
    instances: u32,
    mut room: Room,
) -> Result<Vec<Part>, SceneError> {
    if !(1..=MOST_INSTANCES).contains(&instances) {
        return Err(SceneError::Instances { instances });
    }
    if instances == 1 {
        return Ok(parts);
    }
    let bytes = |part: &Part| {
        (part.positions.len() * VERTEX_BYTES + part.triangles.len() * TRIANGLE_BYTES) as u64
    };
    let each: u64 = parts.iter().map(bytes).sum();
    room.take(each.saturating_mul(instances.into()))
        .map_err(|source| SceneError::Memory { path: name.into(), source })?;
    let points = parts.iter().flat_map(|part| &part.positions).copied();
    let [low, high] = around(points).unwrap_or_default().map(Vec3::from);
    let size = high - low;
    let step = if size.x > 0.0 { size.x } else { size.max_element() };
    if !(high.x + step * instances as f32).is_finite() {
        return Err(SceneError::Beyond { scene: name.into(), instances });
    }
    let mut all = Vec::with_capacity(parts.len() * instances as usize);
    for instance in 1..instances {
        let shift = Vec3::X * (step * instance as f32);
        all.extend(parts.iter().cloned().map(|mut part| {
            part.positions.iter_mut().for_each(|position| *position += shift);
            part
        }));
    }
    Ok([parts, all].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(positions: &[Vec3]) -> Part {
        let mut part = Part::new(vec!["part".into()]);
        part.positions = positions.to_vec();
        part.triangles = vec![[0, 1, 2]];
        part
    }

    fn placed(parts: Vec<Part>, instances: u32) -> Result<Vec<Part>, SceneError> {
        side_by_side("mesh.obj", parts, instances, Room::new("1M".parse().ok()))
    }

    #[test]
    fn each_begins_where_the_box_of_the_one_before_ends() {
        let parts = vec![
            part(&[Vec3::new(-1.0, 0.0, 0.0), Vec3::ZERO, Vec3::Y]),
            part(&[Vec3::Z, Vec3::new(2.0, 5.0, 0.0), Vec3::ZERO]),
        ];
        let all = placed(parts.clone(), 3).unwrap();
        assert_eq!(all.len(), 6);
        for (k, part) in all.iter().enumerate() {
            let shift = Vec3::X * 3.0 * (k / 2) as f32;
            let expected: Vec<Vec3> = parts[k % 2].positions.iter().map(|p| *p + shift).collect();
            assert_eq!((&part.positions, &part.triangles), (&expected, &vec![[0, 1, 2]]), "{k}");
        }
        // All in one plane across x.
        let flat = placed(vec![part(&[Vec3::ZERO, Vec3::Y, Vec3::Z * 4.0])], 2).unwrap();
        assert_eq!(flat[1].positions[0], Vec3::X * 4.0);
    }

    #[test]
    fn what_cannot_be_placed_is_refused() {
        let parts = || vec![part(&[Vec3::ZERO, Vec3::X * 1e38, Vec3::Y])];
        let refused = |instances| placed(parts(), instances).unwrap_err().to_string();
        assert_eq!(
            refused(9),
            "mesh.obj: 9 instances side by side do not fit into the range of coordinates, expected fewer"
        );
        for instances in [0, 1001] {
            let expected = format!("{instances} instances are out of range: expected 1..=1000");
            assert_eq!(refused(instances), expected);
        }
        let many = part(&vec![Vec3::X; 100]);
        let error = placed(vec![many], 100).unwrap_err().to_string();
        assert!(
            error.starts_with("mesh.obj: does not fit into the memory that a scene may take, 1M"),
            "{error}"
        );
    }
}
