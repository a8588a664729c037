//! Scenes whose images are known in closed form, under every integrator that can render them and every sampler.

use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use crate::common::*;
use sahl_image::Image;
use sahl_math::{Transform, Vec3};
use sahl_scene::{
    Coefficients, Filter, Geometry, Integrator, Light, LightSampler, Material, Medium, MediumInterface,
    Origin, PathTracer, Radiance, SceneDesc, Spectrum, TriangleMesh,
};

const WHITTED: Integrator = Integrator::Whitted { max_depth: 3 };

/// Runs `check` for each of the integrators and each sampler.
fn with_each(scene: &SceneDesc, integrators: &[Integrator], check: impl Fn(&SceneDesc, &str)) {
    for &integrator in integrators {
        for kind in SAMPLERS {
            let mut scene = scene.clone();
            scene.integrator = integrator;
            scene.sampler.kind = kind;
            check(&scene, &format!("{integrator:?}, {kind:?}"));
        }
    }
}

/// A floor of albedo one half at z = 0, seen from above through a window of ± `half`.
fn floor(resolution: u32, samples: u32, half: f32) -> SceneDesc {
    let mut scene = empty(resolution, samples);
    let material = diffuse(&mut scene, 0.5);
    let geometry = patch(&mut scene, square(50.0, 0.0));
    add(&mut scene, geometry, material);
    look_down(&mut scene, 0.5, half);
    scene
}

#[test]
fn a_convex_body_in_a_white_sky_shows_its_albedo() {
    let mut scene = empty(8, 64);
    let material = diffuse(&mut scene, 0.6);
    add(&mut scene, sphere(1.0), material);
    look_down(&mut scene, 3.0, 0.6);
    sky(&mut scene, grey(2.0));
    with_each(&scene, &[path(1), path(9)], |scene, what| {
        for &value in values(&rendered(scene).film.develop()) {
            assert!((value - 1.2).abs() < 1e-4, "{what}: {value}");
        }
    });
    with_each(&scene, &[WHITTED], |scene, what| expect_mean(scene, 1.2, 0.05, what));
    with_each(&scene, &[path(0)], |scene, what| expect_mean(scene, 0.0, 0.0, what));
}

#[test]
fn glass_in_a_white_sky_is_invisible() {
    let mut scene = empty(8, 16);
    let material = glass(&mut scene);
    add(&mut scene, sphere(1.0), material);
    look_down(&mut scene, 3.0, 0.99);
    sky(&mut scene, grey(1.0));
    with_each(&scene, &[path(200)], |scene, what| {
        for &value in values(&rendered(scene).film.develop()) {
            assert!((value - 1.0).abs() < 1e-3, "{what}: {value}");
        }
    });
    // The tree ends where branches carry less than a four-thousandth.
    with_each(&scene, &[Integrator::Whitted { max_depth: 100 }], |scene, what| {
        for &value in values(&rendered(scene).film.develop()) {
            assert!(value > 0.99 && value < 1.001, "{what}: {value}");
        }
    });
}

#[test]
fn point_spot_and_distant_light_fall_on_a_floor_as_they_should() {
    let (position, intensity) = (Vec3::new(0.3, -0.2, 2.0), [3.0, 2.0, 1.0]);
    let axis = Vec3::new(0.1, 0.2, -1.0).normalize();
    let down = Vec3::new(0.5, 0.3, -1.0).normalize();
    let lights: [(Light, &dyn Fn(Vec3) -> f32); 3] = [
        (Light::Point { intensity: Spectrum::srgb(intensity), scale: 2.0, power: None, position }, &|p| {
            2.0 * (position.z / (position - p).length()) / (position - p).length_squared()
        }),
        (
            Light::Spot {
                intensity: Spectrum::srgb(intensity),
                scale: 1.0,
                power: None,
                position,
                direction: axis,
                angle: 0.5,
                penumbra: 0.3,
            },
            &|p| {
                let to_floor = (p - position).normalize();
                let (inner, outer) = (0.2_f32.cos(), 0.5_f32.cos());
                let t = ((to_floor.dot(axis) - outer) / (inner - outer)).clamp(0.0, 1.0);
                t * t * (3.0 - 2.0 * t) * -to_floor.z / (p - position).length_squared()
            },
        ),
        (
            Light::Distant {
                radiance: Spectrum::srgb(intensity),
                scale: 1.0,
                illuminance: None,
                direction: down,
            },
            &|_| -down.z,
        ),
    ];
    for (light, irradiance) in lights {
        let mut scene = floor(9, 1, 1.0);
        scene.filter = Filter::Box { radius: [1e-4; 2] };
        scene.lights.push(light.clone(), Origin::default());
        with_each(&scene, &[path(1), path(3), WHITTED], |scene, what| {
            let image = rendered(scene).film.develop();
            for (i, rgb) in values(&image).chunks(3).enumerate() {
                let place = |k: usize| (k as f32 + 0.5) / 9.0 * 2.0 - 1.0;
                let p = Vec3::new(place(i % 9), -place(i / 9), 0.0);
                for (found, intensity) in rgb.iter().zip(intensity) {
                    let expected = 0.5 / PI * irradiance(p) * intensity;
                    assert!(
                        (found - expected).abs() < 2e-3 * expected + 1e-4,
                        "{what}: {found}, not {expected}"
                    );
                }
            }
        });
    }
}

