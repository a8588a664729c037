//! Small scenes for the tests of the renderer.

use std::f32::consts::TAU;

use sahl_image::{Image, Pixels};
use sahl_math::{Transform, Vec3};
use sahl_render::{BuildOptions, RenderOptions, Rendered, Scene, build, render};
use sahl_scene::{
    AreaLight, Filter, Geometry, Handle, Integrator, Light, Material, Origin, PatchMesh, PathTracer,
    Projection, Radiance, Sampler, SamplerKind, SceneDesc, Shape, Spectrum, SpectrumParam, TriangleMesh,
};

pub(crate) const SAMPLERS: [SamplerKind; 2] = [SamplerKind::Sobol, SamplerKind::Independent];

/// An empty scene: square image, box filter, path tracing of depth 5.
pub(crate) fn empty(resolution: u32, samples: u32) -> SceneDesc {
    let mut scene = SceneDesc::default();
    scene.film.resolution = [resolution; 2];
    scene.filter = Filter::Box { radius: [0.5; 2] };
    scene.sampler = Sampler { kind: SamplerKind::Sobol, samples, seed: 1 };
    scene.integrator = path(5);
    scene
}

pub(crate) fn path(max_depth: u32) -> Integrator {
    Integrator::Path(PathTracer { max_depth, ..PathTracer::default() })
}

pub(crate) fn grey(value: f32) -> Spectrum {
    Spectrum::srgb([value; 3])
}

pub(crate) fn diffuse(scene: &mut SceneDesc, albedo: f32) -> Handle<Material> {
    let reflectance = SpectrumParam::Constant(grey(albedo));
    scene.materials.push(Material::Diffuse { reflectance }, Origin::default())
}

pub(crate) fn glass(scene: &mut SceneDesc) -> Handle<Material> {
    let roughness = sahl_scene::Roughness::SMOOTH;
    scene.materials.push(Material::Dielectric { eta: Spectrum::Constant(1.5), roughness }, Origin::default())
}

/// Adds a shape of the world.
pub(crate) fn add(scene: &mut SceneDesc, geometry: Geometry, material: Handle<Material>) -> Handle<Shape> {
    add_placed(scene, geometry, material, Transform::IDENTITY)
}

pub(crate) fn add_placed(
    scene: &mut SceneDesc,
    geometry: Geometry,
    material: Handle<Material>,
    shape_to_world: Transform,
) -> Handle<Shape> {
    let shape = Shape::new(geometry, shape_to_world, material);
    let shape = scene.shapes.push(shape, Origin::default());
    scene.world.push(shape);
    shape
}

/// Makes a shape emit the radiance from its front.
pub(crate) fn emit(scene: &mut SceneDesc, shape: Handle<Shape>, radiance: f32) {
    let light = AreaLight {
        radiance: SpectrumParam::Constant(grey(radiance)),
        scale: 1.0,
        two_sided: false,
        power: None,
    };
    scene.shapes[shape].area_light = Some(light);
}

pub(crate) const fn sphere(radius: f32) -> Geometry {
    Geometry::Sphere { radius, z_min: -radius, z_max: radius, phi_max: TAU }
}

/// A patch with the given corners at (u, v) = (0,0), (1,0), (0,1), (1,1).
pub(crate) fn patch(scene: &mut SceneDesc, corners: [[f32; 3]; 4]) -> Geometry {
    let positions = corners.map(Vec3::from).into();
    let mesh = PatchMesh { indices: [[0, 1, 2, 3]].into(), positions, ..PatchMesh::default() };
    Geometry::Patches(scene.patch_meshes.push(mesh, Origin::default()))
}

/// The same surface as two triangles.
pub(crate) fn quad(scene: &mut SceneDesc, corners: [[f32; 3]; 4]) -> Geometry {
    let positions = corners.map(Vec3::from).into();
    let mesh = TriangleMesh { indices: [[0, 1, 3], [0, 3, 2]].into(), positions, ..TriangleMesh::default() };
    Geometry::Triangles(scene.triangle_meshes.push(mesh, Origin::default()))
}

/// Corners of the square |x|, |y| ≤ `half` at height `z`, facing up.
pub(crate) const fn square(half: f32, z: f32) -> [[f32; 3]; 4] {
    [[-half, -half, z], [half, -half, z], [-half, half, z], [half, half, z]]
}

/// Looks straight down from height `z` with parallel rays at the square |x|, |y| ≤ `half`: image right is +x, up is +y.
pub(crate) fn look_down(scene: &mut SceneDesc, z: f64, half: f32) {
    // Camera +z is world −z; mirrored, so that both x axes agree.
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, z]];
    scene.camera.camera_to_world = Transform::from_rows(rows).unwrap();
    scene.camera.projection = Projection::Orthographic;
    scene.camera.screen_window = Some([-half, half, -half, half]);
}

pub(crate) fn sky(scene: &mut SceneDesc, radiance: Spectrum) {
    let light = Light::Infinite {
        radiance: Radiance::Constant(radiance),
        scale: 1.0,
        illuminance: None,
        light_to_world: Transform::IDENTITY,
        portal: None,
    };
    scene.lights.push(light, Origin::default());
}

pub(crate) fn built(scene: &SceneDesc) -> Scene {
    let (built, diagnostics) = build(scene, &BuildOptions::default());
    built.unwrap_or_else(|| panic!("{diagnostics:?}"))
}

pub(crate) fn rendered(scene: &SceneDesc) -> Rendered {
    let options = RenderOptions { threads: 1, ..RenderOptions::default() };
    let rendered = render(&built(scene), &options, &());
    assert!(rendered.completed);
    assert_eq!(rendered.film.dropped(), 0, "{:?}", rendered.film.dropped_samples());
    rendered
}

pub(crate) fn values(image: &Image) -> &[f32] {
    match &image.pixels {
        Pixels::F32(values) => values,
        Pixels::U8(_) => panic!("films develop to floats"),
    }
}

/// Mean of the first channel over all pixels, and the standard deviation of that mean.
pub(crate) fn mean(scene: &SceneDesc) -> (f64, f64) {
    mean_of(scene, 0)
}

pub(crate) fn mean_of(scene: &SceneDesc, channel: usize) -> (f64, f64) {
    let film = rendered(scene).film;
    let picked = |image: &Image| -> Vec<f64> {
        values(image).iter().skip(channel).step_by(3).map(|&x| f64::from(x)).collect()
    };
    let (colors, variances) = (picked(&film.develop()), picked(&film.variance()));
    let n = colors.len() as f64;
    (colors.iter().sum::<f64>() / n, variances.iter().sum::<f64>().sqrt() / n)
}

/// Checks a mean against what it should be: within 4.5 standard deviations, which are to be at most `noise` of it.
pub(crate) fn expect_mean(scene: &SceneDesc, expected: f64, noise: f64, what: &str) {
    expect_channel(scene, 0, expected, noise, what);
}

/// The same for one channel.
pub(crate) fn expect_channel(scene: &SceneDesc, channel: usize, expected: f64, noise: f64, what: &str) {
    let (found, deviation) = mean_of(scene, channel);
    assert!(deviation <= noise * expected, "{what}: {found} ± {deviation} is too noisy for {expected}");
    let rounding = 2e-5 * expected;
    assert!(
        (found - expected).abs() <= 4.5 * deviation + rounding,
        "{what}: {found} ± {deviation}, not {expected}"
    );
}
