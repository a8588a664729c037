//! Cameras: what each of pbrt-v4's becomes.

use sahl_load::{Loaded, MemoryAssets, load_pbrt};
use sahl_math::Vec3;
use sahl_scene::{Aperture, Camera, Projection, SphereLayout};

const LENS: &str = "# radius thickness index diameter\n50 4 1.5 24\n-50 2 1 24 # air\n0 3 0 20";

fn loaded(text: &str) -> Loaded {
    let mut assets = MemoryAssets::default();
    assets.insert("lens.dat", LENS.as_bytes());
    assets.insert("white.pfm", *b"Pf\n1 1\n-1.0\n\0\0\x80?");
    load_pbrt("test.pbrt", format!("{text} WorldBegin").into_bytes(), &assets)
}

/// The camera of a scene that gives no message.
fn camera(text: &str) -> Camera {
    let loaded = loaded(text);
    let messages = loaded.diagnostics.render_text(&loaded.sources, false);
    assert!(loaded.diagnostics.is_empty(), "{text}\n{messages}");
    loaded.scene.camera
}

#[test]
fn spheres_have_two_layouts() {
    let layout = |text: &str| camera(text).projection;
    assert_eq!(layout("Camera \"spherical\""), Projection::Spherical(SphereLayout::EqualArea));
    assert_eq!(
        layout("Camera \"spherical\" \"string mapping\" \"equirectangular\" \"float lensradius\" 0"),
        Projection::Spherical(SphereLayout::Equirectangular)
    );
}

#[test]
fn lenses_are_read_from_files_in_millimetres() {
    let text = "Film \"rgb\" \"float diagonal\" 43 Camera \"realistic\" \"string lensfile\" \"lens.dat\"
        \"float aperturediameter\" 12 \"float focusdistance\" 6.5 \"string aperture\" \"star\"";
    let found = loaded(text);
    assert!((found.scene.film.diagonal - 0.043).abs() < 1e-7);
    let Projection::Realistic(lens) = camera(text).projection else { panic!("no lens") };
    let close = |a: f32, b: f32| (a - b).abs() < 1e-7;
    assert!(close(lens.aperture_diameter, 0.012) && lens.focus_distance == 6.5);
    assert_eq!(lens.aperture, Aperture::Star);
    let [front, back, stop] = &lens.elements[..] else { panic!("{:?}", lens.elements) };
    assert!(
        close(front.curvature_radius, 0.05) && close(front.thickness, 0.004) && close(front.diameter, 0.024)
    );
    assert_eq!((front.eta, back.eta), (1.5, 1.0));
    assert!(close(back.curvature_radius, -0.05) && stop.curvature_radius == 0.0);
    let image =
        camera("Camera \"realistic\" \"string lensfile\" \"lens.dat\" \"string aperture\" \"white.pfm\"");
    let Projection::Realistic(lens) = image.projection else { panic!("no lens") };
    assert!(matches!(lens.aperture, Aperture::Image(_)));
}

#[test]
fn a_stop_has_its_largest_diameter() {
    let found = loaded("Camera \"realistic\" \"string lensfile\" \"lens.dat\" \"float aperturediameter\" 30");
    let messages: Vec<&str> = found.diagnostics.iter().map(|entry| entry.message.as_str()).collect();
    assert!(!found.diagnostics.has_errors() && messages.len() == 1, "{messages:?}");
    assert!(messages[0].contains("wider than the stop"), "{messages:?}");
}

#[test]
fn the_frame_may_have_another_shape_than_the_film() {
    let window = |text: &str| camera(text).screen_window;
    assert_eq!(window("Camera \"perspective\""), None);
    assert_eq!(window("Camera \"perspective\" \"float frameaspectratio\" 2"), Some([-2.0, 2.0, -1.0, 1.0]));
    assert_eq!(
        window("Camera \"orthographic\" \"float frameaspectratio\" 0.5"),
        Some([-1.0, 1.0, -2.0, 2.0])
    );
    let both = "Camera \"perspective\" \"float frameaspectratio\" 2 \"float screenwindow\" [ 0 1 0 1 ]";
    assert_eq!(window(both), Some([0.0, 1.0, 0.0, 1.0]));
}

#[test]
fn cameras_move_while_the_shutter_is_open() {
    let moving = "ActiveTransform EndTime Translate -4 0 0 ActiveTransform All";
    let still = camera("Translate -4 0 0 Camera \"perspective\"");
    assert_eq!(still.motion, None);
    let x = |text: &str, time: f32| {
        let camera = camera(text);
        camera.motion.map(|motion| motion.at(time).point(Vec3::ZERO).x)
    };
    // The camera goes four metres to the right in the first second.
    let open = format!("{moving} Camera \"perspective\"");
    assert_eq!([0.0, 0.5, 1.0].map(|time| x(&open, time)), [Some(0.0), Some(2.0), Some(4.0)]);
    // A shutter of half a second sees half of it, and one of two seconds the rest of the time a camera that stands.
    let half = format!("{moving} Camera \"perspective\" \"float shutterclose\" 0.5");
    assert_eq!(x(&half, 1.0), Some(2.0));
    let long = format!("{moving} Camera \"perspective\" \"float shutterclose\" 2");
    assert_eq!([0.25, 0.75].map(|time| x(&long, time)), [Some(2.0), Some(4.0)]);
    let slow = format!("TransformTimes 0 2 {moving} Camera \"perspective\"");
    assert_eq!(x(&slow, 1.0), Some(2.0));
    // A shutter that is open for a moment sees that moment.
    let moment =
        format!("{moving} Camera \"perspective\" \"float shutteropen\" 0.25 \"float shutterclose\" 0.25");
    // It shows nothing, which is reported.
    let found = loaded(&moment).scene.camera;
    assert!(found.motion.is_none() && (found.camera_to_world.point(Vec3::ZERO).x - 1.0).abs() < 1e-6);
}

#[test]
fn motion_through_a_mirror_is_refused() {
    let found = loaded("ActiveTransform EndTime Scale -1 1 1 Camera \"perspective\"");
    let messages: Vec<&str> = found.diagnostics.iter().map(|entry| entry.message.as_str()).collect();
    assert!(messages.len() == 1 && messages[0].contains("singular"), "{messages:?}");
    assert_eq!(found.scene.camera.motion, None);
}
