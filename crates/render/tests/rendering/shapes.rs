//! Shapes that are more than their accelerator's geometry: what they look like, and what they emit.

use std::f64::consts::PI;

use crate::common::*;
use sahl_math::{AnimatedTransform, Transform, Vec2, Vec3};
use sahl_render::{Aov, BuildOptions, RenderOptions, build, render};
use sahl_scene::{
    ConductorReflectance, CurveKind, Curves, Filter, FloatParam, Geometry, Instance, Integrator, Light,
    Material, Object, Origin, Quirks, Roughness, SceneDesc, Spectrum, SpectrumParam, Texture, TextureMapping,
    TriangleMesh, UvMapping,
};

/// A straight strip along y, two wide, over the square that [`look_down`] sees.
fn strip(kind: CurveKind) -> Curves {
    let points = [-3.0, -1.0, 1.0, 3.0].map(|y| Vec3::new(0.0, y, 0.0));
    let normals = if kind == CurveKind::Ribbon { vec![[Vec3::Z; 2]] } else { Vec::new() };
    Curves {
        kind,
        points: [points].into(),
        widths: [[2.0; 2]].into(),
        normals: normals.into(),
        split_depth: 2,
    }
}

fn scene_with(curves: Curves) -> SceneDesc {
    let mut scene = empty(4, 16);
    let material = diffuse(&mut scene, 0.5);
    let curves = scene.curves.push(curves, Origin::default());
    add(&mut scene, Geometry::Curves(curves), material);
    look_down(&mut scene, 5.0, 0.9);
    scene
}

#[test]
fn a_straight_curve_under_the_sky_is_as_bright_as_its_albedo() {
    for kind in [CurveKind::Flat, CurveKind::Cylinder, CurveKind::Ribbon] {
        let mut scene = scene_with(strip(kind));
        sky(&mut scene, grey(1.0));
        expect_mean(&scene, 0.5, 0.02, &format!("{kind:?}"));
    }
}

#[test]
fn a_lamp_lights_a_curve_from_where_rays_leave_it() {
    // Rays leave a flat curve its width, two, above what was hit. The lamp, a square of four by four, is at a height of six.
    let mut scene = scene_with(strip(CurveKind::Flat));
    let black = diffuse(&mut scene, 0.0);
    let [p, q, r, s] = square(2.0, 6.0);
    let lamp = quad(&mut scene, [q, p, s, r]);
    let lamp = add(&mut scene, lamp, black);
    emit(&mut scene, lamp, 1.0);
    look_down(&mut scene, 5.0, 1e-3);
    scene.sampler.samples = 256;
    // The form factor of a square seen from four below its middle, each quarter by its corner at one half of that distance.
    let half = 2.0_f64 / 4.0;
    let root = half.hypot(1.0);
    let form_factor = 4.0 / PI * half / root * (half / root).atan();
    for integrator in [path(1), path(5), Integrator::Whitted { max_depth: 1 }] {
        scene.integrator = integrator;
        expect_mean(&scene, 0.5 * form_factor, 0.01, "the lamp above a curve");
    }
}

#[test]
fn curves_have_coordinates_along_and_across() {
    let mut scene = scene_with(strip(CurveKind::Flat));
    scene.filter = Filter::Box { radius: [1e-4; 2] };
    let shape = scene.world[0];
    scene.shapes[shape].shape_to_world = Transform::scale(0.5, 1.0, 1.0).unwrap();
    let options =
        RenderOptions { threads: 1, aovs: vec![Aov::Uv, Aov::Position], ..RenderOptions::default() };
    let layers = render(&built(&scene), &options, &()).film.layers();
    let [uv, position] = [&layers[1].image, &layers[2].image].map(values);
    let channels = layers[1].image.channels;
    for (uv, p) in uv.chunks(channels).zip(position.chunks(3)) {
        let is_hit = p.iter().any(|&x| x != 0.0);
        assert_eq!(is_hit, p[0].abs() < 0.5 && p[1] != 0.0, "{p:?}");
        if is_hit {
            assert!((uv[0] - (p[1] + 3.0) / 6.0).abs() < 1e-3, "{uv:?} at {p:?}");
            let across = (uv[1] - 0.5).abs();
            assert!((across - p[0].abs()).abs() < 1e-3, "{uv:?} at {p:?}");
        }
    }
}