/// Irradiance over radiance at a point below the centre of a rectangle of size 2a × 2b at height h, parallel to the floor.
///
/// Four times the configuration factor of a corner: Howell, *A Catalog of Radiation Heat Transfer Configuration
/// Factors*, B-3.
fn rectangle_irradiance(a: f64, b: f64, h: f64) -> f64 {
    let (a, b) = (a / h, b / h);
    let part = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
    4.0 * 0.5 * (part(a, b) + part(b, a))
}

#[test]
fn area_lights_give_their_irradiance() {
    const RADIANCE: f32 = 3.0;
    let down = |corners: [[f32; 3]; 4]| [corners[1], corners[0], corners[3], corners[2]];
    let facing_down = |z: f64| {
        Transform::translate(0.0, 0.0, z)
            .unwrap()
            .after(&Transform::rotate(std::f64::consts::PI, [1.0, 0.0, 0.0]).unwrap())
    };
    type Make = Box<dyn Fn(&mut SceneDesc) -> (Geometry, Transform)>;
    let cases: Vec<(&str, Make, f64)> = vec![
        (
            "sphere above",
            Box::new(|_| (sphere(0.5), Transform::translate(0.0, 0.0, 2.0).unwrap())),
            std::f64::consts::PI * 0.25 / 4.0,
        ),
        (
            "sphere aside",
            Box::new(|_| (sphere(0.7), Transform::translate(1.5, 1.0, 2.0).unwrap())),
            std::f64::consts::PI * 0.49 / 7.25 * 2.0 / 7.25_f64.sqrt(),
        ),
        (
            "disk",
            Box::new(move |_| {
                let disk = Geometry::Disk { height: 0.0, radius: 0.8, inner_radius: 0.0, phi_max: TAU };
                (disk, facing_down(1.2).unwrap())
            }),
            std::f64::consts::PI * 0.64 / (0.64 + 1.44),
        ),
        (
            "ring",
            Box::new(move |_| {
                let ring = Geometry::Disk { height: 0.0, radius: 0.8, inner_radius: 0.5, phi_max: TAU };
                (ring, facing_down(1.2).unwrap())
            }),
            std::f64::consts::PI * (0.64 / (0.64 + 1.44) - 0.25 / (0.25 + 1.44)),
        ),
        (
            "rectangle",
            Box::new(move |scene| (patch(scene, down(square(0.6, 0.9))), Transform::IDENTITY)),
            rectangle_irradiance(0.6, 0.6, 0.9),
        ),
        (
            "two triangles",
            Box::new(move |scene| (quad(scene, down(square(0.6, 0.9))), Transform::IDENTITY)),
            rectangle_irradiance(0.6, 0.6, 0.9),
        ),
        (
            "mirrored and stretched rectangle",
            Box::new(move |scene| {
                (patch(scene, down(square(0.6, 0.9))), Transform::scale(-2.0, 1.0, 1.0).unwrap())
            }),
            rectangle_irradiance(1.2, 0.6, 0.9),
        ),
    ];
    for (name, make, irradiance) in cases {
        let mut scene = floor(4, 256, 1e-4);
        let (geometry, transform) = make(&mut scene);
        let black = diffuse(&mut scene, 0.0);
        let shape = add_placed(&mut scene, geometry, black, transform);
        emit(&mut scene, shape, RADIANCE);
        let expected = 0.5 / std::f64::consts::PI * f64::from(RADIANCE) * irradiance;
        with_each(&scene, &[path(1), WHITTED], |scene, what| {
            expect_mean(scene, expected, 0.02, &format!("{name}, {what}"));
        });
    }
}

