//! A camera and light for files that have neither: bare meshes.
//!
//! A mesh is taken to be either an object, which is looked at from outside, or a place, which is looked at from inside.
//! It is a place if, from the centre of its bounding box, surfaces lie in at least two thirds of all directions and at
//! least three quarters of those nearest surfaces show their front: inside a closed object one sees back faces only, in a room
//! the fronts of its walls. The top may be open, as over the court of Sponza.
//!
//! An object is shown from the front, half right and slightly from above (y up, z to the viewer), just filling the image,
//! on a large grey disk, under a soft sky and a round lamp that stands to the left above the camera.
//!
//! In a place the camera stands near one end of the longer horizontal axis, at about a quarter of the height, and looks
//! along it. Of a few such points the one with the longest view is taken. Light comes from a sky and a high sun, if the
//! top is open, and from a point light under the ceiling, which stands for the lamps that the file does not have.
//!
//! A mesh that has emitters of its own gets no other light than a faint sky.
//!
//! Deliberately absent: any acceleration structure. Each question about what is seen from a point takes one pass over the
//! triangles, of which a sample is taken where there are many.

mod surroundings;

use std::f32::consts::FRAC_PI_2;

use sahl_math::{Bounds3, Transform, Vec3};
use sahl_scene::{
    AreaLight, Camera, Geometry, Integrator, Light, LightSampler, Material, Origin, PathTracer, Projection,
    Radiance, SceneDesc, Shape, Spectrum, SpectrumParam,
};

use surroundings::{Soup, Surroundings};

/// Samples a pixel: enough for a soft shadow to look smooth.
const SAMPLES: u32 = 32;
/// Angle of view along the shorter axis for an object, in radians (40°).
const OBJECT_FOV: f32 = 0.698;
/// Angle of view along the shorter axis in a place, in radians (58°).
const PLACE_FOV: f32 = 1.012;
/// Share of the image that an object fills along the tighter axis.
const FILL: f32 = 0.88;
/// Width over height of the frame that an object has to fit: it stays whole in narrower images than the default one.
const OBJECT_ASPECT: f32 = 4.0 / 3.0;
/// From the centre of an object towards the camera.
const OBJECT_VIEW: Vec3 = Vec3::new(0.5, 0.42, 1.0);
/// From the centre of an object towards the lamp.
const OBJECT_LAMP: Vec3 = Vec3::new(-0.75, 1.0, 0.75);

/// Gives a scene of bare meshes a camera, lights and, under an object, a ground.
///
/// The shapes must be meshes that stand in the world without a transform. A scene without extent stays as it is.
pub(crate) fn frame(scene: &mut SceneDesc) {
    let bounds = bounds(scene);
    let Some((center, radius)) = bounds
        .bounding_sphere()
        .filter(|(center, radius)| *radius > 0.0 && radius.is_finite() && center.is_finite())
    else {
        return;
    };
    scene.sampler.samples = SAMPLES;
    let has_emitters = scene.shapes.values().iter().any(|shape| shape.area_light.is_some());
    if has_emitters {
        add_sky(scene, [0.05; 3]);
    }
    let soup = Soup::new(scene, radius);
    let surroundings = Surroundings::new(&soup, center);
    if surroundings.is_enclosed(radius * 0.02) {
        frame_place(scene, &bounds, &soup, &surroundings);
        let mut light_sampler = LightSampler::default();
        if !has_emitters {
            light_place(scene, &bounds, &surroundings);
            // By power the sky outside would get nearly every sample, and the lamp inside none.
            light_sampler = LightSampler::Uniform;
        }
        // Light comes round more corners than between objects.
        scene.integrator =
            Integrator::Path(PathTracer { max_depth: 8, light_sampler, ..PathTracer::default() });
    } else {
        frame_object(scene, &bounds, center, radius);
        if !has_emitters {
            light_object(scene, center, radius);
        }
    }
}

/// Calls `visit` with the corners of each triangle, a patch counting as two, and with what gives the sum of their normals
/// if the mesh has normals.
fn for_each_triangle(scene: &SceneDesc, mut visit: impl FnMut([Vec3; 3], &dyn Fn() -> Option<Vec3>)) {
    for shape in scene.shapes.values() {
        match shape.geometry {
            Geometry::Triangles(mesh) | Geometry::Displaced { mesh, .. } => {
                let mesh = &scene.triangle_meshes[mesh];
                for &triangle in mesh.indices.iter() {
                    visit_triangle(triangle, &mesh.positions, mesh.normals.as_deref(), &mut visit);
                }
            }
            Geometry::Patches(mesh) => {
                let mesh = &scene.patch_meshes[mesh];
                for &[a, b, c, d] in mesh.indices.iter() {
                    for triangle in [[a, b, d], [a, d, c]] {
                        visit_triangle(triangle, &mesh.positions, mesh.normals.as_deref(), &mut visit);
                    }
                }
            }
            Geometry::Sphere { .. }
            | Geometry::Disk { .. }
            | Geometry::Cylinder { .. }
            | Geometry::Curves(_) => {}
        }
    }
}

