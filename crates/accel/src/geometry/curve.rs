//! Curves: cubic Bézier segments with a width, for hair, fur and grass.
//!
//! A segment is met where its axis, seen along the ray, passes the ray at no more than half its width. The axis is cut in two
//! until it is nearly straight against its width, and the ray is held against the boxes of the parts on the way: all in a space
//! in which the ray is the z axis, in `f64`. Parts that follow each other are divided by the plane across the axis that both
//! share, so that neither a gap nor an overlap is left between them.
//!
//! The surface is thus what the ray sees: a strip that faces it (flat), the same with the normals of a tube (cylinder), or one
//! whose width shrinks as its own normal turns away (ribbon). The point that is hit lies on the ray, beside the axis, up to half a
//! width off any surface that other rays see: its error is the width.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 3rd ed., 2016, section 3.7; Nakamaru, Ohno, *Ray Tracing for Curves
//! Primitive*, WSCG 2002. Deviations: the arithmetic is `f64`; a segment of width zero is never hit.

use std::f64::consts::{FRAC_PI_2, SQRT_2};
use std::sync::Arc;

use sahl_math::{Bounds3, Ray, Vec3};

use super::double::{DVec3, DoubleTransform};
use super::quadric::DoubleRay;
use crate::world::{CurveKind, CurveSet};

/// A segment has a box for each of at most `2^MAX_SPLIT_DEPTH` parts.
const MAX_SPLIT_DEPTH: u32 = 6;

/// How far from straight a part may be, relative to the width of its segment.
const FLATNESS: f64 = 0.05;

/// A part of a segment is cut in two this often at most.
const MAX_DEPTH: u32 = 10;

/// Control points of a cubic Bézier curve.
type Points = [DVec3; 4];

/// The curves of a geometry, prepared for intersection.
#[derive(Clone, Debug)]
pub(crate) struct Curves {
    to_parent: DoubleTransform,
    kind: CurveKind,
    points: Arc<[[Vec3; 4]]>,
    widths: Arc<[[f32; 2]]>,
    normals: Arc<[[Vec3; 2]]>,
    /// How many parts of a segment have a box of their own.
    parts: u32,
}

/// A part of a segment, as a tree holds it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurvePart {
    /// Which of the prepared curves.
    pub(crate) curves: u32,
    /// The part among all parts of these curves.
    pub(crate) offset: u32,
    /// The primitive's place among all primitives.
    pub(crate) id: u32,
}

/// Where a ray meets a part of a segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurveHit {
    pub(crate) t: f32,
    /// The parameter along the segment.
    pub(crate) u: f32,
    /// The place across its width.
    pub(crate) v: f32,
}

/// A point of a curve in its parent's space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurveSurface {
    pub(crate) p: DVec3,
    /// The absolute error of the coordinates of `p`.
    pub(crate) error: DVec3,
    /// The normal, not of unit length.
    pub(crate) n: DVec3,
}

/// How many parts of a segment have boxes of their own.
pub(crate) fn parts_of(set: &CurveSet) -> u32 {
    1 << set.split_depth.min(MAX_SPLIT_DEPTH)
}

impl Curves {
    pub(crate) fn new(set: &CurveSet) -> Self {
        Self {
            to_parent: DoubleTransform::new(&set.to_parent),
            kind: set.kind,
            points: Arc::clone(&set.points),
            widths: Arc::clone(&set.widths),
            normals: Arc::clone(&set.normals),
            parts: parts_of(set),
        }
    }

    /// How many parts all segments have.
    pub(crate) fn len(&self) -> usize {
        self.points.len() * self.parts as usize
    }

    /// The segment to which a part belongs, and the parameters between which it lies.
    fn part(&self, offset: u32) -> (usize, [f64; 2]) {
        let at = |part: u32| f64::from(part) / f64::from(self.parts);
        let part = offset % self.parts;
        ((offset / self.parts) as usize, [at(part), at(part + 1)])
    }

    /// Control points and widths of a segment; `None` if there is no such segment, or none that can be hit.
    fn segment(&self, segment: usize) -> Option<(Points, [f64; 2])> {
        let (points, widths) = (self.points.get(segment)?, self.widths.get(segment)?.map(f64::from));
        let has_width = widths.iter().all(|&width| width >= 0.0) && widths[0].max(widths[1]) > 0.0;
        let has_length = points.iter().any(|&point| point != points[0]);
        let has_normals = self.kind != CurveKind::Ribbon
            || self.normals.get(segment).is_some_and(|normals| normals.iter().all(|n| n.is_finite()));
        (has_width && has_length && has_normals).then(|| (points.map(DVec3::from), widths))
    }

