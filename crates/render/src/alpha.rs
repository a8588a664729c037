//! Surfaces that are partly there: alpha masks.
//!
//! Where a ray meets such a surface, alpha is the probability that the surface is there for that ray; the decision is a hash of the ray
//! and the hit, so that a sample stays a pure function of what it is of. The accelerator asks for it as a filter of hits while it
//! searches: a surface that is not there hides nothing, not even what lies in the same place.
//!
//! In a scene file: `Shape "plymesh" "string filename" "leaf.ply" "texture alpha" "leaf-shape"`.
//!
//! Source: Stochastic transparency of Enderton et al., *Stochastic Transparency*, 2010, as pbrt-v4 does it; there the ray starts anew from
//! the surface.

use sahl_accel::Hit;
use sahl_math::{Ray, Vec3};

use crate::sampler::{mix, to_unit};
use crate::scene::SceneData;
use crate::texture::TexturePoint;

impl SceneData {
    /// Where `ray` first meets a surface that is there.
    #[inline]
    pub(crate) fn first_hit(&self, ray: &Ray) -> Option<Hit> {
        if self.has_alpha { self.first_there(ray) } else { self.accel.intersect(ray) }
    }

    /// Whether any surface along `ray` is there.
    #[inline]
    pub(crate) fn is_occluded(&self, ray: &Ray) -> bool {
        if self.has_alpha { self.is_anything_there(ray) } else { self.accel.occluded(ray) }
    }

    /// [`Self::first_hit`] of many rays; `alike` says that those that follow each other go nearly the same way.
    pub(crate) fn first_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], alike: bool) {
        if alike {
            self.accel.intersect_coherent(rays, hits);
        } else {
            self.accel.intersect_batch(rays, hits);
        }
        if self.has_alpha {
            for (ray, hit) in rays.iter().zip(hits) {
                if hit.is_some_and(|hit| !self.is_there(ray, &hit)) {
                    *hit = self.first_there(ray);
                }
            }
        }
    }

    /// [`Self::is_occluded`] of many rays.
    pub(crate) fn are_occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.accel.occluded_batch(rays, occluded);
        if self.has_alpha {
            for (ray, occluded) in rays.iter().zip(occluded) {
                *occluded = *occluded && self.is_anything_there(ray);
            }
        }
    }

    #[inline(never)]
    fn first_there(&self, ray: &Ray) -> Option<Hit> {
        self.accel.intersect_filtered(ray, |hit| self.is_there(ray, hit))
    }

    #[inline(never)]
    fn is_anything_there(&self, ray: &Ray) -> bool {
        self.accel.occluded_filtered(ray, |hit| self.is_there(ray, hit))
    }

    /// Whether the surface is there for a ray that meets it; asked about surfaces with alpha alone.
    #[inline(never)]
    fn is_there(&self, ray: &Ray, hit: &Hit) -> bool {
        let Some(alpha) = &self.attributes[hit.geometry as usize].alpha else { return true };
        let at = self.interaction(ray, hit);
        let point =
            TexturePoint { uv: at.uv, p: at.p, n: at.ng, face: self.face(&at), ..TexturePoint::default() };
        chance(ray, hit) < self.textures.float(alpha, &point)
    }
}

/// A number in [0, 1) that looks random, and is the same for the same hit of the same ray.
fn chance(ray: &Ray, hit: &Hit) -> f32 {
    let mut key = 0;
    let mut add = |a: u32, b: u32| key = mix(key ^ (u64::from(a) | u64::from(b) << 32));
    let bits = |v: Vec3| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits()];
    let ([ox, oy, oz], [dx, dy, dz]) = (bits(ray.origin), bits(ray.direction));
    add(ox, oy);
    add(oz, dx);
    add(dy, dz);
    add(hit.t.to_bits(), hit.geometry);
    add(hit.primitive, hit.instance);
    to_unit((key >> 32) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chances_are_even_and_differ_from_hit_to_hit() {
        let ray = Ray::new(Vec3::new(0.3, -2.0, 1e3), Vec3::new(0.1, 0.7, -0.5));
        let hit = Hit { t: 1.0, u: 0.5, v: 0.5, geometry: 3, primitive: 7, instance: 2 };
        let mut counts = [0; 10];
        for i in 0..20_000 {
            let mut ray = ray;
            ray.direction.x += i as f32 * 1e-5;
            let first = chance(&ray, &hit);
            assert_eq!(first, chance(&ray, &hit));
            assert!((0.0..1.0).contains(&first));
            counts[(first * 10.0) as usize] += 1;
        }
        assert!(counts.iter().all(|&count: &i32| (count - 2000).abs() < 180), "{counts:?}");
        let others = [Hit { t: 1.5, ..hit }, Hit { geometry: 4, ..hit }, Hit { primitive: 8, ..hit }];
        assert!(others.iter().all(|other| chance(&ray, other) != chance(&ray, &hit)));
    }
}