/// Puts a ball of thin fog where nothing sees it.
fn fog_far_away(scene: &mut SceneDesc) {
    let thin = Coefficients { sigma_a: grey(1e-3), sigma_s: grey(0.0), scale: 1.0, g: 0.0 };
    let medium = Medium::Homogeneous { coefficients: thin, emission: None };
    let inside = Some(scene.media.push(medium, Origin::default()));
    let border = scene.materials.push(Material::Interface, Origin::default());
    let ball = add_placed(scene, sphere(0.1), border, Transform::translate(0.0, 0.0, -9.0).unwrap());
    scene.shapes[ball].media = Some(MediumInterface { inside, outside: None });
}

#[test]
fn a_long_strip_of_light_is_not_in_its_own_shadow() {
    // Edge functions of a shape as slender as this have errors that move its plane by more than segments to it leave free.
    let (low, high) = (1.85_f32, 2.15_f32);
    let strip = [[40.0, low, 2.0], [-40.0, low, 2.0], [40.0, high, 2.0], [-40.0, high, 2.0]];
    let beside = |y: f32| 0.5 * rectangle_irradiance(40.0, f64::from(y), 2.0);
    let expected = 0.5 / std::f64::consts::PI * (beside(high) - beside(low));
    type Make = fn(&mut SceneDesc, [[f32; 3]; 4]) -> Geometry;
    for (make, samples) in [(patch as Make, 256), (quad, 8192)] {
        for fog in [false, true] {
            let mut scene = floor(4, samples, 1e-4);
            let geometry = make(&mut scene, strip);
            let black = diffuse(&mut scene, 0.0);
            let shape = add(&mut scene, geometry, black);
            emit(&mut scene, shape, 1.0);
            if fog {
                fog_far_away(&mut scene);
            }
            for integrator in if fog { vec![path(1)] } else { vec![path(1), WHITTED] } {
                scene.integrator = integrator;
                expect_mean(&scene, expected, 0.02, &format!("{integrator:?}, {samples}, fog: {fog}"));
            }
        }
    }
}

#[test]
fn an_emitting_enclosure_sums_the_geometric_series() {
    const ALBEDO: f32 = 0.5;
    let sphere_inside = {
        let mut scene = empty(8, 128);
        let material = diffuse(&mut scene, ALBEDO);
        let shape = add(&mut scene, sphere(2.0), material);
        scene.shapes[shape].reverse_orientation = true;
        emit(&mut scene, shape, 1.0);
        scene
    };
    let cube_inside = {
        let mut scene = empty(8, 128);
        let material = diffuse(&mut scene, ALBEDO);
        for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
            for quarter in 0..4 {
                if axis[0] == 0.0 && quarter % 2 == 0 {
                    continue;
                }
                let turn = Transform::rotate(f64::from(quarter) * std::f64::consts::FRAC_PI_2, axis).unwrap();
                let geometry = patch(&mut scene, square(1.0, -1.0));
                let shape = add_placed(&mut scene, geometry, material, turn);
                emit(&mut scene, shape, 1.0);
            }
        }
        scene
    };
    for (name, scene) in [("sphere", sphere_inside), ("cube", cube_inside)] {
        for depth in [0, 1, 2, 4, 100] {
            let expected = (1.0 - f64::from(ALBEDO).powi(depth + 1)) / (1.0 - f64::from(ALBEDO));
            with_each(&scene, &[path(depth as u32)], |scene, what| {
                expect_mean(scene, expected, 0.02, &format!("{name}, {what}"));
            });
        }
    }
}

#[test]
fn a_thousand_lights_add_up_under_either_choice() {
    let mut scene = floor(6, 512, 1.0);
    scene.filter = Filter::Box { radius: [1e-4; 2] };
    let lights: Vec<(Vec3, f32)> = (0..1000)
        .map(|i| {
            let t = i as f32;
            (
                Vec3::new(2.0 * (t * 0.7).sin(), 2.0 * (t * 1.3).cos(), 1.0 + 0.001 * t),
                0.01 * (1.0 + t % 10.0),
            )
        })
        .collect();
    for &(position, intensity) in &lights {
        let light = Light::Point { intensity: grey(intensity), scale: 1.0, power: None, position };
        scene.lights.push(light, Origin::default());
    }
    let mut expected = 0.0;
    for i in 0..36 {
        let place = |k: usize| (k as f32 + 0.5) / 6.0 * 2.0 - 1.0;
        let p = Vec3::new(place(i % 6), place(i / 6), 0.0);
        for &(position, intensity) in &lights {
            let d = position - p;
            expected += f64::from(0.5 / PI * intensity * d.z / d.length() / d.length_squared()) / 36.0;
        }
    }
    for light_sampler in [LightSampler::Tree, LightSampler::Power, LightSampler::Uniform] {
        let settings = PathTracer { max_depth: 1, light_sampler, ..PathTracer::default() };
        with_each(&scene, &[Integrator::Path(settings)], |scene, what| {
            expect_mean(scene, expected, 0.02, what);
        });
    }
    with_each(&scene, &[WHITTED], |scene, what| {
        let mut scene = scene.clone();
        scene.sampler.samples = 1;
        let (found, _) = mean_of_one(&scene);
        assert!((found - expected).abs() < 1e-3 * expected, "{what}: {found}, not {expected}");
    });
}

