//! From radiance to a colour of the film.
//!
//! The sensor is the CIE 1931 standard observer, pbrt-v4's `cie1931`: a film of exposure one records the XYZ of radiance, in the
//! primaries of its space, without adaptation to a white.
//!
//! Deliberately absent: the sensitivities of real cameras, and white balance.

use glam::Vec4;
use sahl_image::{Adaptation, ColorSpace};

use crate::spectrum::cie::{self, Observer};
use crate::spectrum::{HeroWavelengths, Spectrum, Wavelengths};

/// What turns the radiance of a sample into a colour that the film adds up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sensor {
    /// From linear sRGB to the film's space; `None` where they are the same.
    matrix: Option<[[f32; 3]; 3]>,
    observer: &'static Observer,
    /// From XYZ to the film's space.
    from_xyz: [[f32; 3]; 3],
    exposure: f32,
    max_component: f32,
}

impl Sensor {
    pub(crate) fn new(film: &sahl_scene::Film) -> Self {
        let single = |matrix: [[f64; 3]; 3]| matrix.map(|row| row.map(|x| x as f32));
        let matrix = ColorSpace::Srgb.conversion_matrix(film.color_space, Adaptation::None);
        Self {
            matrix: (film.color_space != ColorSpace::Srgb).then(|| single(matrix)),
            observer: cie::observer(),
            from_xyz: single(from_xyz(film.color_space)),
            exposure: film.exposure,
            max_component: film.max_component,
        }
    }

    /// The exposed colour in the film's space, or `None` for what is no colour: from radiance with a negative or NaN
    /// lane, or too large for a number.
    #[inline]
    pub(crate) fn kept_color(&self, radiance: Spectrum, wavelengths: &Wavelengths) -> Option<[f32; 3]> {
        let color = self.color(radiance, wavelengths);
        (radiance.min_component() >= 0.0 && color.iter().all(|x| x.is_finite())).then_some(color)
    }

    /// The exposed colour in the film's space, scaled down where its largest component exceeds the film's limit.
    ///
    /// That of four wavelengths may have negative components: the mean over many has none if the film's space holds it.
    #[inline]
    pub(crate) fn color(&self, radiance: Spectrum, wavelengths: &Wavelengths) -> [f32; 3] {
        let rgb = match wavelengths {
            Wavelengths::Rgb => {
                let rgb = radiance.to_rgb();
                self.matrix.as_ref().map_or(rgb, |matrix| transform(matrix, rgb))
            }
            Wavelengths::Sampled(hero) => self.recorded(radiance, hero),
        };
        let mut rgb = rgb.map(|x| x * self.exposure);
        let largest = rgb[0].max(rgb[1]).max(rgb[2]);
        if largest > self.max_component {
            rgb = rgb.map(|x| x * (self.max_component / largest));
        }
        rgb
    }
}

impl Sensor {
    /// The colour in the film's space that radiance at sampled wavelengths estimates: the mean of the responses, each divided by
    /// the density of its wavelength, also of those that the path has dropped: nothing was added to their lanes since.
    fn recorded(&self, radiance: Spectrum, hero: &HeroWavelengths) -> [f32; 3] {
        let mut xyz = Vec4::ZERO;
        for ((value, lambda), pdf) in radiance.lanes().into_iter().zip(hero.drawn()).zip(hero.pdf()) {
            xyz += self.observer.at(lambda) * (0.25 * value / pdf);
        }
        let [x, y, z, _] = xyz.to_array();
        transform(&self.from_xyz, [x, y, z])
    }
}

/// From XYZ to `space`. The standards round the XYZ of their white; here the tabulated illuminant is exactly white, and the primaries
/// keep their chromaticities.
fn from_xyz(space: ColorSpace) -> [[f64; 3]; 3] {
    let white = cie::xyz(|nm| cie::white(space).at(nm)).map(f64::from);
    space.xyz_to_rgb_matrix().map(|row| {
        let seen: f64 = row.into_iter().zip(white).map(|(x, white)| x * white).sum();
        row.map(|x| x / seen)
    })
}

#[inline]
fn transform(matrix: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_space_and_limit_are_applied() {
        let film = sahl_scene::Film { exposure: 2.0, ..Default::default() };
        let sensor = Sensor::new(&film);
        assert_eq!(sensor.color(Spectrum::from_rgb([1.0, 2.0, 3.0]), &Wavelengths::Rgb), [2.0, 4.0, 6.0]);
        let limited = Sensor::new(&sahl_scene::Film { max_component: 3.0, ..film.clone() });
        assert_eq!(limited.color(Spectrum::from_rgb([1.0, 2.0, 3.0]), &Wavelengths::Rgb), [1.0, 2.0, 3.0]);
        let wide = Sensor::new(&sahl_scene::Film { color_space: ColorSpace::Rec2020, ..film });
        let [r, g, b] = wide.color(Spectrum::from_rgb([0.5, 0.0, 0.0]), &Wavelengths::Rgb);
        // The red of BT.709 in BT.2020 (ITU-R BT.2087, table 2).
        assert!((r - 0.6274).abs() < 1e-3 && (g - 0.0691).abs() < 1e-3 && (b - 0.0164).abs() < 1e-3);
    }

    /// The mean colour of radiance `power` over evenly spread samples of wavelengths.
    fn mean(sensor: &Sensor, terminate: bool, power: impl Fn(f32) -> f32) -> [f32; 3] {
        let count = 4000_u16;
        let mut sum = [0.0_f64; 3];
        for i in 0..count {
            let mut hero = HeroWavelengths::sample((f32::from(i) + 0.5) / f32::from(count));
            let mut throughput = Spectrum::ONE;
            if terminate {
                hero.terminate_secondary();
                throughput = HeroWavelengths::FIRST_FOR_ALL;
            }
            let radiance = throughput * Spectrum::from_lanes(hero.lambda().map(&power));
            let color = sensor.color(radiance, &Wavelengths::Sampled(hero));
            for (sum, value) in sum.iter_mut().zip(color) {
                *sum += f64::from(value) / f64::from(count);
            }
        }
        sum.map(|x| x as f32)
    }

    #[test]
    fn white_is_white_at_sampled_wavelengths() {
        for space in ColorSpace::ALL {
            let sensor = Sensor::new(&sahl_scene::Film { color_space: space, ..Default::default() });
            for terminate in [false, true] {
                let white = mean(&sensor, terminate, |nm| cie::white(space).at(nm));
                for value in white {
                    assert!((value - 1.0).abs() < 5e-5, "{space:?} {white:?}");
                }
            }
        }
    }

    #[test]
    fn a_line_of_light_is_outside_the_gamut_and_kept() {
        let sensor = Sensor::new(&sahl_scene::Film::default());
        let hero = HeroWavelengths::sample(0.4);
        let radiance = Spectrum::from_lanes([1.0, 0.0, 0.0, 0.0]);
        let wavelengths = Wavelengths::Sampled(hero);
        let kept = sensor.kept_color(radiance, &wavelengths).unwrap();
        assert!(kept.iter().any(|&x| x < 0.0), "{kept:?}");
        assert_eq!(sensor.kept_color(Spectrum::from_lanes([1.0, 0.0, -1.0, 0.0]), &wavelengths), None);
        assert_eq!(sensor.kept_color(Spectrum::from_lanes([1.0, f32::NAN, 0.0, 0.0]), &wavelengths), None);
    }
}
