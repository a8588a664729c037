//! Cameras in space; what single kinds do is tested beside them.

use sahl_scene::SphereLayout;

use super::*;
use crate::warp;

const CENTER: Vec2 = Vec2::splat(0.5);

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

fn built(camera: sahl_scene::Camera, resolution: [u32; 2]) -> Camera {
    let mut scene = SceneDesc { camera, ..SceneDesc::default() };
    scene.film.resolution = resolution;
    let mut diagnostics = Diagnostics::default();
    let camera = Camera::new(&scene, &mut diagnostics);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    camera.unwrap()
}

fn ray(camera: &Camera, film: Vec2, lens: Vec2) -> Ray {
    let CameraRay { ray, weight } = camera.ray(film, lens, 0.0);
    assert_eq!(weight, 1.0);
    assert!((ray.direction.length() - 1.0).abs() < 1e-6);
    ray
}

#[test]
fn the_field_of_view_spans_the_shorter_axis() {
    for (resolution, top, right) in [([200, 100], 1.0, 2.0), ([100, 200], 2.0, 1.0)] {
        let camera = built(sahl_scene::Camera::default(), resolution);
        let ray = ray(&camera, Vec2::new(resolution[0] as f32, 0.0), CENTER);
        assert!(close(ray.direction / ray.direction.z, Vec3::new(right, top, 1.0)), "{ray:?}");
    }
}

#[test]
fn a_screen_window_replaces_the_rule() {
    let description =
        sahl_scene::Camera { screen_window: Some([-0.5, 1.0, 0.25, 0.75]), ..Default::default() };
    let camera = built(description, [30, 10]);
    let at = |x, y| ray(&camera, Vec2::new(x, y), CENTER).direction;
    assert!(close(at(0.0, 0.0) / at(0.0, 0.0).z, Vec3::new(-0.5, 0.75, 1.0)));
    assert!(close(at(30.0, 10.0) / at(30.0, 10.0).z, Vec3::new(1.0, 0.25, 1.0)));
}

#[test]
fn rays_through_the_lens_meet_in_the_plane_of_focus() {
    let perspective = Projection::Perspective { fov: 1.0 };
    for projection in [perspective, Projection::Orthographic] {
        let description = sahl_scene::Camera {
            projection,
            lens_radius: 0.3,
            focal_distance: 4.0,
            camera_to_world: Transform::translate(1.0, 2.0, 3.0).unwrap(),
            ..Default::default()
        };
        let camera = built(description, [64, 64]);
        let film = Vec2::new(12.0, 50.0);
        let meet = |lens| {
            let ray = ray(&camera, film, lens);
            assert!((camera.depth(ray.origin, 0.0)).abs() < 1e-6);
            ray.at(4.0 / ray.direction.z)
        };
        let focus = meet(CENTER);
        for lens in [Vec2::ZERO, Vec2::new(0.9, 0.2), Vec2::new(0.1, 0.7)] {
            assert!(close(meet(lens), focus));
        }
        assert!((camera.depth(focus, 0.0) - 4.0).abs() < 1e-5);
    }
}

#[test]
fn an_orthographic_camera_with_a_lens_stays_parallel_on_average() {
    let description = sahl_scene::Camera {
        projection: Projection::Orthographic,
        lens_radius: 0.1,
        focal_distance: 2.0,
        ..Default::default()
    };
    let camera = built(description, [10, 10]);
    let ray = ray(&camera, Vec2::new(0.0, 10.0), CENTER);
    assert!(close(ray.origin, Vec3::new(-1.0, -1.0, 0.0)) && close(ray.direction, Vec3::Z));
}

#[test]
fn points_of_a_thin_lens_are_uniform() {
    let description = sahl_scene::Camera { lens_radius: 0.5, focal_distance: 3.0, ..Default::default() };
    let camera = built(description, [32, 32]);
    let test = sahl_testkit::chi2::SquareTest::default();
    // Back to the square, in which points of the disk are uniform.
    let on_lens = |u: [f32; 2]| {
        let p = camera.ray(Vec2::new(3.0, 30.0), u.into(), 0.0).ray.origin;
        Some(warp::concentric_disk_inverse(Vec2::new(p.x, p.y) * 2.0))
    };
    test.run(on_lens, |_| 1.0).unwrap();
}

#[test]
fn the_equal_area_film_sees_all_directions_alike() {
    let projection = Projection::Spherical(SphereLayout::EqualArea);
    let camera = built(sahl_scene::Camera { projection, ..Default::default() }, [64, 64]);
    let test = sahl_testkit::chi2::SphereTest::default();
    let direction = |u: [f32; 3]| Some(camera.ray(Vec2::new(u[0], u[1]) * 64.0, CENTER, 0.0).ray.direction);
    test.run(direction, |_| warp::UNIFORM_SPHERE_PDF).unwrap();
}

