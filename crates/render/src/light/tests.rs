//! Sampling of every kind of light against tracing rays at it.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use sahl_image::Image;
use sahl_math::{Frame, Ray, Transform, Vec2, Vec3};
use sahl_scene::{
    Geometry, LightSampler, Material, Origin, PatchMesh, Radiance, SceneDesc, Shape, TriangleMesh,
};
use sahl_testkit::random::Rng;
use sahl_testkit::stats::{Running, welch};

use super::*;
use crate::scene::SceneData;
use crate::{Scene, build, warp};

const WAVELENGTHS: Wavelengths = Wavelengths::Rgb;

/// A shape to be sampled, and how its density is to be found from rays.
struct Case {
    name: &'static str,
    geometry: fn(&mut SceneDesc) -> Geometry,
    to_world: Transform,
    /// From where it is sampled.
    from: Vec3,
    /// Whether a direction can be found through each crossing with the shape, rather than the first alone.
    every_crossing: bool,
}

fn triangle(scene: &mut SceneDesc, normals: Option<[Vec3; 3]>) -> Geometry {
    let mesh = TriangleMesh {
        indices: [[0, 1, 2]].into(),
        positions: [Vec3::new(-1.0, -0.5, 0.0), Vec3::new(1.2, -0.3, 0.2), Vec3::new(0.1, 1.0, -0.4)].into(),
        normals: normals.map(Into::into),
        tangents: None,
        uvs: None,
    };
    Geometry::Triangles(scene.triangle_meshes.push(mesh, Origin::default()))
}

fn patch(scene: &mut SceneDesc, corners: [[f32; 3]; 4]) -> Geometry {
    let mesh = PatchMesh {
        indices: [[0, 1, 2, 3]].into(),
        positions: corners.map(Vec3::from).into(),
        normals: None,
        tangents: None,
        uvs: None,
    };
    Geometry::Patches(scene.patch_meshes.push(mesh, Origin::default()))
}

fn rectangle(scene: &mut SceneDesc) -> Geometry {
    patch(scene, [[-1.0, -0.7, 0.0], [1.0, -0.7, 0.0], [-1.0, 0.7, 0.0], [1.0, 0.7, 0.0]])
}

fn saddle(scene: &mut SceneDesc) -> Geometry {
    patch(scene, [[-1.0, -0.7, 0.3], [1.0, -0.9, -0.3], [-0.8, 0.7, -0.4], [1.4, 1.0, 0.5]])
}

fn kite(scene: &mut SceneDesc) -> Geometry {
    patch(scene, [[0.0, -1.0, 0.0], [1.0, 0.3, 0.0], [-1.0, 0.3, 0.0], [0.0, 1.0, 0.0]])
}

const fn sphere(_: &mut SceneDesc) -> Geometry {
    Geometry::Sphere { radius: 1.0, z_min: -1.0, z_max: 1.0, phi_max: TAU }
}

const fn partial_sphere(_: &mut SceneDesc) -> Geometry {
    Geometry::Sphere { radius: 1.0, z_min: -0.4, z_max: 0.8, phi_max: 4.0 }
}

const fn disk(_: &mut SceneDesc) -> Geometry {
    Geometry::Disk { height: 0.2, radius: 1.0, inner_radius: 0.0, phi_max: TAU }
}

const fn ring(_: &mut SceneDesc) -> Geometry {
    Geometry::Disk { height: -0.1, radius: 1.0, inner_radius: 0.4, phi_max: 4.5 }
}

const fn cylinder(_: &mut SceneDesc) -> Geometry {
    Geometry::Cylinder { radius: 0.6, z_min: -0.8, z_max: 0.5, phi_max: 5.0 }
}

/// A rotation and a translation, after scaling along the axes.
fn placed(scale: [f64; 3]) -> Transform {
    let [x, y, z] = scale;
    let rotated = Transform::rotate(0.8, [0.3, 1.0, -0.4]).unwrap();
    let scaled = rotated.after(&Transform::scale(x, y, z).unwrap()).unwrap();
    Transform::translate(0.4, -0.2, 3.0).unwrap().after(&scaled).unwrap()
}

