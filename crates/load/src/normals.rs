//! Repair of vertex normals.

use sahl_math::Vec3;

/// Replaces normals that are zero or not finite by the area-weighted mean of the normals of the triangles about the
/// vertex, or by +z where those cancel or there are none. Returns how many vertices of triangles had such a normal:
/// what stands at other vertices matters to nobody.
///
/// `triangles` must hold indices below the number of positions, which is that of normals.
pub(crate) fn repair(
    normals: &mut [Vec3],
    positions: &[Vec3],
    triangles: impl Iterator<Item = [u32; 3]>,
) -> usize {
    let broken = |normal: &Vec3| normal.try_normalize().is_none();
    if !normals.iter().any(broken) {
        return 0;
    }
    let is_broken: Vec<bool> = normals.iter().map(broken).collect();
    for (normal, &is_broken) in normals.iter_mut().zip(&is_broken) {
        if is_broken {
            *normal = Vec3::ZERO;
        }
    }
    let mut is_used = vec![false; normals.len()];
    for triangle in triangles {
        let corners = triangle.map(|index| index as usize);
        if !corners.iter().any(|&corner| is_broken[corner]) {
            continue;
        }
        let [a, b, c] = corners.map(|corner| positions[corner]);
        let area_normal = (b - a).cross(c - a);
        for corner in corners {
            if is_broken[corner] {
                normals[corner] += area_normal;
                is_used[corner] = true;
            }
        }
    }
    for (normal, is_broken) in normals.iter_mut().zip(is_broken) {
        if is_broken {
            *normal = normal.try_normalize().unwrap_or(Vec3::Z);
        }
    }
    is_used.into_iter().filter(|&is_used| is_used).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_normals_come_from_the_faces() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE];
        let mut normals = [Vec3::ZERO, Vec3::splat(f32::NAN), Vec3::X, Vec3::splat(f32::INFINITY)];
        let count = repair(&mut normals, &positions, [[0, 2, 1]].into_iter());
        assert_eq!(count, 2);
        assert_eq!(normals, [-Vec3::Z, -Vec3::Z, Vec3::X, Vec3::Z]);
    }

    #[test]
    fn sound_normals_stay() {
        let mut normals = [Vec3::new(0.0, 3.0, 0.0)];
        assert_eq!(repair(&mut normals, &[Vec3::ZERO], std::iter::empty()), 0);
        assert_eq!(normals, [Vec3::new(0.0, 3.0, 0.0)]);
    }
}
