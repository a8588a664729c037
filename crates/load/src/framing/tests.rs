use sahl_math::{Vec2, Vec3};
use sahl_scene::{Severity, TriangleMesh};

use super::*;

/// The triangles of a box, turned outwards or inwards, with the sides (−x +x −y +y −z +z) that are wanted.
fn box_mesh(bounds: Bounds3, outwards: bool, sides: [bool; 6]) -> TriangleMesh {
    let corners = bounds.corners();
    // Corner numbers have the bits z y x; each side is listed counter-clockwise from outside.
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let wanted = faces.into_iter().zip(sides).filter(|(_, wanted)| *wanted).map(|(face, _)| face);
    let triangles = wanted.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let turned = triangles.map(|[a, b, c]| if outwards { [a, b, c] } else { [a, c, b] });
    TriangleMesh { indices: turned.collect(), positions: corners.into(), ..TriangleMesh::default() }
}

fn scene_of(mesh: TriangleMesh) -> SceneDesc {
    let mut scene = SceneDesc::default();
    let material = scene.materials.push(Material::default(), Origin::default());
    let mesh = scene.triangle_meshes.push(mesh, Origin::default());
    let shape = Shape::new(Geometry::Triangles(mesh), Transform::IDENTITY, material);
    let shape = scene.shapes.push(shape, Origin::default());
    scene.world.push(shape);
    scene
}

fn framed(mesh: TriangleMesh) -> SceneDesc {
    let mut scene = scene_of(mesh);
    frame(&mut scene);
    let wrong: Vec<_> = scene.validate().into_iter().collect();
    assert!(wrong.is_empty(), "{wrong:?}");
    scene
}

fn room() -> Bounds3 {
    Bounds3 { min: Vec3::new(-12.0, -1.0, -7.0), max: Vec3::new(11.0, 8.0, 7.0) }
}

/// Where a point of the world is in the image: −1 to 1 along the shorter axis.
fn in_image(scene: &SceneDesc, p: Vec3) -> Vec2 {
    let Projection::Perspective { fov } = scene.camera.projection else { panic!("a perspective") };
    let p = scene.camera.camera_to_world.inverse().point(p);
    assert!(p.z > 0.0, "behind the camera");
    Vec2::new(p.x, p.y) / (p.z * (fov * 0.5).tan())
}

fn is_inside(scene: &SceneDesc, bounds: &Bounds3) -> bool {
    bounds.contains(scene.camera.camera_to_world.point(Vec3::ZERO))
}

#[test]
fn an_object_just_fills_the_image() {
    for size in [[1.0, 1.0, 1.0], [1e-3, 3e-3, 1e-3], [5e4, 1e3, 2e4], [0.1, 5.0, 0.1]] {
        let bounds = Bounds3 { min: Vec3::splat(-7.0), max: Vec3::splat(-7.0) + Vec3::from(size) };
        let scene = framed(box_mesh(bounds, true, [true; 6]));
        let places = bounds.corners().map(|corner| in_image(&scene, corner));
        let aspect = OBJECT_ASPECT;
        let reach = |along: fn(&Vec2) -> f32| places.iter().map(along).fold(f32::NEG_INFINITY, f32::max);
        let (left, right) = (-reach(|p| -p.x), reach(|p| p.x));
        let (below, above) = (-reach(|p| -p.y), reach(|p| p.y));
        assert!(left > -aspect && right < aspect && below > -1.0 && above < 1.0, "{places:?}");
        // It touches two opposite sides of the share that it may fill, and lies between the others.
        let fills = |low: f32, high: f32, most: f32| (low + most).abs() < 0.01 && (high - most).abs() < 0.01;
        assert!(fills(left, right, FILL * aspect) || fills(below, above, FILL), "{places:?}");
        assert!((left + right).abs() < 0.5 && (below + above).abs() < 0.5, "{places:?}");
        assert_eq!(scene.integrator, Integrator::default());
        assert!(
            scene
                .shapes
                .iter()
                .any(|(shape, _)| scene.shapes.origin(shape).name.as_deref() == Some("ground"))
        );
        assert!(scene.shapes.values().iter().any(|shape| shape.area_light.is_some()));
    }
}

#[test]
fn the_image_is_not_mirrored() {
    let scene = framed(box_mesh(Bounds3 { min: Vec3::ZERO, max: Vec3::ONE }, true, [true; 6]));
    // The viewer stands at +z: +x is on the right, +y is up.
    let middle = in_image(&scene, Vec3::splat(0.5));
    assert!(in_image(&scene, Vec3::new(1.0, 0.5, 0.5)).x > middle.x);
    assert!(in_image(&scene, Vec3::new(0.5, 1.0, 0.5)).y > middle.y);
}