fn cases() -> Vec<Case> {
    let case = |name, geometry, scale, from: [f32; 3], every_crossing| Case {
        name,
        geometry,
        to_world: placed(scale),
        from: from.into(),
        every_crossing,
    };
    vec![
        case("triangle", |scene| triangle(scene, None), [1.0; 3], [0.1, 0.2, 1.9], true),
        case("triangle, mirrored", |scene| triangle(scene, None), [-1.0, 2.0, 1.0], [0.0, 0.0, 1.5], true),
        case(
            "triangle with normals against it",
            |scene| triangle(scene, Some([Vec3::new(0.1, 0.2, -1.0), -Vec3::Z, Vec3::new(0.3, 0.0, -0.5)])),
            [1.0; 3],
            [0.1, 0.2, 1.9],
            true,
        ),
        case("rectangle", rectangle, [1.0; 3], [0.3, 0.5, 2.2], true),
        case("distant rectangle", rectangle, [0.04; 3], [0.3, 0.5, 1.2], true),
        case("sheared rectangle", rectangle, [1.0, 2.0, 1.0], [0.3, 0.5, 2.0], true),
        case("saddle", saddle, [1.0; 3], [0.3, 0.4, 1.7], true),
        case("kite", kite, [-1.0, 1.0, 1.0], [0.3, 0.4, 1.9], true),
        case("sphere", sphere, [1.0; 3], [0.0, 0.3, 1.2], false),
        case("sphere, scaled", sphere, [-0.5, 0.5, 0.5], [0.0, 0.3, 1.9], false),
        case("tiny sphere", sphere, [0.01; 3], [0.2, -0.2, 2.5], false),
        case("sphere from inside", sphere, [1.0; 3], [0.2, 0.1, 3.3], true),
        case("ellipsoid", sphere, [1.0, 0.5, 0.7], [0.0, 0.3, 1.7], true),
        case("partial sphere", partial_sphere, [1.0, 1.0, 1.4], [0.0, 0.3, 1.2], true),
        case("disk", disk, [1.0; 3], [0.3, 0.5, 2.0], true),
        case("elliptic disk", disk, [0.5, -1.5, 1.0], [0.3, 0.5, 2.0], true),
        case("ring", ring, [1.0; 3], [0.3, 0.5, 2.0], true),
        case("cylinder", cylinder, [1.0, 0.8, 1.2], [0.3, 0.5, 1.7], true),
    ]
}

/// The scene of one emitting shape of radiance one, built as any scene is.
fn scene_of(case: &Case, two_sided: bool, reverse_orientation: bool) -> Scene {
    let mut description = SceneDesc::default();
    let material = description.materials.push(Material::default(), Origin::default());
    let geometry = (case.geometry)(&mut description);
    let area_light = sahl_scene::AreaLight {
        radiance: sahl_scene::Spectrum::srgb([1.0; 3]),
        scale: 1.0,
        two_sided,
        power: None,
    };
    let shape = Shape {
        reverse_orientation,
        area_light: Some(area_light),
        ..Shape::new(geometry, case.to_world, material)
    };
    let shape = description.shapes.push(shape, Origin::default());
    description.world.push(shape);
    build(&description, &crate::BuildOptions::default()).0.unwrap()
}

/// The density with which the lights of `scene` are sampled in direction `w`.
fn density(scene: &SceneData, case: &Case, w: Vec3) -> f32 {
    let mut ray = Ray::new(case.from, w);
    let mut sum = 0.0;
    while let Some(hit) = scene.accel.intersect(&ray) {
        let at = scene.interaction(&ray, &hit);
        sum += scene.light(&at).map_or(0.0, |light| light.pdf(case.from, &at));
        if !case.every_crossing {
            break;
        }
        // Beyond the rounding of the parameter.
        ray.t_min = hit.t * (1.0 + 1e-5);
    }
    sum
}

/// The cone of directions from `from` that holds the whole scene: a frame and one minus the cosine of its half angle.
fn cone(scene: &SceneData, from: Vec3) -> (Frame, f32) {
    let (center, radius) = scene.accel.bounds().bounding_sphere().unwrap();
    let to_center = center - from;
    let sin2 = radius * radius / to_center.length_squared();
    let one_minus_cos = if sin2 < 1.0 { 1.0 - (1.0 - sin2).sqrt() } else { 2.0 };
    (Frame::from_z(to_center.normalize()), one_minus_cos * 1.0001)
}

/// Where a quantile of the normal distribution leaves this family of tests a chance of less than 1e-4 to fail.
const LARGEST_Z: f64 = 6.0;

const BINS: [usize; 2] = [12, 16];

/// A histogram with the error of each bin.
struct Histogram {
    sums: Vec<f64>,
    squares: Vec<f64>,
}