#[test]
fn a_curve_that_should_emit_does_not_and_says_so() {
    let mut scene = scene_with(strip(CurveKind::Flat));
    let shape = scene.world[0];
    emit(&mut scene, shape, 1.0);
    let (built, diagnostics) = build(&scene, &BuildOptions::default());
    let codes: Vec<&str> = diagnostics.iter().map(|diagnostic| diagnostic.code).collect();
    assert!(built.is_some() && codes == ["curve-area-light"], "{codes:?}");
}

#[test]
fn leaky_normals_that_look_away_stay() {
    // The square z = -x, which is seen from its front is seen, the front of its normals is not.
    let n = Vec3::new(1.0, 0.0, -0.25).normalize();
    let mut scene = empty(4, 16);
    let material = diffuse(&mut scene, 0.5);
    let positions = square(2.0, 0.0).map(|[x, y, _]| Vec3::new(x, y, -x));
    let mesh = TriangleMesh {
        indices: [[0, 1, 3], [0, 3, 2]].into(),
        positions: positions.into(),
        normals: Some([n; 4].into()),
        ..TriangleMesh::default()
    };
    let mesh = Geometry::Triangles(scene.triangle_meshes.push(mesh, Origin::default()));
    add(&mut scene, mesh, material);
    look_down(&mut scene, 5.0, 0.9);
    let direction = -Vec3::Z;
    let sun = Light::Distant { radiance: grey(1.0), scale: 1.0, illuminance: None, direction };
    scene.lights.push(sun, Origin::default());
    for (leaky_normals, cosine) in [(false, f64::sqrt(0.5)), (true, f64::from(-n.z))] {
        scene.quirks = Quirks { leaky_normals, ..Quirks::default() };
        expect_mean(&scene, 0.5 / PI * cosine, 0.01, &format!("leaky: {leaky_normals}"));
    }
}

/// A square of brightness one at the height 1 that covers what [`look_down`] sees, its alpha as given.
fn veil(alpha: FloatParam) -> SceneDesc {
    let mut scene = empty(8, 256);
    let material = diffuse(&mut scene, 0.0);
    let geometry = quad(&mut scene, square(2.0, 1.0));
    let shape = add(&mut scene, geometry, material);
    emit(&mut scene, shape, 1.0);
    scene.shapes[shape].alpha = alpha;
    look_down(&mut scene, 5.0, 0.9);
    scene
}

#[test]
fn alpha_is_the_share_that_is_seen() {
    for alpha in [0.25, 0.5, 1.0, 1.5] {
        let mut scene = veil(FloatParam::Constant(alpha));
        // Layers decide for themselves.
        let geometry = quad(&mut scene, square(2.0, 0.0));
        let material = diffuse(&mut scene, 0.0);
        let behind = add(&mut scene, geometry, material);
        emit(&mut scene, behind, 3.0);
        scene.shapes[behind].alpha = FloatParam::Constant(alpha);
        let share = f64::from(alpha.min(1.0));
        let expected = share + (1.0 - share) * share * 3.0;
        expect_mean(&scene, expected, 0.03, &format!("alpha {alpha}"));
    }
}

#[test]
fn both_sides_of_a_sphere_have_their_alpha() {
    let mut scene = empty(8, 256);
    let material = diffuse(&mut scene, 0.0);
    let shape = add(&mut scene, sphere(3.0), material);
    scene.shapes[shape].alpha = FloatParam::Constant(0.5);
    sky(&mut scene, grey(1.0));
    look_down(&mut scene, 5.0, 0.9);
    expect_mean(&scene, 0.25, 0.03, "through two half-transparent sides");
}

#[test]
fn shadows_are_as_thin_as_what_casts_them() {
    for alpha in [0.0, 0.3, 1.0] {
        let mut scene = empty(8, 256);
        let material = diffuse(&mut scene, 0.5);
        let geometry = quad(&mut scene, square(2.0, 0.0));
        add(&mut scene, geometry, material);
        let geometry = patch(&mut scene, square(50.0, 10.0));
        let screen = add(&mut scene, geometry, material);
        scene.shapes[screen].alpha = FloatParam::Constant(alpha);
        let light = Light::Distant {
            radiance: grey(std::f32::consts::PI),
            scale: 1.0,
            illuminance: None,
            direction: -Vec3::Z,
        };
        scene.lights.push(light, Origin::default());
        scene.integrator = path(1);
        look_down(&mut scene, 5.0, 0.9);
        let expected = 0.5 * (1.0 - f64::from(alpha));
        if expected > 0.0 {
            expect_mean(&scene, expected, 0.03, &format!("alpha {alpha}"));
        } else {
            assert_eq!(mean(&scene).0, 0.0);
        }
    }
}

