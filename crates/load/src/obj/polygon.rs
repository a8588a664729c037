//! Polygons into triangles.

use sahl_math::Vec3;

/// Polygons with more corners than this are split into fans, convex or not: clipping ears takes cubic time.
const MOST_CORNERS: usize = 64;

/// Splits a polygon into triangles, given as positions in `corners`, each turning the same way as the polygon.
///
/// A convex polygon becomes a fan. Of any other, ears are clipped one after the other (Meisters 1975, "Polygons have
/// ears"), seen along its mean normal (Newell's method); what then is left without an ear, because the polygon crosses
/// itself, becomes a fan. Fewer than three corners give nothing.
pub(super) fn triangulate(corners: &[Vec3], mut triangle: impl FnMut([usize; 3])) {
    let count = corners.len();
    let mut left: Vec<usize> = (0..count).collect();
    if count > 3 && count <= MOST_CORNERS {
        let points = flatten(corners);
        while left.len() > 3 && !is_convex(&points, &left) {
            let Some(ear) = find_ear(&points, &left) else { break };
            triangle(around(&left, ear));
            left.remove(ear);
        }
    }
    for pair in left.get(1..).unwrap_or_default().windows(2) {
        triangle([left[0], pair[0], pair[1]]);
    }
}

/// A corner of the polygon that is left, with its neighbours.
fn around(left: &[usize], at: usize) -> [usize; 3] {
    let count = left.len();
    [left[(at + count - 1) % count], left[at], left[(at + 1) % count]]
}

/// The corners seen along the mean normal, turning counter-clockwise.
fn flatten(corners: &[Vec3]) -> Vec<[f64; 2]> {
    let mut normal = [0.0; 3];
    let wide = |p: Vec3| [f64::from(p.x), f64::from(p.y), f64::from(p.z)];
    for (at, &corner) in corners.iter().enumerate() {
        let (p, q) = (wide(corner), wide(corners[(at + 1) % corners.len()]));
        for (axis, component) in normal.iter_mut().enumerate() {
            let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
            *component += (p[a] - q[a]) * (p[b] + q[b]);
        }
    }
    let largest = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(2);
    let (mut a, mut b) = ((largest + 1) % 3, (largest + 2) % 3);
    if normal[largest] < 0.0 {
        std::mem::swap(&mut a, &mut b);
    }
    corners.iter().map(|&corner| [wide(corner)[a], wide(corner)[b]]).collect()
}

/// Twice the signed area of a triangle: positive where it turns counter-clockwise.
fn area(points: &[[f64; 2]], [a, b, c]: [usize; 3]) -> f64 {
    let (a, b, c) = (points[a], points[b], points[c]);
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn is_convex(points: &[[f64; 2]], left: &[usize]) -> bool {
    (0..left.len()).all(|at| area(points, around(left, at)) >= 0.0)
}

/// A corner whose triangle holds no other corner.
fn find_ear(points: &[[f64; 2]], left: &[usize]) -> Option<usize> {
    (0..left.len()).find(|&at| {
        let ear @ [a, b, c] = around(left, at);
        let holds = |corner: usize| {
            area(points, [a, b, corner]) >= 0.0
                && area(points, [b, c, corner]) >= 0.0
                && area(points, [c, a, corner]) >= 0.0
        };
        let same_place = |corner: usize| ear.iter().any(|&tip| points[tip] == points[corner]);
        area(points, ear) > 0.0 && !left.iter().any(|&corner| !same_place(corner) && holds(corner))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(corners: &[[f32; 3]]) -> Vec<[usize; 3]> {
        let corners: Vec<Vec3> = corners.iter().copied().map(Vec3::from).collect();
        let mut triangles = Vec::new();
        triangulate(&corners, |triangle| triangles.push(triangle));
        triangles
    }

    /// The sum of the areas of triangles, each counted positive.
    fn covered(corners: &[[f32; 3]]) -> f32 {
        let corner = |index: usize| Vec3::from(corners[index]);
        let triangles = triangles(corners);
        triangles
            .iter()
            .map(|&[a, b, c]| (corner(b) - corner(a)).cross(corner(c) - corner(a)).length() * 0.5)
            .sum()
    }

    #[test]
    fn convex_polygons_become_fans() {
        assert_eq!(
            triangles(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]]),
            [[0, 1, 2], [0, 2, 3]]
        );
        assert_eq!(triangles(&[[0.0; 3]; 2]), [[0; 3]; 0]);
        assert_eq!(triangles(&[]), [[0; 3]; 0]);
    }

    #[test]
    fn an_arrow_head_is_split_at_its_notch() {
        let arrow = [[0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]];
        assert_eq!(triangles(&arrow).len(), 2);
        assert_eq!(covered(&arrow), 1.0);
    }

    #[test]
    fn a_comb_is_covered_once() {
        // Eight teeth and a half of height one on a base of height one, seen along y and turning either way.
        let mut comb = vec![[0.0, 5.0, 0.0], [9.0, 5.0, 0.0]];
        for tooth in (0..9).rev() {
            let x = tooth as f32;
            comb.extend([[x + 1.0, 5.0, 2.0], [x + 0.5, 5.0, 1.0]]);
        }
        comb.push([0.0, 5.0, 1.0]);
        let area = 9.0 + 8.5 * 0.5;
        assert_eq!(triangles(&comb).len(), comb.len() - 2);
        assert!((covered(&comb) - area).abs() < 1e-4, "{} against {area}", covered(&comb));
        comb.reverse();
        assert!((covered(&comb) - area).abs() < 1e-4, "{} against {area}", covered(&comb));
    }

    #[test]
    fn crossing_and_collapsed_polygons_end() {
        let bow_tie = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 3.0, 0.0]];
        assert_eq!(triangles(&bow_tie).len(), 3);
        assert_eq!(triangles(&[[1.0; 3]; 7]).len(), 5);
        let many: Vec<[f32; 3]> =
            (0..5000).map(|i| [(i * 37 % 101) as f32, (i * 53 % 97) as f32, 0.0]).collect();
        assert_eq!(triangles(&many).len(), 4998);
    }
}