impl Histogram {
    fn new() -> Self {
        Self { sums: vec![0.0; BINS[0] * BINS[1]], squares: vec![0.0; BINS[0] * BINS[1]] }
    }

    fn add(&mut self, u: Vec2, value: f64) {
        let along = |x: f32, bins: usize| ((x * bins as f32) as usize).min(bins - 1);
        let bin = along(u.x, BINS[0]) * BINS[1] + along(u.y, BINS[1]);
        self.sums[bin] += value;
        self.squares[bin] += value * value;
    }

    /// Mean of a bin over `count` draws, and the variance of that mean.
    fn mean(&self, bin: usize, count: f64) -> (f64, f64) {
        let mean = self.sums[bin] / count;
        (mean, (self.squares[bin] / count - mean * mean) / count)
    }
}

/// Checks that `sample` draws directions of a cone with the given density per steradian.
///
/// Densities have edges where shapes and pixels end, which quadrature resolves badly: the expected share of each bin is
/// estimated by sampling as well, uniformly in the cone.
fn check_density(
    name: &str,
    (frame, one_minus_cos): (Frame, f32),
    sample: impl Fn(Vec2) -> Option<Vec3>,
    density: impl Fn(Vec3) -> f32,
) {
    const COUNT: u32 = 60_000;
    let mut rng = Rng::new(1);
    let (mut sampled, mut expected) = (Histogram::new(), Histogram::new());
    for _ in 0..COUNT {
        let [a, b, c, d] = rng.uniform();
        if let Some(w) = sample(Vec2::new(a, b)) {
            assert!((w.length() - 1.0).abs() < 1e-4, "{name}: {w:?}");
            sampled.add(warp::uniform_cone_inverse(frame.to_local(w), one_minus_cos), 1.0);
        }
        let u = Vec2::new(c, d);
        let w = frame.to_world(warp::uniform_cone(u, one_minus_cos));
        expected.add(u, f64::from(density(w) / warp::uniform_cone_pdf(one_minus_cos)));
    }
    let n = f64::from(COUNT);
    for bin in 0..BINS[0] * BINS[1] {
        let ((a, variance_a), (b, variance_b)) = (sampled.mean(bin, n), expected.mean(bin, n));
        // The normal distribution stands for the binomial one where there are enough draws.
        let variance = (variance_a + variance_b).max(30.0 / (n * n));
        let z = (a - b) / variance.sqrt();
        assert!(z.abs() < LARGEST_Z, "{name}, bin {bin}: {a} and {b}, z = {z}");
    }
    let mass = expected.sums.iter().sum::<f64>() / n;
    let deviation = ((expected.squares.iter().sum::<f64>() / n - mass * mass) / n).max(0.0).sqrt();
    let drawn = sampled.sums.iter().sum::<f64>() / n;
    assert!((mass - drawn).abs() < LARGEST_Z * deviation + 1e-3, "{name}: {mass} and {drawn}");
    assert!(drawn > 0.99, "{name}: only {drawn} of the samples are directions");
}

#[test]
fn shapes_are_sampled_with_their_density() {
    for case in &cases() {
        let scene = &scene_of(case, true, false).data;
        let sample = |u| scene.lights[0].sample(case.from, u, &WAVELENGTHS).map(|sample| sample.wi);
        check_density(case.name, cone(scene, case.from), sample, |w| density(scene, case, w));
    }
}

/// The radiance that arrives at `from` along `w`.
fn arriving(scene: &SceneData, from: Vec3, w: Vec3) -> f32 {
    let ray = Ray::new(from, w);
    let hit = scene.accel.intersect(&ray).map(|hit| scene.interaction(&ray, &hit));
    let Some(at) = hit else { return 0.0 };
    scene.light(&at).map_or(0.0, |light| light.emitted(&at, -w, &WAVELENGTHS).to_rgb()[0])
}