/// A floor lit by a lamp of which rays meet the share `alpha`.
fn floor_under_lamp(alpha: FloatParam) -> SceneDesc {
    let mut scene = empty(8, 256);
    let material = diffuse(&mut scene, 0.8);
    let geometry = quad(&mut scene, square(2.0, 0.0));
    add(&mut scene, geometry, material);
    let dark = diffuse(&mut scene, 0.0);
    let [a, b, c, d] = square(1.0, 3.0);
    let geometry = quad(&mut scene, [b, a, d, c]);
    let lamp = add(&mut scene, geometry, dark);
    emit(&mut scene, lamp, 4.0);
    scene.shapes[lamp].alpha = alpha;
    look_down(&mut scene, 2.0, 0.9);
    scene
}

#[test]
fn lamps_give_the_share_of_their_light_that_is_there() {
    let (whole, _) = mean(&floor_under_lamp(FloatParam::Constant(1.0)));
    assert!(whole > 0.1);
    expect_mean(&floor_under_lamp(FloatParam::Constant(0.25)), 0.25 * whole, 0.02, "a quarter");
    expect_mean(&floor_under_lamp(FloatParam::Constant(0.0)), whole, 0.02, "unseen, but not dark");
    // A texture that is the same everywhere in a way that is not known beforehand: rays alone find the lamp.
    let mut scene = floor_under_lamp(FloatParam::Constant(1.0));
    let half = SpectrumParam::Constant(Spectrum::Constant(0.5));
    let checks = Texture::Checkerboard {
        mapping: TextureMapping::Uv(UvMapping::default()),
        even: half.clone(),
        odd: half,
    };
    let checks = scene.textures.push(checks, Origin::default());
    let lamp = scene.world[1];
    scene.shapes[lamp].alpha = FloatParam::Texture(checks);
    expect_mean(&scene, 0.5 * whole, 0.1, "half, by rays alone");
}

