//! The wavelengths of a path in spectral mode.

use glam::Vec4;

use super::Spectrum;

/// Wavelength at which the density of [`visible_pdf`] is highest, in nanometres.
const CENTER: f32 = 538.0;
/// How fast it falls off, per nanometre.
const RATE: f32 = 0.0072;
/// tanh(RATE (CENTER − 360)).
const TANH_FIRST: f32 = 0.856_910_6;
/// TANH_FIRST + tanh(RATE (830 − CENTER)).
const TANH_SPAN: f32 = 1.827_502;

/// Four wavelengths with the densities by which they were drawn.
///
/// The first is the hero: where light of different wavelengths goes different ways, the path follows it and drops the others.
///
/// Source: Wilkie, Nawaz, Droske, Weidlich, Hanika, *Hero Wavelength Spectral Sampling*, EGSR 2014. Deviation from pbrt-v4: wavelengths
/// that are dropped keep their densities, and what the path finds from there on is multiplied by
/// [`HeroWavelengths::FIRST_FOR_ALL`]. What it found before stays an estimate at all four, also where it was weighed by how likely
/// each of them would have made the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeroWavelengths {
    /// What the lanes of the path stand for now.
    lambda: Vec4,
    /// As they were drawn.
    drawn: Vec4,
    pdf: Vec4,
}

impl HeroWavelengths {
    /// Four wavelengths from one uniform number in [0, 1): a quarter apart in the distribution of [`sample_visible`].
    #[inline]
    pub fn sample(u: f32) -> Self {
        let (mut lambda, mut pdf) = ([0.0; 4], [0.0; 4]);
        for lane in 0..4 {
            let v = u + 0.25 * lane as f32;
            let t = tanh_at(if v < 1.0 { v } else { v - 1.0 });
            lambda[lane] = lambda_at(t);
            pdf[lane] = pdf_at(t);
        }
        let lambda = Vec4::from_array(lambda);
        Self { lambda, drawn: lambda, pdf: Vec4::from_array(pdf) }
    }

    /// What a path that drops all wavelengths but the first is multiplied by: the first then stands for the four.
    pub const FIRST_FOR_ALL: Spectrum = Spectrum::from_lanes([4.0, 0.0, 0.0, 0.0]);

    /// The wavelengths in nanometres at which the path looks, in [360, 830].
    #[inline]
    pub fn lambda(&self) -> [f32; 4] {
        self.lambda.to_array()
    }

    /// The wavelengths that were drawn, by which the lanes of the path's radiance are recorded.
    #[inline]
    pub fn drawn(&self) -> [f32; 4] {
        self.drawn.to_array()
    }

    /// The density per nanometre of each that was drawn.
    #[inline]
    pub fn pdf(&self) -> [f32; 4] {
        self.pdf.to_array()
    }

    /// Drops all wavelengths but the first, at which all lanes look from now on. What they find has to be multiplied by
    /// [`HeroWavelengths::FIRST_FOR_ALL`], once. Nothing if that was done before.
    #[inline]
    pub fn terminate_secondary(&mut self) {
        self.lambda = Vec4::splat(self.lambda.x);
    }

    /// Whether only the first wavelength is left.
    #[inline]
    pub fn is_terminated(&self) -> bool {
        // No two of those that are drawn together are the same.
        self.lambda.y == self.lambda.x
    }

    /// The wavelengths from −1 at 360 nm to 1 at 830 nm.
    #[inline]
    pub(super) fn normalized(&self) -> Vec4 {
        (self.lambda - Vec4::splat(595.0)) * (1.0 / 235.0)
    }
}

/// A wavelength in [360, 830] nm, with the density of [`visible_pdf`], from a uniform number in [0, 1).
#[inline]
pub fn sample_visible(u: f32) -> f32 {
    lambda_at(tanh_at(u))
}

/// Density per nanometre of [`sample_visible`]: a sech² about 538 nm, which fits the sum of the observer's responses.
///
/// Source: Radziszewski, Boryczko, Alda, *An Improved Technique for Full Spectral Rendering*, WSCG 2009, with the centre
/// and width that pbrt-v4 uses.
#[inline]
pub fn visible_pdf(lambda: f32) -> f32 {
    if (360.0..=830.0).contains(&lambda) { pdf_at((RATE * (lambda - CENTER)).tanh()) } else { 0.0 }
}

/// tanh(RATE (λ − CENTER)) of the wavelength with this share of the distribution below it.
#[inline]
fn tanh_at(u: f32) -> f32 {
    TANH_SPAN * u - TANH_FIRST
}

#[inline]
fn lambda_at(t: f32) -> f32 {
    // The inverse hyperbolic tangent. Rounding at the ends of the range must not lead out of it.
    (CENTER + (0.5 / RATE) * ((1.0 + t) / (1.0 - t)).ln()).clamp(360.0, 830.0)
}

/// The derivative of the distribution by wavelength: sech² = 1 − tanh².
#[inline]
fn pdf_at(t: f32) -> f32 {
    RATE / TANH_SPAN * (1.0 - t * t)
}

#[cfg(test)]
mod tests {
    use sahl_testkit::chi2::LineTest;

    use super::*;

    #[test]
    fn the_constants_follow_from_centre_and_rate() {
        let (low, high) = ((0.0072_f64 * (538.0 - 360.0)).tanh(), (0.0072_f64 * (830.0 - 538.0)).tanh());
        assert!((f64::from(TANH_FIRST) - low).abs() < 1e-7);
        assert!((f64::from(TANH_SPAN) - low - high).abs() < 2e-7);
    }

    #[test]
    fn wavelengths_follow_their_density() {
        let test = LineTest { range: [360.0, 830.0], ..LineTest::default() };
        test.run(|u| Some(sample_visible(u)), visible_pdf).unwrap();
    }

    #[test]
    fn every_lane_follows_the_density() {
        for lane in 0..4 {
            let test = LineTest { range: [360.0, 830.0], tests: 4, ..LineTest::default() };
            test.run(|u| Some(HeroWavelengths::sample(u).lambda()[lane]), visible_pdf).unwrap();
        }
    }

    #[test]
    fn densities_are_those_of_the_wavelengths() {
        for i in 0..1000 {
            let hero = HeroWavelengths::sample(i as f32 / 1000.0);
            for (lambda, pdf) in hero.lambda().into_iter().zip(hero.pdf()) {
                assert!((360.0..=830.0).contains(&lambda));
                assert!((pdf / visible_pdf(lambda) - 1.0).abs() < 1e-3, "{lambda} {pdf}");
            }
        }
        let last = HeroWavelengths::sample(1.0_f32.next_down());
        assert!(last.lambda().iter().all(|lambda| (360.0..=830.0).contains(lambda)));
    }

    #[test]
    fn no_two_wavelengths_are_the_same() {
        for i in 0..100_000 {
            assert!(!HeroWavelengths::sample(i as f32 / 100_000.0).is_terminated(), "{i}");
        }
        assert!(!HeroWavelengths::sample(1.0_f32.next_down()).is_terminated());
    }

    #[test]
    fn the_first_wavelength_takes_over_once() {
        let full = HeroWavelengths::sample(0.3);
        let mut hero = full;
        hero.terminate_secondary();
        hero.terminate_secondary();
        assert_eq!((hero.drawn(), hero.pdf()), (full.lambda(), full.pdf()));
        assert_eq!(hero.lambda(), [full.lambda()[0]; 4]);
        assert!(hero.is_terminated() && !full.is_terminated());
    }
}