/// The mean of an image of one sample a pixel, of which there is no variance.
fn mean_of_one(scene: &SceneDesc) -> (f64, usize) {
    let image = rendered(scene).film.develop();
    let count = values(&image).len();
    (values(&image).iter().map(|&x| f64::from(x)).sum::<f64>() / count as f64, count)
}

#[test]
fn an_image_of_the_sky_lights_the_floor() {
    // Bright in one spot, dark below the horizon: the floor sees the upper half, weighted by the cosine.
    let (width, height) = (32, 16);
    let texel = |x: usize, y: usize| match (x, y) {
        (5, 3) => 100.0,
        (_, 0..8) => 1.0,
        _ => 0.0,
    };
    let rgb = |i: usize| texel(i / 3 % width, i / 3 / width);
    let image = Image::rgb_f32(width, height, (0..width * height * 3).map(rgb).collect()).unwrap();
    let mut scene = floor(8, 512, 0.5);
    let image = scene.images.push(Arc::new(image), Origin::default());
    // The image's up, +y, is the floor's, +z.
    let upright = Transform::rotate(f64::from(FRAC_PI_2), [1.0, 0.0, 0.0]).unwrap();
    let light = Light::Infinite {
        radiance: Radiance::LatLong(image),
        scale: 1.0,
        illuminance: Some(3.0),
        light_to_world: upright,
        portal: None,
    };
    scene.lights.push(light, Origin::default());
    with_each(&scene, &[path(1)], |scene, what| {
        let (found, deviation) = mean(scene);
        let expected = 0.5 / std::f64::consts::PI * 3.0;
        // The illuminance is normalised by a sum over parts of pixels.
        assert!(deviation < 0.01 && (found / expected - 1.0).abs() < 0.01, "{what}: {found} ± {deviation}");
    });
}

#[test]
fn a_sky_through_a_portal_gives_the_irradiance_of_the_window() {
    // A window of 2 × 1 at height 1.5, parallel to the floor, which is seen at the point below its middle.
    let corners = [[-1.0, -0.5], [-1.0, 0.5], [1.0, 0.5], [1.0, -0.5]].map(|[x, y]| Vec3::new(x, y, 1.5));
    let expected = 2.0 * 0.5 / std::f64::consts::PI * rectangle_irradiance(1.0, 0.5, 1.5);
    let image = Image::filled(16, 16, 3, 2.0).unwrap();
    let mut scene = floor(4, 256, 1e-3);
    let image = scene.images.push(Arc::new(image), Origin::default());
    for radiance in [Radiance::Constant(grey(2.0)), Radiance::EqualArea(image)] {
        let mut scene = scene.clone();
        scene.lights.push(
            Light::Infinite {
                radiance,
                scale: 1.0,
                illuminance: None,
                light_to_world: Transform::IDENTITY,
                portal: Some(corners),
            },
            Origin::default(),
        );
        with_each(&scene, &[path(1), path(3), WHITTED], |scene, what| {
            expect_mean(scene, expected, 0.01, what);
        });
    }
}