#[test]
fn a_displaced_plane_is_where_its_texture_lifts_it() {
    let displaced = |height: f32, edge_length: f32| {
        let mut scene = empty(4, 4);
        let material = diffuse(&mut scene, 0.5);
        let mesh = TriangleMesh {
            indices: [[0, 1, 3], [0, 3, 2]].into(),
            positions: square(1.0, 0.0).map(Vec3::from).into(),
            uvs: Some([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(Vec2::from).into()),
            ..TriangleMesh::default()
        };
        let mesh = scene.triangle_meshes.push(mesh, Origin::default());
        let displacement = FloatParam::Constant(height);
        let place = Transform::scale(2.0, 2.0, 2.0).unwrap();
        add_placed(&mut scene, Geometry::Displaced { mesh, displacement, edge_length }, material, place);
        sky(&mut scene, grey(1.0));
        look_down(&mut scene, 5.0, 0.9);
        scene
    };
    let scene = displaced(0.5, 0.4);
    let options = RenderOptions { threads: 1, aovs: vec![Aov::Depth], ..RenderOptions::default() };
    let rendered = render(&built(&scene), &options, &());
    let depth = &rendered.film.layers()[1].image;
    assert!(values(depth).iter().all(|z| (z - 4.0).abs() < 1e-5), "half a metre, doubled by the placement");
    assert!(built(&scene).stats().triangles > 2 * 100);
    let (none, diagnostics) = build(&displaced(0.5, 1e-7), &BuildOptions::default());
    let codes: Vec<&str> = diagnostics.iter().map(|diagnostic| diagnostic.code).collect();
    assert!(none.is_none() && codes == ["displacement-too-fine"], "{codes:?}");
}

#[test]
fn what_is_not_there_does_not_hide_what_lies_in_the_same_place() {
    let mut scene = empty(8, 16);
    let material = diffuse(&mut scene, 0.0);
    let geometry = quad(&mut scene, square(2.0, 0.0));
    let veil = add(&mut scene, geometry, material);
    scene.shapes[veil].alpha = FloatParam::Constant(1e-9);
    let geometry = quad(&mut scene, square(2.0, 0.0));
    let lamp = add(&mut scene, geometry, material);
    emit(&mut scene, lamp, 1.0);
    look_down(&mut scene, 5.0, 1.0);
    expect_mean(&scene, 1.0, 0.0, "a lamp behind nothing");
}

/// What carries the square of [`crossing`].
#[derive(Clone, Copy, Debug)]
enum Carrier {
    /// It moves itself.
    Shape,
    /// It stands in an object of which an instance moves.
    Instance,
    /// It moves half as far in an object that is placed twice as large.
    Part,
    /// It moves a third of the way in an object that moves two thirds.
    Both,
}

/// A black square of side one that crosses the view, two wide, before a white ground.
fn crossing(carrier: Carrier) -> SceneDesc {
    let mut scene = empty(8, 256);
    let material = diffuse(&mut scene, 0.0);
    let geometry = quad(&mut scene, square(5.0, -1.0));
    let ground = add(&mut scene, geometry, material);
    emit(&mut scene, ground, 1.0);
    let way = |from: f64| {
        let [start, end] = [-from, from].map(|x| Transform::translate(x, 0.0, 0.0).unwrap());
        Some(Box::new(AnimatedTransform::new(start, end, [0.0, 1.0]).unwrap()))
    };
    let (half, of_shape, placed, of_instance) = match carrier {
        Carrier::Shape => (0.5, way(1.5), None, None),
        Carrier::Instance => (0.5, None, Some(Transform::IDENTITY), way(1.5)),
        Carrier::Part => (0.25, way(0.75), Transform::scale(2.0, 2.0, 2.0), None),
        Carrier::Both => (0.5, way(0.5), Some(Transform::IDENTITY), way(1.0)),
    };
    let geometry = quad(&mut scene, square(half, 0.0));
    let shape = add(&mut scene, geometry, material);
    scene.shapes[shape].motion = of_shape;
    if let Some(object_to_world) = placed {
        scene.world.pop();
        let object = scene.objects.push(Object { shapes: vec![shape] }, Origin::default());
        let instance = Instance { motion: of_instance, ..Instance::new(object, object_to_world) };
        scene.instances.push(instance, Origin::default());
    }
    look_down(&mut scene, 5.0, 1.0);
    scene
}

#[test]
fn what_moves_covers_its_share_of_the_time() {
    for carrier in [Carrier::Shape, Carrier::Instance, Carrier::Part, Carrier::Both] {
        // Each point between −1 and 1 is behind the square for a third of the time, and half of the rows are.
        expect_mean(&crossing(carrier), 5.0 / 6.0, 0.01, &format!("{carrier:?}"));
    }
}

#[test]
fn a_lamp_that_moves_does_not_shine_and_says_so() {
    let mut scene = crossing(Carrier::Shape);
    let shape = scene.world[1];
    emit(&mut scene, shape, 1.0);
    let (built, diagnostics) = build(&scene, &BuildOptions::default());
    let codes: Vec<&str> = diagnostics.iter().map(|diagnostic| diagnostic.code).collect();
    assert!(built.is_some() && codes == ["moving-area-light"], "{codes:?}");
}

#[test]
fn given_tangents_turn_the_highlight_as_texture_coordinates_do() {
    let render_with = |tangents: Option<[Vec3; 4]>, turned: bool| {
        let mut scene = empty(6, 64);
        let roughness =
            Roughness { u: FloatParam::Constant(0.6), v: FloatParam::Constant(0.05), remap: false };
        let reflectance = ConductorReflectance::Normal(SpectrumParam::Constant(Spectrum::Constant(0.9)));
        let material =
            scene.materials.push(Material::Conductor { reflectance, roughness }, Origin::default());
        let uvs = square(1.0, 0.0).map(|[x, y, _]| if turned { Vec2::new(y, x) } else { Vec2::new(x, y) });
        let mesh = TriangleMesh {
            indices: [[0, 1, 3], [0, 3, 2]].into(),
            positions: square(1.0, 0.0).map(Vec3::from).into(),
            tangents: tangents.map(Into::into),
            uvs: Some(uvs.into()),
            ..TriangleMesh::default()
        };
        let mesh = scene.triangle_meshes.push(mesh, Origin::default());
        add(&mut scene, Geometry::Triangles(mesh), material);
        let lamp_material = diffuse(&mut scene, 0.0);
        let geometry =
            patch(&mut scene, [[-3.0, 3.0, 1.0], [3.0, 3.0, 1.0], [-3.0, 3.0, 2.0], [3.0, 3.0, 2.0]]);
        let lamp = add(&mut scene, geometry, lamp_material);
        emit(&mut scene, lamp, 5.0);
        look_down(&mut scene, 5.0, 0.9);
        values(&rendered(&scene).film.develop()).to_vec()
    };
    let (along_x, along_y) = (render_with(None, false), render_with(None, true));
    assert_ne!(along_x, along_y);
    assert_eq!(render_with(Some([Vec3::Y * 3.0; 4]), false), along_y);
    assert_eq!(render_with(Some([Vec3::ZERO; 4]), false), along_x, "none is given");
}