#[test]
fn both_ways_to_find_a_shape_give_the_same_light() {
    let mut lit = 0;
    for case in &cases() {
        for (two_sided, reverse) in [(false, false), (false, true), (true, false)] {
            let scene = &scene_of(case, two_sided, reverse).data;
            let mut rng = Rng::new(7);
            let (mut by_light, mut by_direction) = (Running::default(), Running::default());
            for _ in 0..20_000 {
                let [a, b] = rng.uniform();
                let light = scene.lights[0].sample(case.from, Vec2::new(a, b), &WAVELENGTHS);
                by_light.add(light.map_or(0.0, |sample| {
                    let shadow = Ray::spawn_to((case.from, Vec3::ZERO, Vec3::ZERO), sample.end.unwrap());
                    let visible = !scene.accel.occluded(&shadow);
                    if visible { f64::from(sample.radiance.to_rgb()[0] / sample.pdf) } else { 0.0 }
                }));
                let w = rng.direction();
                by_direction.add(f64::from(arriving(scene, case.from, w) * 4.0 * PI));
            }
            let p = welch(&by_light, &by_direction);
            let (a, b) = (by_light.mean(), by_direction.mean());
            assert!(p > 1e-5 || (a == 0.0 && b == 0.0), "{} {two_sided} {reverse}: {a} and {b}", case.name);
            lit += u32::from(a > 0.0);
        }
    }
    // Each shape is lit from the point on one side at least, or two-sided.
    assert!(lit as usize >= 2 * cases().len(), "{lit}");
}

#[test]
fn a_hit_has_the_density_of_the_sample() {
    for case in &cases() {
        let scene = &scene_of(case, true, false).data;
        let mut rng = Rng::new(3);
        let mut compared = 0;
        for _ in 0..2000 {
            let [a, b] = rng.uniform();
            let Some(sample) = scene.lights[0].sample(case.from, Vec2::new(a, b), &WAVELENGTHS) else {
                continue;
            };
            let ray = Ray::new(case.from, sample.wi);
            let Some(hit) = scene.accel.intersect(&ray) else { continue };
            let at = scene.interaction(&ray, &hit);
            let end = sample.end.unwrap();
            if (at.p - end.0).length() < 1e-4 && at.ng.dot(sample.wi).abs() > 0.1 {
                compared += 1;
                let pdf = scene.lights[0].pdf(case.from, &at);
                assert!((pdf / sample.pdf - 1.0).abs() < 5e-3, "{}: {pdf} and {}", case.name, sample.pdf);
                assert!((at.ng - end.2).length() < 2e-3, "{}: {:?} and {:?}", case.name, at.ng, end.2);
                let error = (at.p - end.0).abs();
                // The ray's direction is rounded, too.
                let bound = at.p_error + end.1 + Vec3::splat(2e-6);
                assert!((0..3).all(|i| error[i] <= bound[i] * 2.0), "{}: {error:?} {bound:?}", case.name);
            }
        }
        assert!(compared > 300, "{}: {compared}", case.name);
    }
}

/// A sky with a bright spot, a gradient, and a dark half.
fn sky(width: usize, height: usize, map: SphereMap) -> Light {
    let mut values = vec![0.0; width * height * 3];
    for y in 0..height {
        for x in 0..width / 2 {
            let bright = if (x, y) == (2, height / 3) { 50.0 } else { 0.0 };
            let v = 0.2 + bright + x as f32 * 0.1 + y as f32 * 0.05;
            values[(y * width + x) * 3..][..3].copy_from_slice(&[v, 0.5 * v, 0.1 * v]);
        }
    }
    let image = Image::rgb_f32(width, height, values).unwrap();
    let turned = Transform::rotate(1.1, [0.2, -1.0, 0.5]).unwrap();
    Light::Image(Box::new(ImageEnvironment::new(&image, map, &turned).unwrap()))
}

