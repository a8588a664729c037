//! Measured coefficients of scattering and absorption by name: pbrt-v4's `preset`.
//!
//! Origin: `data/media/PROVENANCE.md`.

use sahl_scene::Diagnostic;

use super::super::reader::Reader;
use super::super::report::quote;

/// One material a line: name, scattering, absorption; per millimetre, in linear sRGB.
const TABLE: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/media/scattering.csv"));

/// The coefficients of a measured material per millimetre, in linear sRGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measured {
    /// Scattering.
    pub(super) sigma_s: [f32; 3],
    /// Absorption.
    pub(super) sigma_a: [f32; 3],
}

/// The measured material that the string `parameter` names; one that nobody measured is an error.
pub(super) fn named(p: &Reader<'_>, parameter: &'static str) -> Option<Measured> {
    let name = p.string(parameter).filter(|name| !name.text.is_empty())?;
    let measured = measured(&name.text);
    if measured.is_none() {
        let message = format!("there are no measured coefficients of {}", quote(name.text.as_bytes()));
        let diagnostic = Diagnostic::error("unknown-preset", name.span, message);
        p.report().push_with_choices(diagnostic, &name.text, names());
    }
    measured
}

/// The names of the measured materials.
fn names() -> impl Iterator<Item = &'static str> + Clone {
    rows().map(|(name, _)| name)
}

/// The material called `name`.
fn measured(name: &str) -> Option<Measured> {
    let (_, values) = rows().find(|(found, _)| *found == name)?;
    let mut values = values.split(',').map(|value| value.parse().ok());
    let mut triple = || Some([values.next()??, values.next()??, values.next()??]);
    Some(Measured { sigma_s: triple()?, sigma_a: triple()? })
}

fn rows() -> impl Iterator<Item = (&'static str, &'static str)> + Clone {
    TABLE.lines().skip(1).filter_map(|line| line.split_once(','))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_holds_numbers() {
        assert_eq!(names().count(), 47);
        for name in names() {
            let Measured { sigma_s, sigma_a } = measured(name).unwrap();
            assert!(sigma_s.iter().chain(&sigma_a).all(|x| *x >= 0.0 && *x < 100.0), "{name}");
            assert!(sigma_a[0] + sigma_s[0] > 0.0, "{name}");
        }
        let milk = Measured { sigma_s: [2.55, 3.21, 3.77], sigma_a: [0.0011, 0.0024, 0.014] };
        assert_eq!(measured("Wholemilk"), Some(milk));
        assert_eq!(measured("name"), None);
    }
}
