//! Cameras.

use sahl_scene::{Aperture, Camera, LensSystem, Projection, SphereLayout};

use super::super::context::Context;
use super::super::reader::Reader;
use super::image::image;
use super::lens_file::lens_file;
use super::lookup;

/// Reads one kind of camera; `None`, reported, if it can't be.
type Read = fn(&mut Context<'_>, &Reader<'_>) -> Option<Camera>;

const CAMERAS: &[(&str, Read)] = &[
    ("perspective", perspective),
    ("orthographic", orthographic),
    ("spherical", spherical),
    ("realistic", realistic),
];

/// The camera called `name`, at the origin.
pub(in super::super) fn camera(cx: &mut Context<'_>, name: &str, p: &Reader<'_>) -> Option<Camera> {
    let mut camera = lookup(CAMERAS, name, p)?(cx, p)?;
    camera.shutter = shutter(p);
    Some(camera)
}

fn perspective(_: &mut Context<'_>, p: &Reader<'_>) -> Option<Camera> {
    let valid = |degrees: f32| degrees > 0.0 && degrees < 180.0;
    let fov = p.float_where("fov", 90.0, valid, "greater than 0 and less than 180 degrees").to_radians();
    Some(flat(p, Projection::Perspective { fov }))
}

fn orthographic(_: &mut Context<'_>, p: &Reader<'_>) -> Option<Camera> {
    Some(flat(p, Projection::Orthographic))
}

/// What cameras with a flat projection share.
fn flat(p: &Reader<'_>, projection: Projection) -> Camera {
    let given = p.float_array::<4>("screenwindow").filter(|[x0, x1, y0, y1]| {
        let valid = x0 < x1 && y0 < y1;
        if !valid {
            p.invalid(
                "screenwindow",
                "must be x min, x max, y min and y max, each minimum below its maximum",
            );
        }
        valid
    });
    let by_aspect = frame_aspect(p);
    Camera {
        projection,
        screen_window: given.or(by_aspect),
        lens_radius: p.non_negative("lensradius", 0.0),
        focal_distance: p.positive("focaldistance", 1e6),
        ..Camera::default()
    }
}

/// The screen window of another ratio of width to height than the film's: its shorter side spans −1 to 1.
fn frame_aspect(p: &Reader<'_>) -> Option<[f32; 4]> {
    p.has("frameaspectratio").then(|| {
        let aspect = p.positive("frameaspectratio", 1.0);
        let (x, y) = if aspect > 1.0 { (aspect, 1.0) } else { (1.0, 1.0 / aspect) };
        [-x, x, -y, y]
    })
}

fn spherical(_: &mut Context<'_>, p: &Reader<'_>) -> Option<Camera> {
    let layouts =
        [("equalarea", SphereLayout::EqualArea), ("equirectangular", SphereLayout::Equirectangular)];
    let layout = p.choice("mapping", &layouts, SphereLayout::EqualArea);
    // pbrt reads them for this camera too, and uses none.
    p.without_effect(&["lensradius", "focaldistance", "frameaspectratio", "screenwindow"]);
    Some(Camera { projection: Projection::Spherical(layout), ..Camera::default() })
}

/// Lengths are in millimetres, but for the focus distance.
fn realistic(cx: &mut Context<'_>, p: &Reader<'_>) -> Option<Camera> {
    let diameter = p.positive("aperturediameter", 1.0) / 1000.0;
    let focus_distance = p.positive("focusdistance", 10.0);
    let aperture = aperture(cx, p);
    let Some(name) = p.string("lensfile") else {
        if !p.has("lensfile") {
            let message = format!("{} needs a `string lensfile`", p.what());
            p.report().error("missing-parameter", p.span(), message);
        }
        return None;
    };
    let elements = lens_file(cx, name)?;
    let stops = elements.iter().filter(|element| element.curvature_radius == 0.0);
    let widest = stops.map(|stop| stop.diameter).reduce(f32::min);
    match widest {
        None if p.has("aperturediameter") || p.has("aperture") => {
            let message = format!("the lens `{}` has no aperture stop: its rims alone stop light", name.text);
            p.report().warning("no-aperture-stop", name.span, message);
        }
        Some(widest) if diameter > widest => {
            let message = format!(
                "an aperture of {} mm is wider than the stop of the lens: {} mm are used",
                diameter * 1000.0,
                widest * 1000.0
            );
            p.report().warning("aperture-range", p.span(), message);
        }
        _ => {}
    }
    let system = LensSystem { elements, aperture_diameter: diameter, aperture, focus_distance };
    Some(Camera { projection: Projection::Realistic(system), ..Camera::default() })
}

/// A shape by name, or else the image in a file.
fn aperture(cx: &mut Context<'_>, p: &Reader<'_>) -> Aperture {
    let Some(name) = p.string("aperture") else { return Aperture::Round };
    match &*name.text {
        "" => Aperture::Round,
        "gaussian" => Aperture::Gaussian,
        "square" => Aperture::Square,
        "pentagon" => Aperture::Pentagon,
        "star" => Aperture::Star,
        _ => image(cx, name, None).map_or(Aperture::Round, Aperture::Image),
    }
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