#[test]
fn a_slide_and_a_lamp_with_a_table_light_the_floor() {
    // Both hang at height 2 and look down: z is turned to −z, y to −y.
    let down = Transform::translate(0.0, 0.0, 2.0)
        .unwrap()
        .after(&Transform::rotate(std::f64::consts::PI, [1.0, 0.0, 0.0]).unwrap())
        .unwrap();
    let mut scene = floor(2, 1, 0.5);
    scene.filter = Filter::Box { radius: [1e-4; 2] };
    let slide = vec![1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 0.0, 0.0, 4.0, 0.0, 0.0];
    let slide = scene.images.push(Arc::new(Image::rgb_f32(2, 2, slide).unwrap()), Origin::default());
    let table = scene.images.push(Arc::new(Image::filled(4, 4, 1, 0.5).unwrap()), Origin::default());
    let projection =
        Light::Projection { image: slide, scale: 1.0, power: None, fov: FRAC_PI_2, light_to_world: down };
    let lamp = Light::Goniometric {
        intensity: grey(3.0),
        scale: 1.0,
        power: None,
        image: table,
        light_to_world: down,
    };
    // At (±¼, ±¼): the falloff of a point with the floor's cosine. The image's top is at −y, that is at its bottom.
    let falloff = 0.5 / PI * 2.0 / (4.0_f32 + 0.125).powf(1.5);
    for (light, intensities) in [(projection, [3.0, 4.0, 1.0, 2.0]), (lamp, [1.5; 4])] {
        let mut scene = scene.clone();
        scene.lights.push(light, Origin::default());
        with_each(&scene, &[path(1), WHITTED], |scene, what| {
            let image = rendered(scene).film.develop();
            for (rgb, intensity) in values(&image).chunks(3).zip(intensities) {
                let expected = intensity * falloff;
                assert!((rgb[0] - expected).abs() < 1e-3 * expected, "{what}: {}, not {expected}", rgb[0]);
            }
        });
    }
}

#[test]
fn ambient_occlusion_counts_what_is_near() {
    // A ceiling at height 1 hides the directions that reach it within 2: the cone whose cosine exceeds one half.
    let mut scene = floor(6, 512, 0.1);
    let material = diffuse(&mut scene, 0.5);
    let geometry = quad(&mut scene, square(50.0, 1.0));
    add(&mut scene, geometry, material);
    with_each(&scene, &[Integrator::Ao { max_distance: 2.0 }], |scene, what| {
        expect_mean(scene, 0.25, 0.02, what);
    });
    with_each(&scene, &[Integrator::Ao { max_distance: 0.9 }], |scene, what| {
        expect_mean(scene, 1.0, 0.0, what);
    });
}

#[test]
fn normals_become_colours() {
    let mut scene = floor(2, 1, 0.5);
    scene.integrator = Integrator::Normals;
    assert_eq!(values(&rendered(&scene).film.develop())[..3], [0.5, 0.5, 1.0]);
    // A mesh with its own normals: the shading normal is the interpolated one.
    let mut scene = empty(1, 1);
    let material = diffuse(&mut scene, 0.5);
    let positions = square(1.0, 0.0).map(Vec3::from).into();
    let mesh = TriangleMesh {
        indices: [[0, 1, 3], [0, 3, 2]].into(),
        positions,
        normals: Some([Vec3::new(0.0, 3.0, 4.0); 4].into()),
        tangents: None,
        uvs: None,
        face_indices: None,
    };
    let mesh = scene.triangle_meshes.push(mesh, Origin::default());
    add(&mut scene, Geometry::Triangles(mesh), material);
    look_down(&mut scene, 1.0, 0.5);
    scene.integrator = Integrator::Normals;
    let found = values(&rendered(&scene).film.develop()).to_vec();
    for (found, expected) in found.iter().zip([0.5, 0.8, 0.9]) {
        assert!((found - expected).abs() < 1e-6, "{found:?}");
    }
}

#[test]
fn the_shading_normal_decides_the_cosine() {
    let mut scene = empty(4, 1);
    let material = diffuse(&mut scene, 0.5);
    let ns = Vec3::new(0.0, 0.6, 0.8);
    let mesh = TriangleMesh {
        indices: [[0, 1, 3], [0, 3, 2]].into(),
        positions: square(1.0, 0.0).map(Vec3::from).into(),
        normals: Some([ns; 4].into()),
        tangents: None,
        uvs: None,
        face_indices: None,
    };
    let mesh = scene.triangle_meshes.push(mesh, Origin::default());
    add(&mut scene, Geometry::Triangles(mesh), material);
    look_down(&mut scene, 1.0, 0.5);
    // Above the horizon of both normals, and above that of the shading normal alone.
    for (toward, lit) in [(Vec3::new(0.3, 0.4, 0.8), true), (Vec3::new(0.0, 0.9, -0.2), false)] {
        let direction = -toward.normalize();
        let mut scene = scene.clone();
        let radiance = grey(1.0);
        let light = Light::Distant { radiance, scale: 1.0, illuminance: None, direction };
        scene.lights.push(light, Origin::default());
        let expected = if lit { 0.5 / PI * ns.dot(-direction) } else { 0.0 };
        with_each(&scene, &[path(1), WHITTED], |scene, what| {
            for &value in values(&rendered(scene).film.develop()) {
                assert!((value - expected).abs() < 1e-5, "{what}: {value}, not {expected}");
            }
        });
    }
}