/// Where the plane z = 5 in camera space is hit from pixel to pixel, against the estimate in the middle of the image, where the
/// pixels of a sphere are larger than the smallest.
#[test]
fn footprints_are_those_of_pixels() {
    let moved = Transform::translate(0.3, -2.0, 1.0)
        .unwrap()
        .after(&Transform::rotate(0.7, [0.2, 1.0, 0.1]).unwrap())
        .unwrap();
    for (projection, slack) in [
        (Projection::Perspective { fov: 0.05 }, 1e-3),
        (Projection::Perspective { fov: 1.2 }, 1e-3),
        (Projection::Orthographic, 1e-3),
        (Projection::Spherical(SphereLayout::Equirectangular), 1.0),
    ] {
        let is_sphere = matches!(projection, Projection::Spherical(_));
        let description = sahl_scene::Camera { projection, camera_to_world: moved, ..Default::default() };
        let camera = built(description, [200, 100]);
        // A spherical camera looks along +z a quarter of the way.
        let film = if is_sphere { Vec2::new(50.0, 50.0) } else { Vec2::new(100.0, 50.0) };
        let n = moved.normal(Vec3::new(0.3, 0.1, -1.0)).normalize();
        let on_plane = |film| {
            let ray = ray(&camera, film, CENTER);
            let center = moved.point(Vec3::new(0.0, 0.0, 5.0));
            ray.at((center - ray.origin).dot(n) / ray.direction.dot(n))
        };
        let p = on_plane(film);
        let found = camera.footprint(p, n, 0.0);
        for (found, step) in [(found.dp_dx, Vec2::new(1.0, 0.0)), (found.dp_dy, Vec2::new(0.0, 1.0))] {
            let exact = on_plane(film + step) - p;
            let ratio = found.length() / exact.length();
            assert!(ratio > 0.999 - slack && ratio < 1.03, "{:?} {ratio}", camera.kind);
            assert!(found.dot(n).abs() < 1e-3 * found.length());
            if !is_sphere {
                // In the corners of a wide image, where pixels are smallest, they are askew.
                assert!(found.dot(exact) > 0.9 * found.length() * exact.length(), "{found:?} {exact:?}");
            }
        }
    }
}

#[test]
fn an_edge_on_plane_has_no_footprint() {
    let camera = built(sahl_scene::Camera::default(), [64, 64]);
    let footprint = camera.footprint(Vec3::new(0.0, 0.0, 3.0), Vec3::X, 0.0);
    assert!(footprint.dp_dx.is_finite() && footprint.dp_dy.is_finite());
    assert_eq!(camera.footprint(Vec3::ZERO, Vec3::Z, 0.0), Footprint::default());
}

#[test]
fn a_lens_without_an_image_is_an_error() {
    let mut system = lens::tests::simple(0.01, 0.05);
    system.aperture = sahl_scene::Aperture::Round;
    let camera = sahl_scene::Camera { projection: Projection::Realistic(system), ..Default::default() };
    let scene = SceneDesc { camera, ..SceneDesc::default() };
    let mut diagnostics = Diagnostics::default();
    assert!(Camera::new(&scene, &mut diagnostics).is_none());
    assert!(diagnostics.iter().any(|entry| entry.code == "bad-lens"));
}

#[test]
fn a_camera_that_moves_is_where_its_motion_is() {
    let [start, end] = [0.0, 4.0].map(|x| Transform::translate(x, 0.0, 0.0).unwrap());
    let description = sahl_scene::Camera {
        camera_to_world: start,
        motion: AnimatedTransform::new(start, end, [0.0, 1.0]).map(Box::new),
        ..Default::default()
    };
    let camera = built(description, [8, 8]);
    assert!(camera.moves());
    let at = |time| camera.ray(Vec2::splat(4.0), CENTER, time).ray;
    assert!(close(at(0.0).origin, Vec3::ZERO) && close(at(0.5).origin, Vec3::X * 2.0));
    assert_eq!(at(0.25).time, 0.25);
    // What is seen of a place is measured from where the camera is then.
    let (p, place) = (Vec3::new(1.0, 0.0, 5.0), Vec3::new(-1.0, 0.0, 5.0));
    let still = |x: f32| {
        let camera_to_world = Transform::translate(f64::from(x), 0.0, 0.0).unwrap();
        built(sahl_scene::Camera { camera_to_world, ..Default::default() }, [8, 8])
    };
    // On a slanted plane: on one across the view the footprint is the same everywhere.
    let n = Vec3::new(0.6, 0.0, 0.8);
    assert_eq!(camera.footprint(p, n, 0.5), still(2.0).footprint(p, n, 0.0));
    assert_ne!(camera.footprint(p, n, 0.5), camera.footprint(p, n, 0.0));
    assert_eq!(camera.depth(place, 0.5), 5.0);
}