    /// The box about a part in the parent's space, rounded outwards; `None` if there is nothing to hit.
    pub(crate) fn bounds(&self, offset: u32) -> Option<Bounds3> {
        let (segment, [u0, u1]) = self.part(offset);
        let (points, widths) = self.segment(segment)?;
        let points = between(&points, u0, u1);
        let half = half_width(widths, u0, u1);
        let zip =
            |a: DVec3, b: DVec3, f: fn(f64, f64) -> f64| DVec3::new(f(a.x, b.x), f(a.y, b.y), f(a.z, b.z));
        let min = points.into_iter().reduce(|a, b| zip(a, b, f64::min))?;
        let max = points.into_iter().reduce(|a, b| zip(a, b, f64::max))?;
        let (middle, reach) = ((min + max) * 0.5, (max - min) * 0.5 + DVec3::new(half, half, half));
        let center = self.to_parent.point(middle);
        let reach = self.to_parent.spread(reach) + self.to_parent.rounding(middle.abs() + reach);
        Some(Bounds3 {
            min: (center - reach).to_f32().map(f32::next_down),
            max: (center + reach).to_f32().map(f32::next_up),
        })
    }

    /// The nearest hit of a part with `ray.t_min < t <= limit`.
    pub(crate) fn intersect(&self, ray: &Ray, offset: u32, limit: f32) -> Option<CurveHit> {
        let (segment, [u0, u1]) = self.part(offset);
        let (points, widths) = self.segment(segment)?;
        let local = self.local_ray(ray);
        let points = between(&points, u0, u1);
        let view = View::new(&local, points[3] - points[0])?;
        let normals = self.ribbon_normals(segment);
        let mut search = Search { widths, normals, view: &view, t_min: ray.t_min, limit, best: None };
        let points = points.map(|p| view.project(p - local.origin));
        search.visit(&points, [u0, u1], depth(&points, widths));
        search.best
    }

    /// The point that `ray` hit at the parameters of a hit.
    ///
    /// The normal is that of ∂p/∂u × ∂p/∂v, v growing from one border of what the ray sees to the other: it points away from where the
    /// ray comes from. `None` if there is no such segment.
    pub(crate) fn surface(&self, ray: &Ray, segment: u32, hit: CurveHit) -> Option<CurveSurface> {
        let (points, widths) = self.segment(segment as usize)?;
        let local = self.local_ray(ray);
        let (u, v) = (f64::from(hit.u), f64::from(hit.v));
        let tangent = tangent(&points, u);
        let across = perpendicular(local.direction, tangent);
        let mut width = lerp(u, widths);
        let n = match (self.kind, self.ribbon_normals(segment as usize)) {
            (CurveKind::Ribbon, Some(normals)) => {
                let normal = normals.at(u);
                width *= normal.dot(local.direction).abs() / local.direction.length();
                tangent.cross(normal.cross(tangent))
            }
            (CurveKind::Cylinder, _) => {
                let (sin, cos) = (-(2.0 * v - 1.0) * FRAC_PI_2).sin_cos();
                let along = tangent * (1.0 / tangent.length());
                along.cross(across) * cos - across * sin
            }
            _ => tangent.cross(across),
        };
        let p = local.at(f64::from(hit.t));
        // The ray's parameter is known to half a unit in its last place.
        let along = (local.direction * f64::from(hit.t)).abs() * f64::from(f32::EPSILON);
        let error = along + DVec3::new(width, width, width);
        Some(CurveSurface {
            p: self.to_parent.point(p),
            error: self.to_parent.spread(error) + self.to_parent.rounding(p),
            n: self.to_parent.normal(n),
        })
    }

    fn ribbon_normals(&self, segment: usize) -> Option<Turn> {
        (self.kind == CurveKind::Ribbon).then(|| self.normals.get(segment)).flatten().map(Turn::new)
    }

    fn local_ray(&self, ray: &Ray) -> DoubleRay {
        DoubleRay {
            origin: self.to_parent.inverse_point(ray.origin.into()),
            direction: self.to_parent.inverse_vector(ray.direction.into()),
        }
    }
}

/// Unit normals at the ends of a ribbon, and the turn from one to the other at even speed.
#[derive(Clone, Copy, Debug)]
struct Turn {
    normals: [DVec3; 2],
    angle: f64,
}

