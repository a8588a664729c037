//! Lights that are not shapes.

use std::sync::Arc;

use sahl_image::Image;
use sahl_math::{Transform, Vec3};
use sahl_scene::{Handle, Light, Origin, Radiance, Spectrum};

use super::super::context::Context;
use super::super::parameter::Kind;
use super::super::reader::Reader;
use super::image::image;
use super::lookup;
use super::sky::illuminance_factor;
use super::spectrum::{Role, spectrum};

/// Where a light stands, and what it emits unless told.
pub(in super::super) struct LightFrame {
    /// The transform in force.
    pub(in super::super) to_world: Transform,
    /// White of the colour space in force.
    pub(in super::super) white: Spectrum,
}

/// Reads one kind of light.
type Read = fn(&mut Context<'_>, &Reader<'_>, &LightFrame) -> Option<Light>;

const LIGHTS: &[(&str, Read)] = &[
    ("point", point),
    ("spot", spot),
    ("distant", distant),
    ("infinite", infinite),
    ("goniometric", goniometric),
    ("projection", projection),
];

/// Adds the light called `name`.
pub(in super::super) fn light(cx: &mut Context<'_>, name: &str, p: &Reader<'_>, frame: &LightFrame) {
    let Some(read) = lookup(LIGHTS, name, p) else { return };
    if let Some(light) = read(cx, p, frame) {
        cx.scene.lights.push(light, Origin::at(p.span()));
    }
}

fn emission(cx: &Context<'_>, p: &Reader<'_>, name: &'static str, frame: &LightFrame) -> Spectrum {
    spectrum(cx, p, name, Role::Illuminant).unwrap_or_else(|| frame.white.clone())
}

fn scale(p: &Reader<'_>) -> f32 {
    p.non_negative("scale", 1.0)
}

/// A photometric quantity; pbrt ignores one that is not positive.
pub(super) fn photometric(p: &Reader<'_>, name: &'static str) -> Option<f32> {
    let value = p.optional_float(name)?;
    if value < 0.0 {
        let message = format!("`{name}` is {value}: expected at least 0; it is left out");
        p.report().warning("invalid-value", p.span(), message);
    }
    (value > 0.0).then_some(value)
}

fn point(cx: &mut Context<'_>, p: &Reader<'_>, frame: &LightFrame) -> Option<Light> {
    Some(Light::Point {
        intensity: emission(cx, p, "I", frame),
        scale: scale(p),
        power: photometric(p, "power"),
        position: frame.to_world.point(p.point("from", Vec3::ZERO)),
    })
}

/// pbrt's table has its axis along y, the description's along z.
fn goniometric(cx: &mut Context<'_>, p: &Reader<'_>, frame: &LightFrame) -> Option<Light> {
    let (intensity, scale, power) = (emission(cx, p, "I", frame), scale(p), photometric(p, "power"));
    let swap = Transform::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0]])?;
    let Some(name) = p.string("filename") else {
        let message = format!("{} has no `filename`: it shines alike in all directions", p.what());
        p.report().warning("missing-parameter", p.span(), message);
        let position = frame.to_world.point(Vec3::ZERO);
        return Some(Light::Point { intensity, scale, power, position });
    };
    let image = image(cx, name, None)?;
    let (width, height) = size(cx, image);
    if width != height {
        let message =
            format!("a goniometric light needs a square equal-area image, found {width} × {height} pixels");
        p.report().error("environment-layout", name.span, message);
        return None;
    }
    let light_to_world = frame.to_world.after(&swap)?;
    Some(Light::Goniometric { intensity, scale, power, image, light_to_world })
}

fn size(cx: &Context<'_>, image: Handle<Arc<Image>>) -> (usize, usize) {
    let image = &cx.scene.images[image];
    (image.width, image.height)
}

/// The unit vector from `from` to `to` in the world.
fn axis(p: &Reader<'_>, frame: &LightFrame) -> Option<Vec3> {
    let (from, to) = (p.point("from", Vec3::ZERO), p.point("to", Vec3::Z));
    let direction = frame.to_world.vector(to - from).try_normalize();
    if direction.is_none() {
        p.report().error(
            "invalid-value",
            p.span(),
            format!("{}: `from` and `to` are the same point", p.what()),
        );
    }
    direction
}

