//! Sampling of every kind of light against tracing rays at it.

use std::f32::consts::{PI, TAU};
use std::sync::{Arc, LazyLock};

use sahl_image::Image;
use sahl_math::{Frame, Ray, Transform, Vec2, Vec3};
use sahl_scene::{
    Geometry, LightSampler, Material, Origin, PatchMesh, Radiance, SceneDesc, Shape, SpectrumParam,
    TriangleMesh,
};
use sahl_testkit::chi2::SquareTest;
use sahl_testkit::random::Rng;
use sahl_testkit::stats::{Running, welch};

use super::*;
use crate::scene::SceneData;
use crate::{Scene, build, warp};

const WAVELENGTHS: Wavelengths = Wavelengths::Rgb;

fn no_textures() -> &'static Textures {
    static NONE: LazyLock<Textures> = LazyLock::new(Textures::default);
    &NONE
}

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
        face_indices: None,
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
        face_indices: None,
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
    let white = |_: &mut SceneDesc| SpectrumParam::Constant(sahl_scene::Spectrum::srgb([1.0; 3]));
    scene_emitting(case, (two_sided, None), reverse_orientation, white)
}

/// A picture that differs from corner to corner, dark in places.
fn picture(scene: &mut SceneDesc) -> SpectrumParam {
    let values = (0..4 * 4).flat_map(|i| [if i % 5 == 0 { 0.0 } else { 0.2 * i as f32 }, 1.0, 0.5]).collect();
    let image = scene.images.push(Arc::new(Image::rgb_f32(4, 4, values).unwrap()), Origin::default());
    let texture = sahl_scene::ImageTexture {
        image,
        mapping: sahl_scene::TextureMapping::default(),
        wrap: sahl_scene::Wrap::Clamp,
        filter: sahl_scene::TextureFilter::Bilinear,
        scale: 1.0,
        invert: false,
    };
    let texture = scene.textures.push(sahl_scene::Texture::Image(texture), Origin::default());
    SpectrumParam::Texture(texture)
}

