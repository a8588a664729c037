//! How far a pixel reaches on a surface that no perspective shows directly, estimated without differentials carried along paths.
//!
//! The smallest change of position and direction from a pixel to the next, over the film's diagonal, stands for all pixels: textures
//! are then never blurred more than the finest pixel allows.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 10.1.2. Deviation: changes are measured
//! over a whole pixel, and in the frame in which they are used, which makes the ellipses of anisotropic filters lie right.

use sahl_math::{Frame, Ray, Vec2, Vec3};

use super::CameraRay;

/// Places along the diagonal that are looked at.
const PLACES: u32 = 256;

/// The least change of a ray to the next pixel in the row, and in the column: of its origin in camera space, and of its
/// direction in the frame about it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Differentials {
    origin: [Vec3; 2],
    direction: [Vec3; 2],
}

impl Differentials {
    /// Those of a camera that makes rays by `ray`, for an image of `resolution` pixels. Zero for a camera without rays.
    pub(super) fn least(resolution: [u32; 2], ray: impl Fn(Vec2) -> CameraRay) -> Self {
        let mut least = [[None; 2]; 2];
        let keep = |least: &mut Option<Vec3>, found: Vec3| {
            if least.is_none_or(|least: Vec3| found.length_squared() < least.length_squared()) {
                *least = Some(found);
            }
        };
        let diagonal = Vec2::new(resolution[0] as f32, resolution[1] as f32);
        for i in 0..PLACES {
            let film = diagonal * ((i as f32 + 0.5) / PLACES as f32);
            let Some((origin, frame)) = seen(&ray(film)) else { continue };
            for (axis, step) in [Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)].into_iter().enumerate() {
                // To the other side where the lens lets the first not through.
                let next = [step, -step].into_iter().find_map(|step| {
                    let next = seen(&ray(film + step))?;
                    Some((next, step.x + step.y))
                });
                let Some(((next_origin, next_frame), sign)) = next else { continue };
                keep(&mut least[0][axis], (next_origin - origin) * sign);
                let direction = frame.to_local(next_frame.z) - Vec3::Z;
                keep(&mut least[1][axis], direction * sign);
            }
        }
        let [origin, direction] = least.map(|axes| axes.map(|least| least.unwrap_or(Vec3::ZERO)));
        Self { origin, direction }
    }

    /// How a point of the plane through `p` with normal `n` moves from pixel to pixel; all in camera space. Zero where the
    /// plane is seen edge-on.
    pub(super) fn at(&self, p: Vec3, n: Vec3) -> [Vec3; 2] {
        let distance = p.length();
        let Some(view) = p.try_normalize() else { return [Vec3::ZERO; 2] };
        let frame = Frame::from_z(view);
        let n = frame.to_local(n);
        std::array::from_fn(|axis| {
            let (origin, change) = (self.origin[axis], self.direction[axis]);
            // How much farther along the axis the next ray meets the plane; without this form the digits would cancel.
            let farther = -(n.dot(origin) + distance * n.dot(change)) / (n.z + n.dot(change));
            let moved = origin + change * (distance + farther) + Vec3::Z * farther;
            let moved = frame.x * moved.x + frame.y * moved.y + frame.z * moved.z;
            if moved.is_finite() { moved } else { Vec3::ZERO }
        })
    }
}

/// Where a ray starts and the frame about its direction; `None` if the lens blocks it.
fn seen(CameraRay { ray: Ray { origin, direction, .. }, weight }: &CameraRay) -> Option<(Vec3, Frame)> {
    let direction = direction.try_normalize()?;
    (*weight > 0.0).then(|| (*origin, Frame::from_z(direction)))
}
