//! Sets of rays that find the seams of a closed mesh.

use sahl_math::{Ray, Vec3};

use crate::meshes::Mesh;
use crate::random::Rng;

/// From `origin` exactly at each vertex. Directions are not normalised: `t = 1` is the vertex, up to rounding.
pub fn at_vertices(mesh: &Mesh, origin: Vec3) -> impl Iterator<Item = Ray> + '_ {
    mesh.positions.iter().map(move |&p| Ray::new(origin, p - origin))
}

/// From `origin` at the midpoint of each edge; `t = 1` is the midpoint, up to rounding.
pub fn at_edges(mesh: &Mesh, origin: Vec3) -> impl Iterator<Item = Ray> + '_ {
    mesh.edges().into_iter().map(move |edge| {
        let [a, b] = edge.map(|i| mesh.positions[i as usize]);
        Ray::new(origin, a * 0.5 + b * 0.5 - origin)
    })
}

/// Rays parallel to the axes through each vertex, both ways, which start `distance` away from it.
///
/// In the coordinates across the ray, a ray passes through its vertex exactly: no rounding helps to miss a seam.
pub fn axis_parallel(mesh: &Mesh, distance: f32) -> impl Iterator<Item = Ray> + '_ {
    let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    mesh.positions.iter().flat_map(move |&p| axes.into_iter().map(move |d| Ray::new(p - d * distance, d)))
}

/// `count` rays from uniform points of the box between `low` and `high` in uniform directions.
pub fn random(low: Vec3, high: Vec3, count: usize, seed: u64) -> impl Iterator<Item = Ray> {
    let mut rng = Rng::new(seed);
    (0..count).map(move |_| Ray::new(rng.point(low, high), rng.direction()))
}

/// `count` rays from random points of a sphere about `centre` to random points of the smaller, concentric `target`.
///
/// What a camera outside an object sends: nearly all of them come near it.
pub fn toward(centre: Vec3, radius: f32, target: f32, count: usize, seed: u64) -> impl Iterator<Item = Ray> {
    let mut rng = Rng::new(seed);
    (0..count).map(move |_| {
        let origin = centre + rng.direction() * radius;
        let aim = centre + rng.direction() * (target * rng.next_f32().cbrt());
        Ray::new(origin, (aim - origin).normalize())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meshes::{cube, icosphere};

    #[test]
    fn seams_are_aimed_at() {
        let mesh = icosphere(1);
        let origin = Vec3::new(0.1, 0.2, -0.1);
        let vertices: Vec<Ray> = at_vertices(&mesh, origin).collect();
        assert_eq!(vertices.len(), mesh.positions.len());
        for (ray, &p) in vertices.iter().zip(&mesh.positions) {
            assert!((ray.at(1.0) - p).length() < 1e-6);
        }
        let edges = mesh.edges();
        assert_eq!(edges.len(), 120);
        for (ray, edge) in at_edges(&mesh, origin).zip(edges) {
            let [a, b] = edge.map(|i| mesh.positions[i as usize]);
            assert!((ray.at(1.0) - (a + b) * 0.5).length() < 1e-6);
        }
    }

    #[test]
    fn axis_parallel_rays_keep_the_coordinates_of_their_vertex() {
        let mesh = cube(3).map(|p| p * 0.1);
        let rays: Vec<Ray> = axis_parallel(&mesh, 5.0).collect();
        assert_eq!(rays.len(), 6 * mesh.positions.len());
        for (i, ray) in rays.iter().enumerate() {
            let p = mesh.positions[i / 6];
            let kept = (0..3).filter(|&axis| ray.origin[axis] == p[axis]).count();
            assert!(kept >= 2, "{ray:?} through {p:?}");
        }
    }

    #[test]
    fn random_rays_start_in_the_box_and_aimed_ones_hit_the_ball() {
        let (low, high) = (Vec3::splat(-1.0), Vec3::new(1.0, 2.0, 3.0));
        let rays: Vec<Ray> = random(low, high, 500, 9).collect();
        assert!(rays.iter().all(|r| r.origin.min(low) == low && r.origin.max(high) == high));
        assert_eq!(rays, random(low, high, 500, 9).collect::<Vec<_>>());
        let centre = Vec3::new(3.0, -2.0, 1.0);
        for ray in toward(centre, 10.0, 2.0, 500, 9) {
            let to_centre = centre - ray.origin;
            let nearest = (to_centre - ray.direction * to_centre.dot(ray.direction)).length();
            assert!(nearest <= 2.001, "{nearest}");
        }
    }
}
