//! From radiance to a colour of the film.

use sahl_image::{Adaptation, ColorSpace};

use crate::Spectrum;

/// What turns the radiance of a sample into a colour that the film adds up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sensor {
    /// From linear sRGB to the film's space; `None` where they are the same.
    matrix: Option<[[f32; 3]; 3]>,
    exposure: f32,
    max_component: f32,
}

impl Sensor {
    pub(crate) fn new(film: &sahl_scene::Film) -> Self {
        let matrix = ColorSpace::Srgb.conversion_matrix(film.color_space, Adaptation::None);
        Self {
            matrix: (film.color_space != ColorSpace::Srgb).then(|| matrix.map(|row| row.map(|x| x as f32))),
            exposure: film.exposure,
            max_component: film.max_component,
        }
    }

    /// The exposed colour in the film's space, or `None` for what is no colour: from radiance with a negative or NaN
    /// lane, or too large for a number.
    #[inline]
    pub(crate) fn kept_color(&self, radiance: Spectrum) -> Option<[f32; 3]> {
        let color = self.color(radiance);
        (radiance.min_component() >= 0.0 && color.iter().all(|x| x.is_finite())).then_some(color)
    }

    /// The exposed colour in the film's space, scaled down where its largest component exceeds the film's limit.
    #[inline]
    pub(crate) fn color(&self, radiance: Spectrum) -> [f32; 3] {
        let mut rgb = radiance.to_rgb().map(|x| x * self.exposure);
        if let Some(m) = &self.matrix {
            rgb = m.map(|row| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]);
        }
        let largest = rgb[0].max(rgb[1]).max(rgb[2]);
        if largest > self.max_component {
            rgb = rgb.map(|x| x * (self.max_component / largest));
        }
        rgb
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_space_and_limit_are_applied() {
        let film = sahl_scene::Film { exposure: 2.0, ..Default::default() };
        let sensor = Sensor::new(&film);
        assert_eq!(sensor.color(Spectrum::from_rgb([1.0, 2.0, 3.0])), [2.0, 4.0, 6.0]);
        let limited = Sensor::new(&sahl_scene::Film { max_component: 3.0, ..film.clone() });
        assert_eq!(limited.color(Spectrum::from_rgb([1.0, 2.0, 3.0])), [1.0, 2.0, 3.0]);
        let wide = Sensor::new(&sahl_scene::Film { color_space: ColorSpace::Rec2020, ..film });
        let [r, g, b] = wide.color(Spectrum::from_rgb([0.5, 0.0, 0.0]));
        // The red of BT.709 in BT.2020 (ITU-R BT.2087, table 2).
        assert!((r - 0.6274).abs() < 1e-3 && (g - 0.0691).abs() < 1e-3 && (b - 0.0164).abs() < 1e-3);
    }
}
