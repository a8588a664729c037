//! Curves.
//!
//! Whatever basis and degree a curve has, it becomes cubic Bézier segments.

use std::sync::Arc;

use sahl_math::Vec3;
use sahl_scene::{CurveKind, Curves, Diagnostic, Geometry, Origin};

use super::super::context::Context;
use super::super::parameter::Kind;
use super::super::reader::Reader;
use super::shape::positions;

/// What control points mean.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Basis {
    Bezier,
    BSpline,
}

/// The curve of a `Shape "curve"`.
pub(super) fn curve(cx: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    let curves = read(p);
    let add = |curves| Geometry::Curves(cx.scene.curves.push(curves, Origin::at(p.span())));
    curves.map(add).into_iter().collect()
}

fn read(p: &Reader<'_>) -> Option<Curves> {
    // Named so that they are known even if reading ends before them.
    p.without_effect(&["P", "N", "type", "basis", "degree", "width", "width0", "width1", "splitdepth"]);
    let basis = p.choice("basis", &[("bezier", Basis::Bezier), ("bspline", Basis::BSpline)], Basis::Bezier);
    let degree = p.integer("degree", 3, 2, 3).unsigned_abs() as usize;
    let kinds = [("flat", CurveKind::Flat), ("cylinder", CurveKind::Cylinder), ("ribbon", CurveKind::Ribbon)];
    let kind = p.choice("type", &kinds, CurveKind::Flat);
    let split_depth = p.count("splitdepth", 3);
    let points = segments(p, basis, degree, &positions(p)?)?;
    let widths = widths(p, points.len())?;
    let normals = normals(p, kind, points.len())?;
    Some(Curves { kind, points, widths, normals, split_depth })
}

/// The segments of a curve with these control points; `None`, reported, if these are too many or too few.
fn segments(p: &Reader<'_>, basis: Basis, degree: usize, points: &[Vec3]) -> Option<Arc<[[Vec3; 4]]>> {
    let (step, rule) = match basis {
        Basis::Bezier => (degree, format!("{} and {degree} for each further segment", degree + 1)),
        Basis::BSpline => (1, format!("{} or more", degree + 1)),
    };
    let fits = points.len() > degree && (points.len() - degree - 1).is_multiple_of(step);
    if !fits {
        let span = p.find("P").map_or(p.span(), |parameter| parameter.value_span);
        let message =
            format!("{} of this basis needs {rule} control points, found {}", p.what(), points.len());
        p.report().error("wrong-count", span, message);
        return None;
    }
    let segment = |points: &[Vec3]| match *points {
        [a, b, c] => {
            elevated(if basis == Basis::BSpline { [(a + b) * 0.5, b, (b + c) * 0.5] } else { [a, b, c] })
        }
        [a, b, c, d] if basis == Basis::BSpline => cubic_from_spline([a, b, c, d]),
        _ => [0, 1, 2, 3].map(|i| points.get(i).copied().unwrap_or(Vec3::ZERO)),
    };
    Some(points.windows(degree + 1).step_by(step).map(segment).collect())
}

/// The cubic Bézier curve that is the quadratic one.
fn elevated([a, b, c]: [Vec3; 3]) -> [Vec3; 4] {
    [a, (a + b * 2.0) * (1.0 / 3.0), (b * 2.0 + c) * (1.0 / 3.0), c]
}

/// The Bézier curve that is a segment of a uniform cubic B-spline.
fn cubic_from_spline([a, b, c, d]: [Vec3; 4]) -> [Vec3; 4] {
    let (low, high) = ((b * 2.0 + c) * (1.0 / 3.0), (b + c * 2.0) * (1.0 / 3.0));
    [(a + b * 4.0 + c) * (1.0 / 6.0), low, high, (b + c * 4.0 + d) * (1.0 / 6.0)]
}

/// The widths at the ends of each segment; `None`, reported, if the curve has none.
fn widths(p: &Reader<'_>, segments: usize) -> Option<Arc<[[f32; 2]]>> {
    let width = p.non_negative("width", 1.0);
    let ends = [p.non_negative("width0", width), p.non_negative("width1", width)];
    if ends == [0.0; 2] {
        let message = format!("{} has no width: it is left out", p.what());
        p.report().warning("empty-shape", p.span(), message);
        return None;
    }
    let at = |i: usize| {
        let share = i as f32 / segments as f32;
        ends[0] * (1.0 - share) + ends[1] * share
    };
    Some((0..segments).map(|i| [at(i), at(i + 1)]).collect())
}

/// The normals at the ends of each segment of a ribbon, none of another; `None`, reported, if they are missing.
fn normals(p: &Reader<'_>, kind: CurveKind, segments: usize) -> Option<Arc<[[Vec3; 2]]>> {
    let normals = p.vectors("N", Kind::Normal);
    if kind != CurveKind::Ribbon {
        if let Some(parameter) = p.find("N") {
            let message = format!("`N` of {} is for ribbons: it is ignored", p.what());
            p.report().warning("unused-parameter", parameter.declaration, message);
        }
        return Some([].into());
    }
    let Some(normals) = normals else {
        if !p.has("N") {
            let diagnostic = Diagnostic::error("missing-parameter", p.span(), "a ribbon needs `normal N`");
            let help = format!("give {} normals, one for each end of its segments", segments + 1);
            p.report().push(diagnostic.with_help(help));
        }
        return None;
    };
    if normals.len() != segments + 1 {
        let span = p.find("N").map_or(p.span(), |parameter| parameter.value_span);
        let (expected, found) = (segments + 1, normals.len());
        let message = format!("a ribbon of {segments} segments needs {expected} normals, found {found}");
        p.report().error("wrong-count", span, message);
        return None;
    }
    Some(normals.windows(2).filter_map(|ends| <[Vec3; 2]>::try_from(ends).ok()).collect())
}