impl Turn {
    fn new(normals: &[Vec3; 2]) -> Self {
        let unit = |n: Vec3| {
            let n = DVec3::from(n);
            let length = n.length();
            if length > 0.0 { n * (1.0 / length) } else { DVec3::new(0.0, 0.0, 1.0) }
        };
        let [a, b] = normals.map(unit);
        Self { normals: [a, b], angle: a.cross(b).length().atan2(a.dot(b)) }
    }

    /// The unit normal at `u`; that at the start where both are opposite, which leaves the way open.
    fn at(&self, u: f64) -> DVec3 {
        let [a, b] = self.normals;
        let sin = self.angle.sin();
        let n = a * (((1.0 - u) * self.angle).sin() / sin) + b * ((u * self.angle).sin() / sin);
        let length = n.length();
        if length > 0.5 && length < 2.0 { n * (1.0 / length) } else { a }
    }
}

/// A space with the ray's origin at zero and the ray along z.
struct View {
    axes: [DVec3; 3],
    /// The length of the ray's direction.
    speed: f64,
}

impl View {
    /// `chord` comes to lie in the plane of x and z, which makes boxes tight. `None` without a direction.
    fn new(ray: &DoubleRay, chord: DVec3) -> Option<Self> {
        let speed = ray.direction.length();
        if !(speed > 0.0 && speed.is_finite()) {
            return None;
        }
        let z = ray.direction * (1.0 / speed);
        let y = perpendicular(z, chord);
        Some(Self { axes: [y.cross(z), y, z], speed })
    }

    fn project(&self, v: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        DVec3::new(v.dot(x), v.dot(y), v.dot(z))
    }
}

/// The unit vector along `z × v`, or any perpendicular to `v`, or to `z`, where there is none.
fn perpendicular(z: DVec3, v: DVec3) -> DVec3 {
    let unit = |n: DVec3| {
        let length = n.length();
        (length > 0.0 && length.is_finite()).then(|| n * (1.0 / length))
    };
    let any = |v: DVec3| {
        let helper =
            if v.x.abs() < v.y.abs() { DVec3::new(1.0, 0.0, 0.0) } else { DVec3::new(0.0, 1.0, 0.0) };
        unit(v.cross(helper))
    };
    unit(z.cross(v)).or_else(|| any(v)).or_else(|| any(z)).unwrap_or(DVec3::new(1.0, 0.0, 0.0))
}

/// How often a part is cut in two until it is straight to within [`FLATNESS`].
///
/// Source: Wang, *The Subdivision Method for Finding the Intersection between Two Bézier Curves or Surfaces*, 1984.
fn depth(points: &Points, widths: [f64; 2]) -> u32 {
    let bend = |i: usize| {
        let [a, b, c] = [points[i], points[i + 1], points[i + 2]];
        let second = (a - b * 2.0 + c).abs();
        second.x.max(second.y).max(second.z)
    };
    let bend = bend(0).max(bend(1));
    let levels = (SQRT_2 * 6.0 * bend / (8.0 * FLATNESS * widths[0].max(widths[1]))).log2().floor() * 0.5;
    // Where nothing is bent that is minus infinity; the conversion saturates.
    (levels as u32).min(MAX_DEPTH)
}

/// The search among the parts of a part.
struct Search<'a> {
    widths: [f64; 2],
    normals: Option<Turn>,
    view: &'a View,
    t_min: f32,
    limit: f32,
    best: Option<CurveHit>,
}