#[test]
fn the_ground_lies_under_the_object_and_looks_up() {
    let scene = framed(box_mesh(Bounds3 { min: Vec3::ONE, max: Vec3::splat(3.0) }, true, [true; 6]));
    let ground =
        scene.shapes.values().iter().find(|shape| matches!(shape.geometry, Geometry::Disk { .. })).unwrap();
    let center = ground.shape_to_world.point(Vec3::ZERO);
    assert!((0.9..1.0).contains(&center.y), "{center:?}");
    assert!((ground.shape_to_world.normal(Vec3::Z) - Vec3::Y).length() < 1e-6);
}

#[test]
fn the_lamp_shines_at_the_object() {
    let scene = framed(box_mesh(Bounds3 { min: Vec3::ZERO, max: Vec3::ONE }, true, [true; 6]));
    let lamp = scene.shapes.values().iter().find(|shape| shape.area_light.is_some()).unwrap();
    let position = lamp.shape_to_world.point(Vec3::ZERO);
    let towards = (Vec3::splat(0.5) - position).normalize();
    assert!((lamp.shape_to_world.normal(Vec3::Z).normalize() - towards).length() < 1e-4);
    // None of it is in the image.
    let Geometry::Disk { radius, .. } = lamp.geometry else { panic!("a disk") };
    for step in 0..64 {
        let (sin, cos) = (step as f32 / 64.0 * std::f32::consts::TAU).sin_cos();
        let rim = lamp.shape_to_world.point(Vec3::new(radius * cos, radius * sin, 0.0));
        let seen = scene.camera.camera_to_world.inverse().point(rim);
        assert!(seen.z < 0.0 || in_image(&scene, rim).x < -1280.0 / 720.0, "{seen:?}");
    }
}

#[test]
fn a_room_is_seen_from_inside() {
    let open = framed(box_mesh(room(), false, [true, true, true, false, true, true]));
    let closed = framed(box_mesh(room(), false, [true; 6]));
    for scene in [&open, &closed] {
        assert!(is_inside(scene, &room()));
        let forward = scene.camera.camera_to_world.vector(Vec3::Z);
        assert!(forward.x.abs() > 0.95, "{forward:?}");
        assert!(!scene.shapes.values().iter().any(|shape| matches!(shape.geometry, Geometry::Disk { .. })));
    }
    let suns = |scene: &SceneDesc| {
        scene.lights.values().iter().filter(|light| matches!(light, Light::Distant { .. })).count()
    };
    assert_eq!((suns(&open), suns(&closed)), (1, 0));
}

#[test]
fn a_corner_of_two_walls_is_an_object() {
    let walls = box_mesh(room(), false, [false, false, true, false, true, false]);
    assert!(!is_inside(&framed(walls), &room()));
}

#[test]
fn a_closed_object_is_seen_from_outside() {
    assert!(!is_inside(&framed(box_mesh(room(), true, [true; 6])), &room()));
}

#[test]
fn normals_decide_which_side_is_the_front() {
    let mesh = box_mesh(room(), true, [true; 6]);
    let inwards = mesh.positions.iter().map(|&corner| room().center() - corner).collect();
    let scene = framed(TriangleMesh { normals: Some(inwards), ..mesh });
    assert!(is_inside(&scene, &room()));
}

#[test]
fn a_flat_mesh_is_an_object_without_ground() {
    let floor = box_mesh(room(), true, [false, false, false, true, false, false]);
    let scene = framed(floor);
    assert!(scene.camera.camera_to_world.point(Vec3::ZERO).y > 8.5);
    assert!(
        !scene.shapes.iter().any(|(shape, _)| scene.shapes.origin(shape).name.as_deref() == Some("ground"))
    );
}

#[test]
fn extreme_meshes_do_no_harm() {
    let largest = Bounds3 { min: Vec3::splat(-f32::MAX), max: Vec3::splat(f32::MAX) };
    let point = Bounds3 { min: Vec3::ONE, max: Vec3::ONE };
    let far = Bounds3 { min: Vec3::splat(1e30), max: Vec3::splat(1.1e30) };
    let tiny = Bounds3 { min: Vec3::ZERO, max: Vec3::splat(1e-42) };
    for bounds in [largest, point, far, tiny, Bounds3 { min: Vec3::ZERO, max: Vec3::X }] {
        let mut scene = scene_of(box_mesh(bounds, true, [true; 6]));
        frame(&mut scene);
        let wrong = scene.validate().into_iter().find(|diagnostic| diagnostic.severity == Severity::Error);
        assert_eq!(wrong, None);
    }
    frame(&mut SceneDesc::default());
}
