//! Spectra as dense tables.

use glam::Vec4;

use super::hero::HeroWavelengths;

/// The shortest and the longest wavelength that is rendered, in nanometres: where the standard observer is defined.
pub(crate) const RANGE: [f32; 2] = [360.0, 830.0];

/// Entries of a table: one a nanometre.
pub(crate) const ENTRIES: usize = 471;

/// A function of wavelength from 360 to 830 nm: a value a nanometre, linear between them.
///
/// Samples at whole nanometres and joined by lines, as measurements usually are, lose nothing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DenseSpectrum {
    values: [f32; ENTRIES],
}

impl DenseSpectrum {
    /// The table of `f`, a function of nanometres.
    pub(crate) fn new(f: impl Fn(f32) -> f32) -> Self {
        Self { values: std::array::from_fn(|i| f(RANGE[0] + i as f32)) }
    }

    /// Applies `f` to each value.
    pub(crate) fn map(&self, f: impl Fn(f32) -> f32) -> Self {
        Self { values: self.values.map(f) }
    }

    /// The value at each whole nanometre from 360 on.
    pub(crate) fn values(&self) -> &[f32; ENTRIES] {
        &self.values
    }

    /// The value at one wavelength within the range; the nearest border's outside.
    #[inline]
    pub(crate) fn at(&self, lambda: f32) -> f32 {
        let (index, fraction) = place(lambda);
        let (before, after) = (self.values[index], self.values[index + 1]);
        before + fraction * (after - before)
    }

    /// The value at each wavelength of a path.
    #[inline]
    pub(crate) fn lanes(&self, hero: &HeroWavelengths) -> Vec4 {
        Vec4::from_array(hero.lambda().map(|lambda| self.at(lambda)))
    }
}

/// The entry at or before `lambda`, never the last one, and how far it is to the next.
#[inline]
pub(crate) fn place(lambda: f32) -> (usize, f32) {
    let at = (lambda - RANGE[0]).clamp(0.0, (ENTRIES - 1) as f32);
    let index = (at as usize).min(ENTRIES - 2);
    (index, at - index as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_exact_and_borders_go_on() {
        let line = DenseSpectrum::new(|nm| 2.0 * nm);
        for nm in [360.0, 360.25, 555.5, 829.75, 830.0] {
            assert_eq!(line.at(nm), 2.0 * nm);
        }
        assert_eq!(line.at(100.0), 720.0);
        assert_eq!(line.at(1000.0), 1660.0);
    }
}
