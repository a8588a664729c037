//! A measurement from its file to the image: paper that was measured looks like paper.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI};

use sahl::load::{MemoryAssets, load_pbrt};
use sahl::math::Vec3;
use sahl::scene::{ColorMode, SceneDesc};

/// Values a side of each table, and polar angles.
const SIDE: usize = 48;
const POLAR: usize = 16;

/// That of pbrt's `diffuse`.
const ALBEDO: f32 = 0.5;

fn direction(theta: f32, phi: f32) -> Vec3 {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta.sin_cos(), phi.sin_cos());
    Vec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// An array of a tensor file: its name, type and shape, and its bytes.
type Field = (&'static str, u8, Vec<usize>, Vec<u8>);

fn floats(name: &'static str, shape: &[usize], values: &[f32]) -> Field {
    assert_eq!(shape.iter().product::<usize>(), values.len(), "{name}");
    (name, 10, shape.to_vec(), values.iter().flat_map(|value| value.to_le_bytes()).collect())
}

fn tensor_file(fields: &[Field]) -> Vec<u8> {
    let described: usize = fields.iter().map(|(name, _, shape, _)| 13 + name.len() + 8 * shape.len()).sum();
    let mut bytes = b"tensor_file\0\x01\0".to_vec();
    bytes.extend((fields.len() as u32).to_le_bytes());
    let mut offset = (bytes.len() + described) as u64;
    for (name, kind, shape, values) in fields {
        bytes.extend((name.len() as u16).to_le_bytes());
        bytes.extend(name.as_bytes());
        bytes.extend((shape.len() as u16).to_le_bytes());
        bytes.push(*kind);
        bytes.extend(offset.to_le_bytes());
        bytes.extend(shape.iter().flat_map(|&side| (side as u64).to_le_bytes()));
        offset += values.len() as u64;
    }
    bytes.extend(fields.iter().flat_map(|(_, _, _, values)| values));
    bytes
}

/// Paper, measured without a distribution of microfacets: points of the tables are halfway vectors as they are.
fn measured_paper() -> Vec<u8> {
    let theta: Vec<f32> = (0..POLAR).map(|i| 1.56 * i as f32 / (POLAR - 1) as f32).collect();
    let (mut luminance, mut spectra) = (Vec::new(), Vec::new());
    for &theta_o in &theta {
        let wo = direction(theta_o, 0.0);
        let mut values = Vec::new();
        for i in 0..SIDE * SIDE {
            let [x, y] = [i % SIDE, i / SIDE].map(|place| place as f32 / (SIDE - 1) as f32);
            let m = direction(x * x * FRAC_PI_2, (2.0 * y - 1.0) * PI);
            let cos = 2.0 * wo.dot(m) * m.z - wo.z;
            // In proportion to f cos θi times the Jacobian of directions.
            luminance.push(cos.max(0.0) * wo.dot(m).max(0.0) * x * m.x.hypot(m.y));
            values.push(ALBEDO * FRAC_1_PI * cos.max(0.0));
        }
        spectra.extend_from_slice(&values);
        spectra.extend(values);
    }
    tensor_file(&[
        floats("theta_i", &[POLAR], &theta),
        floats("phi_i", &[1], &[0.0]),
        floats("wavelengths", &[2], &[400.0, 700.0]),
        floats("ndf", &[2, 2], &[1.0; 4]),
        floats("sigma", &[2, 2], &[0.25; 4]),
        floats("vndf", &[1, POLAR, 2, 2], &[1.0; 4 * POLAR]),
        floats("luminance", &[1, POLAR, SIDE, SIDE], &luminance),
        floats("spectra", &[1, POLAR, 2, SIDE, SIDE], &spectra),
        ("jacobian", 1, vec![1], vec![1]),
        ("description", 1, vec![5], b"paper".to_vec()),
    ])
}

/// The mean of an image that a ball of the given material fills, under a bright sky.
fn mean(material: &str, assets: &MemoryAssets, color: ColorMode) -> f64 {
    let scene = format!(
        r#"LookAt 0 0 5  0 0 0  0 1 0  Camera "perspective" "float fov" 18
        Film "rgb" "integer xresolution" 16 "integer yresolution" 16
        Sampler "independent" "integer pixelsamples" 64
        WorldBegin LightSource "infinite" "rgb L" [ 1 1 1 ]
        Material {material} Shape "sphere""#
    );
    let loaded = load_pbrt("ball.pbrt", scene.into_bytes(), assets);
    assert!(loaded.diagnostics.is_empty(), "{:?}", loaded.diagnostics);
    let scene = SceneDesc { color, ..loaded.scene };
    let built = sahl::build(&scene).unwrap_or_else(|error| panic!("{error}"));
    let image = sahl::develop(&sahl::render(&built));
    let pixels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    pixels.map(|(x, y)| f64::from(image.pixel(x, y)[1])).sum::<f64>() / 256.0
}

#[test]
fn measured_paper_looks_like_paper() {
    let mut assets = MemoryAssets::default();
    assets.insert("paper.bsdf", measured_paper());
    for color in [ColorMode::Rgb, ColorMode::Spectral] {
        let measured = mean(r#""measured" "string filename" "paper.bsdf""#, &assets, color);
        let paper = mean(r#""diffuse""#, &assets, color);
        assert!((measured / paper - 1.0).abs() < 0.02, "{color:?}: {measured} instead of {paper}");
    }
}