fn scene_emitting(
    case: &Case,
    (two_sided, power): (bool, Option<f32>),
    reverse_orientation: bool,
    radiance: impl FnOnce(&mut SceneDesc) -> SpectrumParam,
) -> Scene {
    let mut description = SceneDesc::default();
    let material = description.materials.push(Material::default(), Origin::default());
    let geometry = (case.geometry)(&mut description);
    let radiance = radiance(&mut description);
    let area_light = sahl_scene::AreaLight { radiance, scale: 1.0, two_sided, power };
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

/// Checks that `sample` draws directions of a cone with the given density per steradian, as one of `tests` tests.
///
/// The cone is unrolled to a square, so that its bins are where the light is.
fn check_density(
    (name, tests): (&str, usize),
    (frame, one_minus_cos): (Frame, f32),
    sample: impl Fn(Vec2) -> Option<Vec3>,
    density: impl Fn(Vec3) -> f32,
) {
    let test = SquareTest { x_bins: 12, y_bins: 16, samples: 60_000, tests, ..SquareTest::default() };
    let unrolled = |w: Vec3| {
        assert!((w.length() - 1.0).abs() < 1e-4, "{name}: {w:?}");
        let p = warp::uniform_cone_inverse(frame.to_local(w), one_minus_cos);
        // The tip of the whole sphere may be rounded over the border.
        assert!(p.x < 1.0 + 1e-5, "{name}: {w:?}");
        p.min(Vec2::ONE)
    };
    let cone_pdf = warp::uniform_cone_pdf(one_minus_cos);
    let drawn = std::cell::Cell::new(0);
    let counted = |u: [f32; 2]| {
        sample(u.into()).map(|w| {
            drawn.set(drawn.get() + 1);
            unrolled(w)
        })
    };
    let in_square = |u: Vec2| density(frame.to_world(warp::uniform_cone(u, one_minus_cos))) / cone_pdf;
    test.run(counted, in_square).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(drawn.get() > 59_400, "{name}: only {} of the samples are directions", drawn.get());
}

#[test]
fn shapes_are_sampled_with_their_density() {
    let cases = cases();
    // The density of a curved shape that is sampled by area grows without bound toward its silhouette, and is no matter for quadrature:
    // such shapes are held to it by comparing both ways to find their light.
    let has_bound = |case: &&Case| !["ellipsoid", "partial sphere", "cylinder"].contains(&case.name);
    for case in cases.iter().filter(has_bound) {
        let scene = &scene_of(case, true, false).data;
        let sample =
            |u| scene.lights[0].sample(case.from, u, no_textures(), &WAVELENGTHS).map(|sample| sample.wi);
        let name = (case.name, cases.len());
        check_density(name, cone(scene, case.from), sample, |w| density(scene, case, w));
    }
}

/// The radiance that arrives at `from` along `w`.
fn arriving(scene: &SceneData, from: Vec3, w: Vec3) -> f32 {
    let ray = Ray::new(from, w);
    let hit = scene.accel.intersect(&ray).map(|hit| scene.interaction(&ray, &hit));
    let Some(at) = hit else { return 0.0 };
    scene.light(&at).map_or(0.0, |light| light.emitted(&at, -w, &scene.textures, &WAVELENGTHS).to_rgb()[0])
}

/// Compares what sampling the light finds with what uniform directions do; returns whether there is any.
fn check_both_ways(scene: &SceneData, from: Vec3, what: &str) -> bool {
    let mut rng = Rng::new(7);
    let (mut by_light, mut by_direction) = (Running::default(), Running::default());
    for _ in 0..20_000 {
        let [a, b] = rng.uniform();
        let light = scene.lights[0].sample(from, Vec2::new(a, b), &scene.textures, &WAVELENGTHS);
        by_light.add(light.map_or(0.0, |sample| {
            let shadow = Ray::spawn_to((from, Vec3::ZERO, Vec3::ZERO), sample.end.unwrap());
            let visible = !scene.accel.occluded(&shadow);
            if visible { f64::from(sample.radiance.to_rgb()[0] / sample.pdf) } else { 0.0 }
        }));
        let w = rng.direction();
        by_direction.add(f64::from(arriving(scene, from, w) * 4.0 * PI));
    }
    let p = welch(&by_light, &by_direction);
    let (a, b) = (by_light.mean(), by_direction.mean());
    assert!(p > 1e-5 || (a == 0.0 && b == 0.0), "{what}: {a} and {b}");
    a > 0.0
}

#[test]
fn both_ways_to_find_a_shape_give_the_same_light() {
    let mut lit = 0;
    for case in &cases() {
        for (two_sided, reverse) in [(false, false), (false, true), (true, false)] {
            let scene = &scene_of(case, two_sided, reverse).data;
            let what = format!("{} {two_sided} {reverse}", case.name);
            lit += usize::from(check_both_ways(scene, case.from, &what));
        }
    }
    // Each shape is lit from the point on one side at least, or two-sided.
    assert!(lit >= 2 * cases().len(), "{lit}");
}

#[test]
fn pictures_lie_on_shapes_alike_for_samples_and_for_rays() {
    for case in &cases() {
        let scene = &scene_emitting(case, (true, None), false, picture).data;
        assert!(check_both_ways(scene, case.from, case.name), "{}", case.name);
        // What a sample finds, a ray to it finds.
        let mut rng = Rng::new(13);
        let mut compared = 0;
        for _ in 0..500 {
            let [a, b] = rng.uniform();
            let u = Vec2::new(a, b);
            let Some(sample) = scene.lights[0].sample(case.from, u, &scene.textures, &WAVELENGTHS) else {
                continue;
            };
            let ray = Ray::new(case.from, sample.wi);
            let Some(hit) = scene.accel.intersect(&ray) else { continue };
            let at = scene.interaction(&ray, &hit);
            if (at.p - sample.end.unwrap().0).length() < 1e-4 {
                compared += 1;
                let seen = scene.lights[0].emitted(&at, -sample.wi, &scene.textures, &WAVELENGTHS);
                let difference = (seen - sample.radiance).map(f32::abs).max_component();
                assert!(difference < 0.05, "{}: {seen:?} and {:?}", case.name, sample.radiance);
            }
        }
        assert!(compared > 100, "{}: {compared}", case.name);
    }
}

#[test]
fn a_picture_that_emits_has_the_power_it_is_given() {
    let all = cases();
    let convex = ["triangle", "rectangle", "sphere", "disk", "cylinder"];
    for case in all.iter().filter(|case| convex.contains(&case.name)) {
        let case = Case { to_world: Transform::scale(0.3, 0.3, 0.3).unwrap(), ..*case };
        let scene = &scene_emitting(&case, (false, Some(7.0)), false, picture).data;
        let mut rng = Rng::new(23);
        let mut flux = Running::default();
        for _ in 0..100_000 {
            let n = rng.direction();
            let [a, b] = rng.uniform();
            let sample = scene.lights[0].sample(n * 2.0, Vec2::new(a, b), &scene.textures, &WAVELENGTHS);
            flux.add(sample.map_or(0.0, |sample| {
                let received = sample.radiance.luminance() * -sample.wi.dot(n) / sample.pdf;
                f64::from(received * 4.0 * PI * 4.0)
            }));
        }
        // Parameters of disks and spheres are not uniform by area, and the picture is averaged by them.
        let tolerance = 4.5 * flux.variance_of_mean().sqrt() + 0.02 * 7.0;
        assert!((flux.mean() - 7.0).abs() < tolerance, "{}: {}", case.name, flux.mean());
        let power = scene.lights[0].power(1.0, &WAVELENGTHS).luminance();
        assert!((power - 7.0).abs() < 0.01, "{}: {power}", case.name);
    }
}

#[test]
fn a_hit_has_the_density_of_the_sample() {
    for case in &cases() {
        let scene = &scene_of(case, true, false).data;
        let mut rng = Rng::new(3);
        let mut compared = 0;
        for _ in 0..2000 {
            let [a, b] = rng.uniform();
            let Some(sample) =
                scene.lights[0].sample(case.from, Vec2::new(a, b), no_textures(), &WAVELENGTHS)
            else {
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
fn sky(width: usize, height: usize, map: SphereMap, sampled: Sampled) -> ImageEnvironment {
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
    ImageEnvironment::new(&image, map, &turned, sampled).unwrap()
}

/// A window of 1.4 × 0.9 beyond which `sky` is seen, to the upper right of the origin.
fn window(sky: Sky) -> Light {
    let turned = Transform::rotate(0.9, [0.3, 0.8, -0.5]).unwrap();
    let corner = |x: f32, y: f32| turned.point(Vec3::new(0.2 + x, -0.3 + y, 0.6));
    let corners = [corner(0.0, 0.0), corner(0.0, 0.9), corner(1.4, 0.9), corner(1.4, 0.0)];
    Light::Portal(Box::new(PortalEnvironment::new(sky, Portal::new(corners).unwrap())))
}

/// The environments, with whether sampling alone finds all of their light.
fn skies() -> Vec<(&'static str, Light, Sampled)> {
    let emission = || Emission { curve: crate::spectrum::SpectralCurve::constant(1.0), scale: 0.7 };
    let image = |sky| Light::Image(Box::new(sky));
    let equal_area = |sampled| sky(16, 16, SphereMap::EqualArea, sampled);
    let lat_long = |sampled| sky(24, 12, SphereMap::LatLong, sampled);
    vec![
        ("equal-area", image(equal_area(Sampled::Alone)), Sampled::Alone),
        ("latitude-longitude", image(lat_long(Sampled::Alone)), Sampled::Alone),
        ("equal-area, compensated", image(equal_area(Sampled::WithBsdf)), Sampled::WithBsdf),
        ("latitude-longitude, compensated", image(lat_long(Sampled::WithBsdf)), Sampled::WithBsdf),
        ("uniform", Light::Uniform(emission()), Sampled::Alone),
        ("a window to a uniform sky", window(Sky::Uniform(emission())), Sampled::Alone),
        ("a window to a sky", window(Sky::Image(equal_area(Sampled::Alone))), Sampled::Alone),
    ]
}

#[test]
fn skies_are_sampled_with_their_density() {
    let skies = skies();
    // The density of a picture by latitude grows without bound toward the poles, and that behind a window jumps at pixels that lie across
    // the bins: no matter for quadrature. These are held to it by comparing both ways to find their light.
    let unfit = |name: &str| name.starts_with("latitude") || name == "a window to a sky";
    for (name, light, _) in skies.iter().filter(|(name, ..)| !unfit(name)) {
        let sample = |u| light.sample(Vec3::ZERO, u, no_textures(), &WAVELENGTHS).map(|sample| sample.wi);
        let about = (Frame::from_z(Vec3::Y), 2.0);
        check_density((name, skies.len()), about, sample, |w| light.escaped_pdf(Vec3::ZERO, w));
    }
}

#[test]
fn both_ways_to_find_the_sky_give_the_same_light() {
    for (name, light, sampled) in skies() {
        let mut rng = Rng::new(11);
        let (mut by_light, mut by_direction) = (Running::default(), Running::default());
        // Rounding may move a direction over the border of a pixel or of a window.
        let mut moved = 0;
        for _ in 0..100_000 {
            let [a, b] = rng.uniform();
            if let Some(sample) = light.sample(Vec3::ZERO, Vec2::new(a, b), no_textures(), &WAVELENGTHS) {
                let seen = light.escaped(Vec3::ZERO, sample.wi, &WAVELENGTHS);
                let difference = (seen - sample.radiance).map(f32::abs).max_component();
                let pdf = light.escaped_pdf(Vec3::ZERO, sample.wi);
                let alike =
                    difference < 1e-2 * (1.0 + seen.max_component()) && (pdf / sample.pdf - 1.0).abs() < 1e-2;
                moved += u32::from(!alike);
                by_light.add(f64::from(sample.radiance.to_rgb()[0] / sample.pdf));
            } else {
                by_light.add(0.0);
            }
            // What is left to other ways does not count.
            let w = rng.direction();
            let is_found = sampled == Sampled::Alone || light.escaped_pdf(Vec3::ZERO, w) > 0.0;
            let seen = light.escaped(Vec3::ZERO, w, &WAVELENGTHS).to_rgb()[0];
            by_direction.add(if is_found { f64::from(seen * 4.0 * PI) } else { 0.0 });
        }
        assert!(moved < 200, "{name}: {moved}");
        assert!(welch(&by_light, &by_direction) > 1e-4, "{name}: {by_light:?} {by_direction:?}");
        if sampled == Sampled::Alone && !matches!(light, Light::Portal(_)) {
            let power = light.power(1.0, &WAVELENGTHS).to_rgb()[0];
            let expected = by_light.mean() as f32 * PI;
            assert!((power / expected - 1.0).abs() < 0.02, "{name}: {power} and {expected}");
        }
    }
}

#[test]
fn a_sky_without_structure_is_not_compensated_away() {
    let image = Image::filled(8, 8, 3, 0.3).unwrap();
    let sky = |sampled| ImageEnvironment::new(&image, SphereMap::EqualArea, &Transform::IDENTITY, sampled);
    let light = Light::Image(Box::new(sky(Sampled::WithBsdf).unwrap()));
    let pdf = light.escaped_pdf(Vec3::ZERO, Vec3::X);
    assert!((pdf * 4.0 * PI - 1.0).abs() < 1e-5, "{pdf}");
}

#[test]
fn a_portal_lights_its_inside_alone() {
    let emission = Emission { curve: crate::spectrum::SpectralCurve::constant(1.0), scale: 1.0 };
    let corners = [[0.0, 0.0], [0.0, 1.0], [2.0, 1.0], [2.0, 0.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let light = PortalEnvironment::new(Sky::Uniform(emission), Portal::new(corners).unwrap());
    let (inside, outside) = (Vec3::new(1.0, 0.5, -1.0), Vec3::new(1.0, 0.5, 1.0));
    assert!(light.sample(inside, Vec2::splat(0.3), &WAVELENGTHS).is_some());
    assert!(light.sample(outside, Vec2::splat(0.3), &WAVELENGTHS).is_none());
    for (from, w, seen) in [(inside, Vec3::Z, 1.0), (inside, Vec3::X, 0.0), (outside, Vec3::Z, 0.0)] {
        assert_eq!(light.radiance(from, w, &WAVELENGTHS).to_rgb()[0], seen);
        assert_eq!(light.pdf(from, w) > 0.0, seen > 0.0);
    }
    // A sky of radiance one sends π through each square metre.
    assert!((light.power(&WAVELENGTHS).to_rgb()[0] / (2.0 * PI) - 1.0).abs() < 0.01);
    // Corners that cross, a parallelogram, and a point.
    let [p0, p1, p2, p3] = corners;
    assert!(Portal::new([p0, p2, p1, p3]).is_none());
    assert!(Portal::new([p0, p1, p2 + Vec3::X, p3 + Vec3::X * 0.9]).is_none());
    assert!(Portal::new([p0; 4]).is_none());
}

/// A lamp that shines half as strongly downwards (−z of its own space) as upwards, and one that throws a picture of four
/// texels upwards.
fn pictured() -> [Light; 2] {
    let turned = Transform::rotate(0.7, [0.2, 1.0, 0.4]).unwrap();
    let placed = Transform::translate(0.1, -0.2, 0.3).unwrap().after(&turned).unwrap();
    let up = |i: usize| {
        SphereMap::EqualArea.direction(Vec2::new((i % 8) as f32 + 0.5, (i / 8) as f32 + 0.5) / 8.0).z
    };
    let table = Image::y_f32(8, 8, (0..64).map(|i| if up(i) > 0.0 { 1.0 } else { 0.5 }).collect()).unwrap();
    let intensity = Emission { curve: crate::spectrum::SpectralCurve::constant(3.0), scale: 1.0 };
    let slide =
        Image::rgb_f32(2, 2, vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]).unwrap();
    [
        Light::Goniometric(Box::new(GoniometricLight::new(&table, intensity, &placed).unwrap())),
        Light::Projection(Box::new(ProjectionLight::new(&slide, 1.2, &placed).unwrap().scaled(2.0))),
    ]
}

#[test]
fn pictures_are_thrown_the_right_way_round() {
    let turned = Transform::rotate(0.7, [0.2, 1.0, 0.4]).unwrap();
    let placed = Transform::translate(0.1, -0.2, 0.3).unwrap().after(&turned).unwrap();
    let [lamp, slide] = pictured();
    let arriving = |light: &Light, local: [f32; 3]| {
        let from = placed.point(local.into());
        let sample = light.sample(from, Vec2::ZERO, no_textures(), &WAVELENGTHS);
        sample.map_or([0.0; 3], |sample| sample.radiance.to_rgb())
    };
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
    assert!(close(arriving(&lamp, [0.3, 0.2, 1.0]), [3.0 / 1.13; 3]));
    assert!(close(arriving(&lamp, [0.3, 0.2, -1.0]), [1.5 / 1.13; 3]));
    // Upper left, upper right, lower left, beside the picture, and behind.
    assert!(close(arriving(&slide, [-0.2, 0.2, 1.0]), [2.0 / 1.08, 0.0, 0.0]));
    assert!(close(arriving(&slide, [0.2, 0.2, 1.0]), [0.0, 2.0 / 1.08, 0.0]));
    assert!(close(arriving(&slide, [-0.2, -0.2, 1.0]), [0.0, 0.0, 2.0 / 1.08]));
    assert!(close(arriving(&slide, [0.7, 0.2, 1.0]), [0.0; 3]));
    assert!(close(arriving(&slide, [0.2, 0.2, -1.0]), [0.0; 3]));
}

/// A light of every kind: a new kind must be added here for this to compile, then to [`with_a_place`] or [`skies`].
fn has_a_place(light: &Light) -> bool {
    match light {
        Light::Point(_) | Light::Spot(_) | Light::Goniometric(_) | Light::Projection(_) | Light::Area(_) => {
            true
        }
        Light::Distant(_) | Light::Uniform(_) | Light::Image(_) | Light::Portal(_) => false,
    }
}

/// Lights within a metre of the origin that do not hide each other's or their own light.
fn with_a_place() -> Vec<Light> {
    let emission = |value| Emission { curve: crate::spectrum::SpectralCurve::constant(value), scale: 1.0 };
    let position = Vec3::new(0.2, -0.1, 0.3);
    let (cos_inner, cos_outer, direction) = (0.9, 0.6, Vec3::new(0.6, 0.0, 0.8));
    let mut lights = vec![
        Light::Point(PointLight { position, intensity: emission(2.0) }),
        Light::Spot(SpotLight { position, direction, intensity: emission(3.0), cos_inner, cos_outer }),
    ];
    lights.extend(pictured());
    let convex =
        ["triangle", "rectangle", "sphere", "ellipsoid", "partial sphere", "disk", "ring", "cylinder"];
    for case in cases().iter().filter(|case| convex.contains(&case.name)) {
        let case = Case { to_world: Transform::scale(0.3, 0.3, 0.3).unwrap(), ..*case };
        for two_sided in [false, true] {
            // Two sides of a bent surface hide each other.
            if !two_sided || ["triangle", "rectangle", "disk"].contains(&case.name) {
                lights.push(scene_of(&case, two_sided, false).data.lights[0].clone());
            }
        }
    }
    lights
}

#[test]
fn the_power_of_a_light_is_the_flux_that_arrives_around_it() {
    for light in with_a_place() {
        assert!(has_a_place(&light) && light.bounds().is_some());
        let mut rng = Rng::new(21);
        let mut flux = Running::default();
        for _ in 0..100_000 {
            let n = rng.direction();
            let [a, b] = rng.uniform();
            let sample = light.sample(n * 2.0, Vec2::new(a, b), no_textures(), &WAVELENGTHS);
            flux.add(sample.map_or(0.0, |sample| {
                let received = sample.radiance.to_rgb()[1] * -sample.wi.dot(n) / sample.pdf;
                f64::from(received * 4.0 * PI * 4.0)
            }));
        }
        let power = f64::from(light.power(1.0, &WAVELENGTHS).to_rgb()[1]);
        let deviation = flux.variance_of_mean().sqrt();
        let tolerance = 4.5 * deviation + 2e-3 * power;
        assert!(
            (flux.mean() - power).abs() < tolerance,
            "{light:?}: {power}, not {} ± {deviation}",
            flux.mean()
        );
    }
    // A portal is chosen as if it were a lamp in the place of its window.
    let is_portal = |light: &Light| matches!(light, Light::Portal(_));
    assert!(
        skies()
            .iter()
            .all(|(_, light, _)| !has_a_place(light) && light.bounds().is_some() == is_portal(light))
    );
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
        portal: None,
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
    let table = Image::y_f32(8, 8, (0..64).map(|i| (i % 5) as f32).collect()).unwrap();
    let table = description.images.push(Arc::new(table), Origin::default());
    let pictured = [
        sahl_scene::Light::Goniometric {
            intensity: white(),
            scale: 2.0,
            power: Some(5.0),
            image: table,
            light_to_world: Transform::IDENTITY,
        },
        sahl_scene::Light::Projection {
            image,
            scale: 2.0,
            power: Some(5.0),
            fov: 1.1,
            light_to_world: Transform::IDENTITY,
        },
    ];
    for light in lights.into_iter().chain(pictured) {
        description.lights.push(light, Origin::default());
    }
    let scene = build(&description, &crate::BuildOptions::default()).0.unwrap().data;
    let mut rng = Rng::new(5);
    let (mut irradiance, mut flux) = ([0.0; 2], [0.0; 4]);
    let count = 200_000;
    for _ in 0..count {
        let w = rng.direction();
        for (light, irradiance) in scene.lights.iter().zip(&mut irradiance) {
            let radiance = light.escaped(Vec3::ZERO, w, &WAVELENGTHS).luminance();
            *irradiance += f64::from(radiance * w.y.max(0.0) * 4.0 * PI) / f64::from(count);
        }
        for (light, flux) in scene.lights[2..].iter().zip(&mut flux) {
            let sample = light.sample(w, Vec2::ZERO, no_textures(), &WAVELENGTHS);
            let received = sample.map_or(0.0, |sample| sample.radiance.luminance() * 4.0 * PI);
            *flux += f64::from(received) / f64::from(count);
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