fn visit_triangle(
    triangle: [u32; 3],
    positions: &[Vec3],
    normals: Option<&[Vec3]>,
    visit: &mut impl FnMut([Vec3; 3], &dyn Fn() -> Option<Vec3>),
) {
    let corners = triangle.map(|index| positions[index as usize]);
    let sum =
        |normals: &[Vec3]| triangle.iter().fold(Vec3::ZERO, |sum, &index| sum + normals[index as usize]);
    visit(corners, &|| normals.map(sum));
}

fn bounds(scene: &SceneDesc) -> Bounds3 {
    let mut bounds = Bounds3::EMPTY;
    for_each_triangle(scene, |corners, _| bounds = corners.into_iter().fold(bounds, Bounds3::including));
    bounds
}

/// A camera at `eye` that looks along `forward`, y up, in a right-handed world, and the directions right and up in its
/// image.
fn camera_at(eye: Vec3, forward: Vec3, fov: f32) -> Option<Camera> {
    let wide = |v: Vec3| [f64::from(v.x), f64::from(v.y), f64::from(v.z)];
    let camera_to_left_handed =
        Transform::look_at(wide(eye), wide(eye + forward), [0.0, 1.0, 0.0])?.inverse();
    // Camera space is left-handed: without a mirror right and left would change places.
    let camera_to_world = camera_to_left_handed.after(&Transform::scale(-1.0, 1.0, 1.0)?)?;
    Some(Camera { projection: Projection::Perspective { fov }, camera_to_world, ..Camera::default() })
}

/// Turns the camera to an object so that it just fills the image, and puts a ground under it.
fn frame_object(scene: &mut SceneDesc, bounds: &Bounds3, center: Vec3, radius: f32) {
    let forward = -OBJECT_VIEW.normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let half = (OBJECT_FOV * 0.5).tan() * FILL;
    let slopes = [half * OBJECT_ASPECT, half];

    // A point at (x, y, z) of camera axes about the centre is inside the image of an eye at (ox, oy, −d) where
    // |x − ox| ≤ slope (z + d): each side of the image asks for a largest x − slope z.
    let mut reach = [[f32::NEG_INFINITY; 2]; 2];
    for_each_triangle(scene, |corners, _| {
        for corner in corners {
            let p = corner - center;
            let z = p.dot(forward);
            for (axis, across) in [p.dot(right), p.dot(up)].into_iter().enumerate() {
                let offset = slopes[axis] * z;
                reach[axis] = [reach[axis][0].max(across - offset), reach[axis][1].max(-across - offset)];
            }
        }
    });
    let distance = |axis: usize| (reach[axis][0] + reach[axis][1]) / (2.0 * slopes[axis]);
    // A mesh that is a line towards the camera needs no distance.
    let distance = distance(0).max(distance(1)).max(radius * 0.1);
    let middle = |axis: usize| (reach[axis][0] - reach[axis][1]) * 0.5;
    let eye = center + right * middle(0) + up * middle(1) - forward * distance;
    if let Some(camera) = camera_at(eye, forward, OBJECT_FOV) {
        scene.camera = camera;
    }
    add_ground(scene, bounds, center, radius);
}

/// Puts a disk under an object; none under what is itself as flat as a ground.
fn add_ground(scene: &mut SceneDesc, bounds: &Bounds3, center: Vec3, radius: f32) {
    if bounds.diagonal().y < radius * 0.02 {
        return;
    }
    let height = bounds.min.y - radius * 1e-3;
    let Some(shape_to_world) = upright(Vec3::new(center.x, height, center.z), Vec3::Y) else { return };
    let grey = Material::Diffuse { reflectance: SpectrumParam::Constant(Spectrum::Constant(0.4)) };
    let disk =
        Geometry::Disk { height: 0.0, radius: radius * 60.0, inner_radius: 0.0, phi_max: 4.0 * FRAC_PI_2 };
    add_shape(scene, "ground", disk, shape_to_world, grey, None);
}

/// Moves the origin to `position` and turns +z to `direction`.
fn upright(position: Vec3, direction: Vec3) -> Option<Transform> {
    let direction = direction.try_normalize()?;
    let [x, y, z] = [position.x, position.y, position.z].map(f64::from);
    let axis = Vec3::Z.cross(direction);
    let angle = f64::from(direction.z.clamp(-1.0, 1.0)).acos();
    let turned = match axis.try_normalize() {
        Some(axis) => Transform::rotate(angle, [axis.x, axis.y, axis.z].map(f64::from))?,
        None => Transform::rotate(angle, [1.0, 0.0, 0.0])?,
    };
    Transform::translate(x, y, z)?.after(&turned)
}

