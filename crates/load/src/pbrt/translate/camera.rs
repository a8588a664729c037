//! Cameras.

use sahl_math::Transform;
use sahl_scene::{Camera, Projection};

use super::super::reader::Reader;
use super::lookup;

/// Reads one kind of camera.
type Read = fn(&Reader<'_>) -> Camera;

const CAMERAS: &[(&str, Read)] = &[
    ("perspective", perspective),
    ("orthographic", orthographic),
    ("spherical", spherical),
    ("realistic", realistic),
];

/// The camera called `name`, which stands where `world_to_camera` puts it.
pub(in super::super) fn camera(name: &str, p: &Reader<'_>, world_to_camera: &Transform) -> Option<Camera> {
    let mut camera = lookup(CAMERAS, name, p)?(p);
    camera.camera_to_world = world_to_camera.inverse();
    camera.shutter = shutter(p);
    p.unsupported(&["frameaspectratio"], "the film's aspect ratio is used");
    Some(camera)
}

fn perspective(p: &Reader<'_>) -> Camera {
    let valid = |degrees: f32| degrees > 0.0 && degrees < 180.0;
    let fov = p.float_where("fov", 90.0, valid, "greater than 0 and less than 180 degrees").to_radians();
    lens(p, Projection::Perspective { fov })
}

fn orthographic(p: &Reader<'_>) -> Camera {
    lens(p, Projection::Orthographic)
}

/// What cameras with a flat film share.
fn lens(p: &Reader<'_>, projection: Projection) -> Camera {
    let screen_window = p.float_array::<4>("screenwindow").filter(|[x0, x1, y0, y1]| {
        let valid = x0 < x1 && y0 < y1;
        if !valid {
            p.invalid(
                "screenwindow",
                "must be x min, x max, y min and y max, each minimum below its maximum",
            );
        }
        valid
    });
    Camera {
        projection,
        screen_window,
        lens_radius: p.non_negative("lensradius", 0.0),
        focal_distance: p.positive("focaldistance", 1e6),
        ..Camera::default()
    }
}

fn spherical(p: &Reader<'_>) -> Camera {
    p.choice("mapping", &[("equalarea", ()), ("equirectangular", ())], ());
    p.unsupported_plugin("unsupported-camera", "a perspective camera with a right angle of view is used");
    Camera::default()
}

/// A pinhole with the angle of view that a lens of 50 mm has on the default film of 35 mm diagonal at 16:9.
fn realistic(p: &Reader<'_>) -> Camera {
    const ANGLE_OF_VIEW: f32 = 19.5;
    p.without_effect(&["lensfile", "aperturediameter", "focusdistance", "aperture"]);
    let instead = format!("a pinhole camera with an angle of view of {ANGLE_OF_VIEW} degrees is used");
    p.unsupported_plugin("unsupported-camera", &instead);
    Camera { projection: Projection::Perspective { fov: ANGLE_OF_VIEW.to_radians() }, ..Camera::default() }
}

/// When the shutter opens and closes; in that order even if the file has them the other way round, as in pbrt.
fn shutter(p: &Reader<'_>) -> [f32; 2] {
    let (open, close) = (p.float("shutteropen", 0.0), p.float("shutterclose", 1.0));
    if close < open {
        let message = format!("the shutter closes ({close}) before it opens ({open}): the times are swapped");
        p.report().warning("shutter-order", p.span(), message);
    }
    [open.min(close), open.max(close)]
}