fn skies() -> [(&'static str, Light); 3] {
    let emission = Emission { curve: crate::spectrum::SpectralCurve::constant(1.0), scale: 0.7 };
    [
        ("equal-area", sky(16, 16, SphereMap::EqualArea)),
        ("latitude-longitude", sky(24, 12, SphereMap::LatLong)),
        ("uniform", Light::Uniform(emission)),
    ]
}

#[test]
fn skies_are_sampled_with_their_density() {
    for (name, light) in skies() {
        let sample = |u| light.sample(Vec3::ZERO, u, &WAVELENGTHS).map(|sample| sample.wi);
        check_density(name, (Frame::from_z(Vec3::Y), 2.0), sample, |w| light.escaped_pdf(w));
    }
}

#[test]
fn both_ways_to_find_the_sky_give_the_same_light() {
    for (name, light) in skies() {
        let mut rng = Rng::new(11);
        let (mut by_light, mut by_direction) = (Running::default(), Running::default());
        for _ in 0..100_000 {
            let [a, b] = rng.uniform();
            if let Some(sample) = light.sample(Vec3::ZERO, Vec2::new(a, b), &WAVELENGTHS) {
                by_light.add(f64::from(sample.radiance.to_rgb()[0] / sample.pdf));
                let seen = light.escaped(sample.wi, &WAVELENGTHS);
                let difference = (seen - sample.radiance).map(f32::abs).max_component();
                // Rounding may move a direction into the next pixel of an image without interpolation.
                assert!(name == "equal-area" || difference < 1e-2 * (1.0 + seen.max_component()), "{name}");
            }
            let w = rng.direction();
            by_direction.add(f64::from(light.escaped(w, &WAVELENGTHS).to_rgb()[0] * 4.0 * PI));
        }
        assert!(welch(&by_light, &by_direction) > 1e-4, "{name}: {by_light:?} {by_direction:?}");
        let power = light.power(1.0, &WAVELENGTHS).to_rgb()[0];
        let expected = by_light.mean() as f32 * PI;
        assert!((power / expected - 1.0).abs() < 0.02, "{name}: {power} and {expected}");
    }
}

#[test]
fn photometric_totals_are_kept() {
    let mut description = SceneDesc::default();
    let image = Image::rgb_f32(24, 12, (0..24 * 12 * 3).map(|i| (i % 7) as f32).collect()).unwrap();
    let image = description.images.push(Arc::new(image), Origin::default());
    let infinite = |radiance| sahl_scene::Light::Infinite {
        radiance,
        scale: 2.0,
        illuminance: Some(5.0),
        light_to_world: Transform::IDENTITY,
    };
    let white = || sahl_scene::Spectrum::Blackbody(5000.0);
    let lights = [
        infinite(Radiance::Constant(white())),
        infinite(Radiance::LatLong(image)),
        sahl_scene::Light::Point { intensity: white(), scale: 2.0, power: Some(5.0), position: Vec3::ZERO },
        sahl_scene::Light::Spot {
            intensity: white(),
            scale: 2.0,
            power: Some(5.0),
            position: Vec3::ZERO,
            direction: Vec3::Y,
            angle: 0.9,
            penumbra: 0.3,
        },
    ];
    for light in lights {
        description.lights.push(light, Origin::default());
    }
    let scene = build(&description, &crate::BuildOptions::default()).0.unwrap().data;
    let mut rng = Rng::new(5);
    let (mut irradiance, mut flux) = ([0.0; 2], [0.0; 2]);
    let count = 200_000;
    for _ in 0..count {
        let w = rng.direction();
        for i in 0..2 {
            let radiance = scene.lights[i].escaped(w, &WAVELENGTHS).luminance();
            irradiance[i] += f64::from(radiance * w.y.max(0.0) * 4.0 * PI) / f64::from(count);
            let sample = scene.lights[2 + i].sample(w, Vec2::ZERO, &WAVELENGTHS);
            let received = sample.map_or(0.0, |sample| sample.radiance.luminance() * 4.0 * PI);
            flux[i] += f64::from(received) / f64::from(count);
        }
    }
    for value in irradiance.into_iter().chain(flux) {
        assert!((value / 10.0 - 1.0).abs() < 0.02, "{irradiance:?} {flux:?}");
    }
}

#[test]
fn few_lights_are_chosen_by_power() {
    let point = |intensity| {
        let curve = crate::spectrum::SpectralCurve::constant(intensity);
        Light::Point(PointLight { position: Vec3::ZERO, intensity: Emission { curve, scale: 1.0 } })
    };
    let sky = Light::Uniform(Emission { curve: crate::spectrum::SpectralCurve::constant(9.0), scale: 1.0 });
    let lights = [point(1.0), point(0.0), point(3.0), sky];
    let from = Vantage::in_space(Vec3::ONE);
    for sampler in [LightSampler::Tree, LightSampler::Power] {
        let by_power = LightSelection::new(sampler, &lights, 1.0);
        for (light, expected) in [0.25, 0.0, 0.75, 0.0].into_iter().enumerate() {
            assert!((by_power.pmf(&from, light as u32) - expected).abs() < 1e-6, "{light}");
        }
        assert_eq!(by_power.choose(&from, 0.999).map(|choice| choice.light), Some(2));
        assert!(LightSelection::new(sampler, &lights[3..], 1.0).is_empty());
    }
    let uniform = LightSelection::new(LightSampler::Uniform, &lights, 1.0);
    assert_eq!([0, 1, 2, 3].map(|light| uniform.pmf(&from, light)), [0.5, 0.0, 0.5, 0.0]);
}