fn spot(cx: &mut Context<'_>, p: &Reader<'_>, frame: &LightFrame) -> Option<Light> {
    let valid = |degrees: f32| degrees > 0.0 && degrees <= 180.0;
    let angle = p.float_where("coneangle", 30.0, valid, "greater than 0 and at most 180 degrees");
    let penumbra = p.non_negative("conedeltaangle", 5.0).min(angle);
    Some(Light::Spot {
        intensity: emission(cx, p, "I", frame),
        scale: scale(p),
        power: photometric(p, "power"),
        position: frame.to_world.point(p.point("from", Vec3::ZERO)),
        direction: axis(p, frame)?,
        angle: angle.to_radians(),
        penumbra: penumbra.to_radians(),
    })
}

fn projection(cx: &mut Context<'_>, p: &Reader<'_>, frame: &LightFrame) -> Option<Light> {
    let valid = |degrees: f32| degrees > 0.0 && degrees < 180.0;
    let fov = p.float_where("fov", 90.0, valid, "greater than 0 and less than 180 degrees");
    let (scale, power) = (scale(p), photometric(p, "power"));
    let Some(name) = p.string("filename") else {
        if !p.has("filename") {
            let message = format!("{} needs a `string filename`", p.what());
            p.report().error("missing-parameter", p.span(), message);
        }
        return None;
    };
    let image = image(cx, name, None)?;
    Some(Light::Projection { image, scale, power, fov: fov.to_radians(), light_to_world: frame.to_world })
}

fn distant(cx: &mut Context<'_>, p: &Reader<'_>, frame: &LightFrame) -> Option<Light> {
    Some(Light::Distant {
        radiance: emission(cx, p, "L", frame),
        scale: scale(p),
        illuminance: photometric(p, "illuminance"),
        direction: axis(p, frame)?,
    })
}

fn infinite(cx: &mut Context<'_>, p: &Reader<'_>, frame: &LightFrame) -> Option<Light> {
    let portal = portal(p);
    let (scale, illuminance) = (scale(p), photometric(p, "illuminance"));
    let constant = spectrum(cx, p, "L", Role::Illuminant);
    let radiance = match p.string("filename") {
        Some(_) if constant.is_some() => {
            p.report().error("contradiction", p.span(), format!("{} has both `L` and `filename`", p.what()));
            return None;
        }
        Some(_) => environment(cx, p)?,
        None => Radiance::Constant(constant.unwrap_or_else(|| frame.white.clone())),
    };
    let (scale, illuminance) = match (&radiance, illuminance, p.string("filename")) {
        (Radiance::EqualArea(handle), Some(illuminance), Some(name)) => {
            (scale * illuminance_factor(&cx.scene.images[*handle], &name.text, illuminance), None)
        }
        _ => (scale, illuminance),
    };
    Some(Light::Infinite { radiance, scale, illuminance, light_to_world: frame.to_world, portal })
}

/// The corners of a portal, which pbrt takes to be in the world whatever the transform in force.
fn portal(p: &Reader<'_>) -> Option<[Vec3; 4]> {
    let corners = p.vectors("portal", Kind::Point3)?;
    let found = corners.len();
    let portal = corners.try_into().ok();
    if portal.is_none() {
        let message = format!("a portal has 4 corners, found {found}: it is left out");
        p.report().error("wrong-count", p.span(), message);
    }
    portal
}

/// The image of an infinite light: square and equal-area as pbrt has it, or latitude-longitude as others do.
fn environment(cx: &mut Context<'_>, p: &Reader<'_>) -> Option<Radiance> {
    let name = p.string("filename")?;
    let handle = image(cx, name, None)?;
    let (width, height) = size(cx, handle);
    if width == height {
        return Some(Radiance::EqualArea(handle));
    }
    if width == 2 * height {
        let message =
            format!("`{}` is twice as wide as high: it is read as a latitude-longitude map", name.text);
        p.report().warning("environment-layout", name.span, message);
        return Some(Radiance::LatLong(handle));
    }
    let message =
        format!("an infinite light needs a square equal-area image, found {width} × {height} pixels");
    p.report().error("environment-layout", name.span, message);
    None
}