impl Search<'_> {
    /// Visits the part between two parameters; the recursion is at most [`MAX_DEPTH`] deep.
    fn visit(&mut self, points: &Points, [u0, u1]: [f64; 2], depth: u32) {
        if !self.may_meet(points, half_width(self.widths, u0, u1)) {
            return;
        }
        if depth == 0 {
            if let Some(hit) = self.meet(points, [u0, u1]) {
                self.limit = hit.t;
                self.best = Some(hit);
            }
            return;
        }
        let [low, high] = halves(points);
        let middle = (u0 + u1) * 0.5;
        self.visit(&low, [u0, middle], depth - 1);
        self.visit(&high, [middle, u1], depth - 1);
    }

    /// Whether the box about a part, widened by `half`, meets the ray within its interval.
    fn may_meet(&self, points: &Points, half: f64) -> bool {
        let range = |coordinate: fn(&DVec3) -> f64| {
            let [a, b, c, d] = points.each_ref().map(coordinate);
            [a.min(b).min(c.min(d)) - half, a.max(b).max(c.max(d)) + half]
        };
        let ([x0, x1], [y0, y1], [z0, z1]) = (range(|p| p.x), range(|p| p.y), range(|p| p.z));
        let end = f64::from(self.limit.next_up()) * self.view.speed;
        x0 <= 0.0 && x1 >= 0.0 && y0 <= 0.0 && y1 >= 0.0 && z1 >= 0.0 && z0 <= end
    }

    /// Where the ray meets a part that is nearly straight.
    fn meet(&self, points: &Points, [u0, u1]: [f64; 2]) -> Option<CurveHit> {
        let [p0, p1, p2, p3] = *points;
        let dot = |a: DVec3, b: DVec3| a.x * b.x + a.y * b.y;
        // Not before the plane across its start, nor behind that across its end.
        if dot(p1 - p0, -p0) < 0.0 || dot(p2 - p3, -p3) < 0.0 {
            return None;
        }
        let chord = p3 - p0;
        let length2 = dot(chord, chord);
        if length2 == 0.0 {
            return None;
        }
        let w = dot(-p0, chord) / length2;
        let u = (u0 + (u1 - u0) * w).clamp(u0, u1);
        let mut width = lerp(u, self.widths);
        if let Some(turn) = &self.normals {
            width *= turn.at(u).dot(self.view.axes[2]).abs();
        }
        let w = w.clamp(0.0, 1.0);
        let (at, along) = (point(points, w), tangent(points, w));
        let distance2 = dot(at, at);
        // Negated, so that NaN misses.
        if !(width > 0.0 && distance2 <= 0.25 * width * width) {
            return None;
        }
        let t = (at.z / self.view.speed) as f32;
        if !(t > self.t_min && t <= self.limit) {
            return None;
        }
        let is_upper = at.x * along.y - at.y * along.x > 0.0;
        let off = distance2.sqrt() / width;
        let v = if is_upper { 0.5 + off } else { 0.5 - off };
        Some(CurveHit { t, u: u as f32, v: (v as f32).clamp(0.0, 1.0) })
    }
}

fn lerp(u: f64, [a, b]: [f64; 2]) -> f64 {
    a * (1.0 - u) + b * u
}

/// Half the largest width between two parameters.
fn half_width(widths: [f64; 2], u0: f64, u1: f64) -> f64 {
    0.5 * lerp(u0, widths).max(lerp(u1, widths))
}

fn mix(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a * (1.0 - t) + b * t
}

/// The point at a parameter, by de Casteljau's construction.
fn point([p0, p1, p2, p3]: &Points, u: f64) -> DVec3 {
    let [a, b, c] = [mix(*p0, *p1, u), mix(*p1, *p2, u), mix(*p2, *p3, u)];
    mix(mix(a, b, u), mix(b, c, u), u)
}

/// The derivative at a parameter up to a positive factor: where control points coincide, the direction in which the curve goes on.
fn tangent([p0, p1, p2, p3]: &Points, u: f64) -> DVec3 {
    let [a, b, c] = [mix(*p0, *p1, u), mix(*p1, *p2, u), mix(*p2, *p3, u)];
    let derivative = mix(b, c, u) - mix(a, b, u);
    let chord = *p3 - *p0;
    let candidates = [derivative, c - a, chord];
    candidates.into_iter().find(|v| v.dot(*v) > 0.0).unwrap_or(*p1 - *p0)
}

/// Control points of the curve between two parameters: its polar form at all choices of the two.
///
/// Source: Ramshaw, *Blossoms are Polar Forms*, CAGD 6(4), 1989.
fn between([p0, p1, p2, p3]: &Points, u0: f64, u1: f64) -> Points {
    let polar = |a: f64, b: f64, c: f64| {
        let [x, y, z] = [mix(*p0, *p1, a), mix(*p1, *p2, a), mix(*p2, *p3, a)];
        mix(mix(x, y, b), mix(y, z, b), c)
    };
    [polar(u0, u0, u0), polar(u0, u0, u1), polar(u0, u1, u1), polar(u1, u1, u1)]
}

/// Control points of both halves.
fn halves([p0, p1, p2, p3]: &Points) -> [Points; 2] {
    let middle = |a: DVec3, b: DVec3| (a + b) * 0.5;
    let [a, b, c] = [middle(*p0, *p1), middle(*p1, *p2), middle(*p2, *p3)];
    let [d, e] = [middle(a, b), middle(b, c)];
    let m = middle(d, e);
    [[*p0, a, d, m], [m, e, c, *p3]]
}
