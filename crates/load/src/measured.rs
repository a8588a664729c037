//! Measured surfaces: files of the RGL material database.
//!
//! Source: Dupuy, Jakob, *An Adaptive Parameterization for Efficient Material Acquisition and Rendering*, ACM TOG 37(6), 2018.
//!
//! Deliberately absent: files that hold no spectra but colours. pbrt-v4 reads spectra alone, too.

use sahl_scene::{MeasuredBrdf, MeasuredGrid};

use crate::tensor::{TensorError, Tensors};

/// The measurement in the tensor file `bytes`; whether its numbers make sense is another question.
pub(crate) fn read(bytes: &[u8]) -> Result<MeasuredBrdf, TensorError> {
    let tensors = Tensors::read(bytes)?;
    let axis = |name| tensors.floats::<1>(name).map(|(_, values)| values);
    let (theta, phi, wavelengths) = (axis("theta_i")?, axis("phi_i")?, axis("wavelengths")?);
    let lengths = [phi.len(), theta.len(), wavelengths.len()].map(|length| length as u64);
    let plane = |name| {
        let ([y, x], values) = tensors.floats(name)?;
        grid(&tensors, name, [x, y], values)
    };
    let planes = |name| {
        let ([phi, theta, y, x], values) = tensors.floats(name)?;
        check(&tensors, name, &[phi, theta], &lengths[..2])?;
        grid(&tensors, name, [x, y], values)
    };
    let spectra = || {
        let ([phi, theta, wavelengths, y, x], values) = tensors.floats("spectra")?;
        check(&tensors, "spectra", &[phi, theta, wavelengths], &lengths)?;
        grid(&tensors, "spectra", [x, y], values)
    };
    let [jacobian] = *tensors.bytes("jacobian")? else {
        return Err(tensors.mismatch("jacobian", "one byte".to_owned()));
    };
    Ok(MeasuredBrdf {
        ndf: plane("ndf")?,
        sigma: plane("sigma")?,
        vndf: planes("vndf")?,
        luminance: planes("luminance")?,
        spectra: spectra()?,
        is_relative: jacobian != 0,
        theta: theta.into(),
        phi: phi.into(),
        wavelengths: wavelengths.into(),
    })
}

/// Complains unless the first dimensions of the array `name` are those of the axes.
fn check(
    tensors: &Tensors<'_>,
    name: &'static str,
    found: &[u64],
    expected: &[u64],
) -> Result<(), TensorError> {
    let complaint = || tensors.mismatch(name, format!("one that begins with {expected:?}"));
    if found == expected { Ok(()) } else { Err(complaint()) }
}

fn grid(
    tensors: &Tensors<'_>,
    name: &'static str,
    resolution: [u64; 2],
    values: Vec<f32>,
) -> Result<MeasuredGrid, TensorError> {
    let [Ok(x), Ok(y)] = resolution.map(u32::try_from) else {
        return Err(tensors.mismatch(name, "less than 2^32 values a side".to_owned()));
    };
    Ok(MeasuredGrid { resolution: [x, y], values: values.into() })
}