fn add_shape(
    scene: &mut SceneDesc,
    name: &str,
    geometry: Geometry,
    shape_to_world: Transform,
    material: Material,
    area_light: Option<AreaLight>,
) {
    let origin = Origin { name: Some(name.to_owned()), span: None };
    let material = scene.materials.push(material, origin.clone());
    let shape = Shape { area_light, ..Shape::new(geometry, shape_to_world, material) };
    let shape = scene.shapes.push(shape, origin);
    scene.world.push(shape);
}

fn add_light(scene: &mut SceneDesc, name: &str, light: Light) {
    scene.lights.push(light, Origin { name: Some(name.to_owned()), span: None });
}

fn add_sky(scene: &mut SceneDesc, rgb: [f32; 3]) {
    let sky = Light::Infinite {
        radiance: Radiance::Constant(Spectrum::srgb(rgb)),
        scale: 1.0,
        illuminance: None,
        light_to_world: Transform::IDENTITY,
        portal: None,
    };
    add_light(scene, "sky", sky);
}

/// A soft sky, and a lamp that lights the side towards the camera from the left.
fn light_object(scene: &mut SceneDesc, center: Vec3, radius: f32) {
    add_sky(scene, [0.42, 0.46, 0.52]);
    let towards_lamp = OBJECT_LAMP.normalize();
    let Some(shape_to_world) = upright(center + towards_lamp * (radius * 5.0), -towards_lamp) else { return };
    let disk =
        Geometry::Disk { height: 0.0, radius: radius * 1.5, inner_radius: 0.0, phi_max: 4.0 * FRAC_PI_2 };
    // Seen from the object it fills 0.28 sr: an irradiance of 2.4 beside the sky's 1.4.
    let lamp = AreaLight {
        radiance: SpectrumParam::Constant(Spectrum::srgb([9.0, 8.6, 8.0])),
        scale: 1.0,
        two_sided: false,
        power: None,
    };
    let black = Material::Diffuse { reflectance: SpectrumParam::Constant(Spectrum::Constant(0.0)) };
    add_shape(scene, "lamp", disk, shape_to_world, black, Some(lamp));
}

/// Height of the floor under the centre of a place.
fn floor(bounds: &Bounds3, from_center: &Surroundings) -> f32 {
    from_center.distance(-Vec3::Y).map_or(bounds.min.y, |distance| bounds.center().y - distance)
}

/// Puts the camera into a place.
fn frame_place(scene: &mut SceneDesc, bounds: &Bounds3, soup: &Soup, from_center: &Surroundings) {
    let size = bounds.diagonal();
    let along = if size.x >= size.z { Vec3::X } else { Vec3::Z };
    let length = size.dot(along);
    let center = bounds.center();
    let floor = floor(bounds, from_center);
    let eye_height = floor + 0.24 * (bounds.max.y - floor);

    let mut best: Option<(f32, Vec3, Vec3)> = None;
    for forward in [along, -along] {
        for share in [0.36, 0.30, 0.24] {
            let eye = center - forward * (length * share);
            let eye = Vec3::new(eye.x, eye_height, eye.z);
            let view = Surroundings::new(soup, eye).view(forward, length);
            if best.is_none_or(|(longest, _, _)| view > longest) {
                best = Some((view, eye, forward));
            }
        }
    }
    // The picture shows more above the horizon than below it.
    let tilt = Vec3::new(0.0, 0.08, 0.0);
    if let Some(camera) = best.and_then(|(_, eye, forward)| camera_at(eye, forward + tilt, PLACE_FOV)) {
        scene.camera = camera;
    }
}

fn light_place(scene: &mut SceneDesc, bounds: &Bounds3, from_center: &Surroundings) {
    let floor = floor(bounds, from_center);
    let height = bounds.max.y - floor;
    let is_open = from_center.distance(Vec3::Y).is_none();
    if is_open {
        add_sky(scene, [3.4, 3.7, 4.1]);
        let sun = Light::Distant {
            radiance: Spectrum::srgb([6.0, 5.6, 4.9]),
            scale: 1.0,
            illuminance: None,
            direction: Vec3::new(0.30, -1.0, 0.14).normalize(),
        };
        add_light(scene, "sun", sun);
    } else {
        add_sky(scene, [1.0; 3]);
    }
    // The farther the walls, the brighter the lamp that lights them alike.
    let strength = if is_open { 0.45 } else { 1.2 };
    let center = bounds.center();
    let ceiling = from_center.distance(Vec3::Y).map_or(bounds.max.y, |distance| center.y + distance);
    let lamp = Light::Point {
        intensity: Spectrum::srgb([1.0, 0.95, 0.88]),
        scale: strength * height * height,
        power: None,
        position: Vec3::new(center.x, floor + 0.6 * (ceiling - floor), center.z),
    };
    add_light(scene, "lamp", lamp);
}

#[cfg(test)]
mod tests;
