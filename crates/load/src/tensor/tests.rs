//! Files that are written here, byte by byte, and read back; and damaged ones.

use super::*;
use crate::measured;

/// An array to write.
pub(crate) struct Written<'a> {
    pub(crate) name: &'a str,
    pub(crate) kind: u8,
    pub(crate) shape: Vec<u64>,
    pub(crate) values: Vec<u8>,
}

pub(crate) fn floats<'a>(name: &'a str, shape: &[u64], value: impl Fn(u64) -> f32) -> Written<'a> {
    let values = (0..shape.iter().product()).flat_map(|i| value(i).to_le_bytes()).collect();
    Written { name, kind: FLOAT32, shape: shape.to_vec(), values }
}

pub(crate) fn file(fields: &[Written<'_>]) -> Vec<u8> {
    let described: usize = fields.iter().map(|field| 13 + field.name.len() + 8 * field.shape.len()).sum();
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend((fields.len() as u32).to_le_bytes());
    let mut offset = (bytes.len() + described) as u64;
    for field in fields {
        bytes.extend((field.name.len() as u16).to_le_bytes());
        bytes.extend(field.name.as_bytes());
        bytes.extend((field.shape.len() as u16).to_le_bytes());
        bytes.push(field.kind);
        bytes.extend(offset.to_le_bytes());
        bytes.extend(field.shape.iter().flat_map(|side| side.to_le_bytes()));
        offset += field.values.len() as u64;
    }
    bytes.extend(fields.iter().flat_map(|field| field.values.iter().copied()));
    bytes
}

/// A measurement at one azimuth, two polar angles and three wavelengths.
fn measurement() -> Vec<Written<'static>> {
    vec![
        floats("theta_i", &[2], |i| i as f32),
        floats("phi_i", &[1], |_| 0.0),
        floats("wavelengths", &[3], |i| 400.0 + 100.0 * i as f32),
        floats("ndf", &[2, 4], |i| i as f32),
        floats("sigma", &[2, 2], |_| 0.25),
        floats("vndf", &[1, 2, 3, 2], |_| 1.0),
        floats("luminance", &[1, 2, 2, 2], |_| 1.0),
        floats("spectra", &[1, 2, 3, 2, 2], |i| i as f32),
        Written { name: "jacobian", kind: UINT8, shape: vec![1], values: vec![1] },
        Written { name: "description", kind: UINT8, shape: vec![3], values: b"tin".to_vec() },
    ]
}

#[test]
fn what_is_written_is_read() {
    let brdf = measured::read(&file(&measurement())).unwrap();
    assert_eq!(brdf.problem(), None);
    assert_eq!((&*brdf.theta, &*brdf.phi), (&[0.0, 1.0][..], &[0.0][..]));
    assert_eq!(*brdf.wavelengths, [400.0, 500.0, 600.0]);
    assert_eq!((brdf.ndf.resolution, brdf.ndf.values[7]), ([4, 2], 7.0));
    assert_eq!((brdf.vndf.resolution, brdf.spectra.values[23]), ([2, 3], 23.0));
    assert!(brdf.is_relative && brdf.is_isotropic());
}

#[test]
fn every_damaged_file_is_refused_where_it_is_damaged() {
    let whole = file(&measurement());
    for length in 0..whole.len() {
        let error = measured::read(&whole[..length]).unwrap_err();
        assert!(error.offset <= length as u64, "{length}: {error}");
    }
    // Bytes of the header and of the descriptions: nothing may panic.
    for at in 0..400 {
        for value in [0, 1, 127, 255] {
            let mut damaged = whole.clone();
            damaged[at] = value;
            if let Ok(brdf) = measured::read(&damaged) {
                let _ = brdf.problem();
            }
        }
    }
    let message = |bytes: &[u8]| measured::read(bytes).unwrap_err().to_string();
    assert_eq!(message(b"P6 3 3"), "at byte 0: it is not a tensor file");
    let mut version = whole.clone();
    version[12] = 2;
    assert_eq!(message(&version), "at byte 12: its version is 2.0: only 1.0 can be read");
    let mut many = whole;
    many[17] = 1;
    assert_eq!(message(&many), "at byte 14: 16777226 arrays are more than 256");
}

#[test]
fn arrays_that_do_not_fit_are_named() {
    let without = |name: &str, instead: Option<Written<'static>>| {
        let mut fields = measurement();
        fields.retain(|field| field.name != name);
        fields.extend(instead);
        measured::read(&file(&fields)).unwrap_err().to_string()
    };
    assert_eq!(without("sigma", None), "at byte 0: there is no array `sigma`");
    let message = without("vndf", Some(floats("vndf", &[1, 1, 3, 2], |_| 1.0)));
    assert!(
        message.contains("`vndf` has the shape [1, 1, 3, 2]: expected one that begins with [1, 2]"),
        "{message}"
    );
    let message = without("ndf", Some(floats("ndf", &[8], |_| 1.0)));
    assert!(message.contains("`ndf` has 1 dimensions of type 10: expected 2 dimensions"), "{message}");
    let message = without("jacobian", Some(floats("jacobian", &[1], |_| 1.0)));
    assert!(message.contains("expected 1 dimensions of bytes (type 1)"), "{message}");
}

#[test]
fn numbers_that_make_no_sense_are_found() {
    let problem = |change: fn(&mut sahl_scene::MeasuredBrdf)| {
        let mut brdf = measured::read(&file(&measurement())).unwrap();
        change(&mut brdf);
        brdf.problem().unwrap()
    };
    assert!(problem(|brdf| brdf.theta = [1.0, 0.5].into()).contains("`theta_i` must increase"));
    assert!(problem(|brdf| brdf.wavelengths = [].into()).contains("`wavelengths`"));
    assert!(problem(|brdf| brdf.phi = [0.0, 1.0, 2.5].into()).contains("`phi_i` must span"));
    assert!(
        problem(|brdf| brdf.sigma.values = [0.0, f32::NAN, 0.0, 1.0].into()).contains("value 1 of `sigma`")
    );
    assert!(problem(|brdf| brdf.vndf.resolution = [1, 6]).contains("expected 2 x 2 or more"));
    assert!(problem(|brdf| brdf.spectra.values = [0.0; 5].into()).contains("`spectra` has 5 values"));
}
