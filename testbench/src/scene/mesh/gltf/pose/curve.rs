//! A value over time between key frames (glTF 2.0, 3.11 and appendix C).

use super::super::buffers::Buffers;
use ::gltf::animation::{Channel, Interpolation, Property};
use glam::Quat;

/// Values at times that grow, and how they go on between these.
pub(super) struct Curve {
    interpolation: Interpolation,
    times: Vec<f32>,
    /// Numbers of one value.
    width: usize,
    /// A value for each time; of a cubic spline the tangent before it, itself, and the tangent behind it.
    values: Vec<f32>,
}

impl Curve {
    /// Bytes that the curve of a channel takes.
    pub fn bytes(channel: &Channel) -> usize {
        let [times, values] = [channel.sampler().input(), channel.sampler().output()]
            .map(|accessor| accessor.count().saturating_mul(accessor.dimensions().multiplicity()));
        times.saturating_add(values).saturating_mul(2 * size_of::<f32>())
    }

    /// What a channel says, with at least one time. The error says what is wrong with it.
    pub fn read(channel: &Channel, buffers: &Buffers) -> Result<Curve, String> {
        let sampler = channel.sampler();
        let (input, output) = (sampler.input(), sampler.output());
        if input.view().is_none() || input.count() == 0 {
            return Err("has no times".into());
        }
        let times: Vec<f32> = buffers.vectors::<1>(&input, input.count())?.into_flattened();
        if times.windows(2).any(|pair| pair[0] >= pair[1]) || times.iter().any(|t| !t.is_finite()) {
            return Err("has times that do not grow".into());
        }
        let interpolation = sampler.interpolation();
        let each = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let found = output.count();
        let weights = match channel.target().property() {
            Property::MorphTargetWeights => {
                let mesh = channel.target().node().mesh();
                let primitive = mesh.and_then(|mesh| mesh.primitives().next());
                primitive.map_or(0, |primitive| primitive.morph_targets().count())
            }
            _ => 1,
        };
        let expected = times.len().saturating_mul(each * weights);
        if found != expected {
            return Err(format!("has {found} values of a curve, expected {expected}"));
        }
        let (width, values) = match channel.target().property() {
            Property::Translation | Property::Scale => {
                (3, buffers.vectors::<3>(&output, found)?.into_flattened())
            }
            Property::Rotation => (4, buffers.vectors::<4>(&output, found)?.into_flattened()),
            Property::MorphTargetWeights => {
                (weights, buffers.vectors::<1>(&output, found)?.into_flattened())
            }
        };
        Ok(Curve { interpolation, times, width, values })
    }

    /// The last of the times.
    pub fn end(&self) -> f32 {
        self.times[self.times.len() - 1]
    }

    /// The value at a time; before the first and behind the last as there.
    pub fn at(&self, seconds: f32) -> Vec<f32> {
        let Some((from, to, part)) = self.span(seconds) else {
            return self.key(self.edge(seconds), 1).to_vec();
        };
        let (a, b) = (self.key(from, 1), self.key(to, 1));
        let mix = |f: &dyn Fn(usize) -> f32| (0..self.width).map(f).collect();
        match self.interpolation {
            Interpolation::Step => a.to_vec(),
            Interpolation::Linear => mix(&|i| a[i] + (b[i] - a[i]) * part),
            Interpolation::CubicSpline => {
                let (leave, arrive) = (self.key(from, 2), self.key(to, 0));
                let length = self.times[to] - self.times[from];
                let (t, t2, t3) = (part, part * part, part * part * part);
                mix(&|i| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a[i]
                        + length * (t3 - 2.0 * t2 + t) * leave[i]
                        + (3.0 * t2 - 2.0 * t3) * b[i]
                        + length * (t3 - t2) * arrive[i]
                })
            }
        }
    }

    /// A value that is a rotation; between two that are linear it turns at an even speed, the shorter way.
    pub fn rotation(&self, seconds: f32) -> Quat {
        let key = |i| Quat::from_slice(self.key(i, 1)).normalize();
        match (self.span(seconds), self.interpolation) {
            (Some((from, to, part)), Interpolation::Linear) => key(from).slerp(key(to), part),
            _ => Quat::from_slice(&self.at(seconds)).normalize(),
        }
    }

    /// The times around a time, and how much of the way from one to the other it is; nothing outside of all.
    fn span(&self, seconds: f32) -> Option<(usize, usize, f32)> {
        let to = self.times.partition_point(|time| *time <= seconds);
        let from = to.checked_sub(1)?;
        let end = self.times.get(to)?;
        Some((from, to, (seconds - self.times[from]) / (end - self.times[from])))
    }

    /// The time that is nearest to one outside of all.
    fn edge(&self, seconds: f32) -> usize {
        if seconds < self.times[0] { 0 } else { self.times.len() - 1 }
    }

    /// The value at a time's number, `part` 1, or of a cubic spline its tangents, 0 before and 2 behind it.
    fn key(&self, time: usize, part: usize) -> &[f32] {
        let at = match self.interpolation {
            Interpolation::CubicSpline => 3 * time + part,
            _ => time,
        };
        &self.values[at * self.width..(at + 1) * self.width]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_8};

    fn curve(interpolation: Interpolation, width: usize, values: &[f32]) -> Curve {
        Curve { interpolation, times: vec![1.0, 3.0], width, values: values.to_vec() }
    }

    #[test]
    fn a_value_is_interpolated_as_its_curve_says() {
        use Interpolation::{CubicSpline, Linear, Step};
        let at = |curve: &Curve| [0.0, 1.0, 1.5, 3.0, 9.0].map(|time| curve.at(time)[0]);
        assert_eq!(at(&curve(Linear, 1, &[2.0, 6.0])), [2.0, 2.0, 3.0, 6.0, 6.0]);
        assert_eq!(at(&curve(Step, 1, &[2.0, 6.0])), [2.0, 2.0, 2.0, 6.0, 6.0]);
        // A quarter on: 27/32 of the first value, 5/32 of the second, and the tangents, over 2 seconds,
        // times 9/64 and -3/64.
        let cubic = curve(CubicSpline, 1, &[7.0, 32.0, 32.0, 64.0, 64.0, 7.0]);
        assert_eq!(at(&cubic), [32.0, 32.0, 27.0 + 9.0 + 10.0 - 6.0, 64.0, 64.0]);
    }

    #[test]
    fn a_rotation_turns_at_an_even_speed_the_shorter_way() {
        // A quarter turn about z, with the sign that would go the longer way.
        let values = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -FRAC_1_SQRT_2, -FRAC_1_SQRT_2];
        let turned = curve(Interpolation::Linear, 4, &values).rotation(2.0);
        assert!(turned.dot(Quat::from_rotation_z(2.0 * FRAC_PI_8)).abs() > 1.0 - 1e-6, "{turned}");
    }
}
