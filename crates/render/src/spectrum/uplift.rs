//! From RGB to spectra.
//!
//! A reflectance is a sigmoid of a quadratic polynomial in the wavelength, whose coefficients are looked up in a table
//! of the colour space: smooth, between zero and one, and of the given colour under the space's white. Other quantities are a multiple of one, and
//! light a multiple of one times the white of the space: so white is white.
//!
//! Source: Jakob, Hanika, *A Low-Dimensional Function Space for Efficient Spectral Upsampling*, CGF 38(2), 2019; roles as
//! in pbrt-v4. Deviation: the tables are smaller than theirs, because their coefficients are scaled and their axes are
//! spaced (`xtask/src/uplift`); what the interpolation costs in colour is asserted below.
//!
//! Colours of light and of other quantities without a limit are multiples of one whose largest component is a half: these have
//! finer tables, because skies are seen without noise; light is always looked up there, so that a lamp and a texture of one colour
//! are alike. Other colours that are given once, and seen often, are met exactly.
//!
//! Deliberately absent: making the tables, which is `cargo xtask uplift`.

use glam::{DMat3, DVec3, Vec4};
use sahl_image::ColorSpace;

use super::cie;
use super::dense::{DenseSpectrum, ENTRIES as WAVELENGTHS, RANGE};
use super::hero::HeroWavelengths;

/// Cells along each axis of a table.
const RESOLUTION: usize = 32;
/// Coefficients in a table: by largest component, then its value, then the ratio of the component before it, then that of
/// the one after it.
const ENTRIES: usize = 3 * RESOLUTION * RESOLUTION * RESOLUTION * 3;

/// Cells along each axis of a table of light.
const LIGHT_RESOLUTION: usize = 64;
/// Coefficients in such a table: by largest component, then the ratio of the component before it, then that of the one after it.
const LIGHT_ENTRIES: usize = 3 * LIGHT_RESOLUTION * LIGHT_RESOLUTION * 3;

/// A table of light as it lies in data/color/: 32-bit floats, little endian.
type LightTable = [[u8; 4]];

/// The table of colours of `space` whose largest component is a half.
fn light_table(space: ColorSpace) -> &'static LightTable {
    const SRGB: &LightTable = light_table_of(include_bytes!("../../../../data/color/uplift-light-srgb.bin"));
    const DCI_P3: &LightTable =
        light_table_of(include_bytes!("../../../../data/color/uplift-light-dci-p3.bin"));
    const REC2020: &LightTable =
        light_table_of(include_bytes!("../../../../data/color/uplift-light-rec2020.bin"));
    const ACES2065_1: &LightTable =
        light_table_of(include_bytes!("../../../../data/color/uplift-light-aces2065-1.bin"));
    match space {
        ColorSpace::Srgb => SRGB,
        ColorSpace::DciP3 => DCI_P3,
        ColorSpace::Rec2020 => REC2020,
        ColorSpace::Aces2065_1 => ACES2065_1,
    }
}

/// The table in `bytes`; a wrong length does not compile.
const fn light_table_of(bytes: &[u8]) -> &LightTable {
    let (table, rest) = bytes.as_chunks();
    assert!(table.len() == LIGHT_ENTRIES && rest.is_empty());
    table
}

/// A table as it lies in data/color/: 16-bit floats, little endian.
type Table = [[u8; 2]];

/// The table of `space`.
fn table(space: ColorSpace) -> &'static Table {
    const SRGB: &Table = table_of(include_bytes!("../../../../data/color/uplift-srgb.bin"));
    const DCI_P3: &Table = table_of(include_bytes!("../../../../data/color/uplift-dci-p3.bin"));
    const REC2020: &Table = table_of(include_bytes!("../../../../data/color/uplift-rec2020.bin"));
    const ACES2065_1: &Table = table_of(include_bytes!("../../../../data/color/uplift-aces2065-1.bin"));
    match space {
        ColorSpace::Srgb => SRGB,
        ColorSpace::DciP3 => DCI_P3,
        ColorSpace::Rec2020 => REC2020,
        ColorSpace::Aces2065_1 => ACES2065_1,
    }
}

/// The table in `bytes`; a wrong length does not compile.
const fn table_of(bytes: &[u8]) -> &Table {
    let (table, rest) = bytes.as_chunks();
    assert!(table.len() == ENTRIES && rest.is_empty());
    table
}

/// The function ½ + x / (2 √(1 + x²)) of a quadratic polynomial x in the wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sigmoid {
    /// Coefficients of t², t and 1, t going from −1 at 360 nm to 1 at 830 nm.
    coefficients: [f32; 3],
}

/// No coefficient is larger: a sigmoid is then a step already, and the square of its polynomial far below the largest number.
const STEEPEST: f64 = 1e6;

/// The coefficients of darker colours are those of one as bright as this: all below are black.
const DARKEST: f32 = 1e-9;

/// One half everywhere: what the sigmoid of a grey is, its value being a factor.
const HALF: Sigmoid = Sigmoid { coefficients: [0.0; 3] };

impl Sigmoid {
    /// The sigmoid of a colour whose components are in [0, 1] and not all the same.
    fn new(rgb: [f32; 3], space: ColorSpace) -> Self {
        let largest = largest(rgb);
        let brightness = rgb[largest];
        let ratio = |component: f32| Place::new((component / brightness).min(1.0));
        let (after, before) = (ratio(rgb[(largest + 1) % 3]), ratio(rgb[(largest + 2) % 3]));
        let level = Place::new(brightness);
        let table = table(space);
        let row = |level: usize, before: usize| {
            let first = ((largest * RESOLUTION + level) * RESOLUTION + before) * RESOLUTION + after.index;
            let cell = |at: usize| {
                let half = |i: usize| decode(table[3 * at + i]);
                Vec4::new(half(0), half(1), half(2), 0.0)
            };
            mix(cell(first), cell(first + 1), after.fraction)
        };
        let plane =
            |level: usize| mix(row(level, before.index), row(level, before.index + 1), before.fraction);
        let scaled = mix(plane(level.index), plane(level.index + 1), level.fraction);
        let [a, b, c, _] = (scaled / brightness.max(DARKEST).sqrt()).to_array();
        Self { coefficients: [a, b, c] }
    }

    /// The sigmoid of a colour over twice its largest component.
    fn of_half(rgb: [f32; 3], space: ColorSpace) -> Self {
        let largest = largest(rgb);
        let ratio = |component: f32| Place::even((component / rgb[largest]).min(1.0));
        let (after, before) = (ratio(rgb[(largest + 1) % 3]), ratio(rgb[(largest + 2) % 3]));
        let table = light_table(space);
        let row = |before: usize| {
            let first = (largest * LIGHT_RESOLUTION + before) * LIGHT_RESOLUTION + after.index;
            let cell = |at: usize| {
                let number = |i: usize| f32::from_le_bytes(table[3 * at + i]);
                Vec4::new(number(0), number(1), number(2), 0.0)
            };
            mix(cell(first), cell(first + 1), after.fraction)
        };
        let [a, b, c, _] = mix(row(before.index), row(before.index + 1), before.fraction).to_array();
        Self { coefficients: [a, b, c] }
    }

    /// The sigmoid near this one that has the colour `rgb` exactly; this one if there is none.
    fn refined(self, rgb: [f32; 3], space: ColorSpace) -> Self {
        const STEPS: usize = 8;
        const CLOSE: f64 = 1e-7;
        let goal = DVec3::from_array(rgb.map(f64::from));
        let mut at = DVec3::from_array(self.coefficients.map(f64::from));
        let mut best = (self, f64::INFINITY);
        for _ in 0..STEPS {
            let (color, slopes) = seen(at, space);
            let error = (color - goal).abs().max_element();
            // Newton's method doubles the digits or fails: on the way to a colour that no reflectance has without end.
            if error.is_nan() || error >= best.1 || at.abs().max_element() > STEEPEST {
                break;
            }
            best = (Self { coefficients: at.to_array().map(|x| x as f32) }, error);
            if error < CLOSE {
                break;
            }
            at -= slopes.inverse() * (color - goal);
        }
        best.0
    }

    /// The value at each wavelength of a path.
    #[inline]
    pub(crate) fn lanes(&self, hero: &HeroWavelengths) -> Vec4 {
        self.at(hero.normalized())
    }

    #[inline]
    fn at(&self, t: Vec4) -> Vec4 {
        let [a, b, c] = self.coefficients.map(Vec4::splat);
        let x = (a * t + b) * t + c;
        let root = (Vec4::ONE + x * x).map(f32::sqrt);
        (Vec4::ONE + x / root) * 0.5
    }
}

/// A multiple of a sigmoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Uplifted {
    sigmoid: Sigmoid,
    scale: f32,
}

impl Uplifted {
    /// A reflectance; components are limited to [0, 1].
    pub(crate) fn albedo(rgb: [f32; 3], space: ColorSpace) -> Self {
        let rgb = rgb.map(|x| x.clamp(0.0, 1.0));
        if is_grey(rgb) {
            return Self { sigmoid: HALF, scale: 2.0 * rgb[0] };
        }
        Self { sigmoid: Sigmoid::new(rgb, space), scale: 1.0 }
    }

    /// Any other quantity; components below zero count as zero.
    pub(crate) fn unbounded(rgb: [f32; 3], space: ColorSpace) -> Self {
        let rgb = rgb.map(|x| x.clamp(0.0, 0.5 * f32::MAX));
        let scale = 2.0 * rgb[largest(rgb)];
        if is_grey(rgb) {
            return Self { sigmoid: HALF, scale };
        }
        // Half of the brightest value leaves the sigmoid room on both sides.
        Self { sigmoid: Sigmoid::of_half(rgb, space), scale }
    }

    /// [`Uplifted::albedo`] of a colour that is met exactly.
    pub(crate) fn exact_albedo(rgb: [f32; 3], space: ColorSpace) -> Self {
        Self::albedo(rgb, space).refined(rgb.map(|x| x.clamp(0.0, 1.0)), space)
    }

    /// [`Uplifted::unbounded`] of a colour that is met exactly.
    pub(crate) fn exact_unbounded(rgb: [f32; 3], space: ColorSpace) -> Self {
        Self::unbounded(rgb, space).refined(rgb.map(|x| x.clamp(0.0, 0.5 * f32::MAX)), space)
    }

    fn refined(self, rgb: [f32; 3], space: ColorSpace) -> Self {
        // Greys are exact, and black has no scale.
        if is_grey(rgb) {
            return self;
        }
        Self { sigmoid: self.sigmoid.refined(rgb.map(|x| x / self.scale), space), ..self }
    }

    /// The value at each wavelength of a path.
    #[inline]
    pub(crate) fn lanes(&self, hero: &HeroWavelengths) -> Vec4 {
        self.sigmoid.lanes(hero) * self.scale
    }
}

/// Light of a colour: an unbounded quantity times the white of the colour's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UpliftedLight {
    color: Uplifted,
    white: &'static DenseSpectrum,
}

impl UpliftedLight {
    /// Light; components below zero count as zero.
    pub(crate) fn new(rgb: [f32; 3], space: ColorSpace) -> Self {
        Self { color: Uplifted::unbounded(rgb, space), white: cie::white(space) }
    }

    /// The value at each wavelength of a path.
    #[inline]
    pub(crate) fn lanes(&self, hero: &HeroWavelengths) -> Vec4 {
        self.color.lanes(hero) * self.white.lanes(hero)
    }
}

/// A place between the cells of an axis: the one before it, never the last, and how far it is to the next.
#[derive(Clone, Copy)]
struct Place {
    index: usize,
    fraction: f32,
}

impl Place {
    /// The place of a value in [0, 1] on an axis whose cells are quadratic toward both ends.
    #[inline]
    fn new(value: f32) -> Self {
        let u = if value < 0.5 { (0.5 * value).sqrt() } else { 1.0 - (0.5 * (1.0 - value)).sqrt() };
        let at = u * (RESOLUTION - 1) as f32;
        let index = (at as usize).min(RESOLUTION - 2);
        Self { index, fraction: at - index as f32 }
    }

    /// The place of a value in [0, 1] on an axis of a table of light, whose cells are even.
    #[inline]
    fn even(value: f32) -> Self {
        let at = value * (LIGHT_RESOLUTION - 1) as f32;
        let index = (at as usize).min(LIGHT_RESOLUTION - 2);
        Self { index, fraction: at - index as f32 }
    }
}

/// The colour of the sigmoid with the given coefficients under the white of `space`, white being (1, 1, 1), and its derivatives
/// by them.
fn seen(coefficients: DVec3, space: ColorSpace) -> (DVec3, DMat3) {
    let (observer, white) = (cie::observer(), cie::white(space));
    // XYZ of the sigmoid, of its derivative by each coefficient, and of the white.
    let mut sums = [DVec3::ZERO; 5];
    for i in 0..WAVELENGTHS {
        let nm = RANGE[0] + i as f32;
        let t = f64::from((nm - 0.5 * (RANGE[0] + RANGE[1])) / (0.5 * (RANGE[1] - RANGE[0])));
        let powers = DVec3::new(t * t, t, 1.0);
        let x = coefficients.dot(powers);
        let root = 1.0 / (1.0 + x * x).sqrt();
        let (value, slope) = (0.5 + 0.5 * x * root, 0.5 * root * root * root);
        let response = (observer.at(nm) * white.at(nm)).truncate().as_dvec3();
        for (sum, factor) in sums.iter_mut().zip([value, slope * powers.x, slope * powers.y, slope, 1.0]) {
            *sum += response * factor;
        }
    }
    let matrix = DMat3::from_cols_array_2d(&space.xyz_to_rgb_matrix()).transpose();
    let [value, a, b, c, white] = sums.map(|xyz| matrix * xyz);
    (value / white, DMat3::from_cols(a / white, b / white, c / white))
}

/// The index of the largest component.
#[inline]
fn largest(rgb: [f32; 3]) -> usize {
    if rgb[0] > rgb[1] {
        if rgb[0] > rgb[2] { 0 } else { 2 }
    } else if rgb[1] > rgb[2] {
        1
    } else {
        2
    }
}

#[inline]
fn is_grey(rgb: [f32; 3]) -> bool {
    rgb[0] == rgb[1] && rgb[1] == rgb[2]
}

#[inline]
fn mix(a: Vec4, b: Vec4, fraction: f32) -> Vec4 {
    a + (b - a) * fraction
}

/// The value of a 16-bit float that is zero or normal, as the tables have them.
#[inline]
fn decode(bytes: [u8; 2]) -> f32 {
    let half = u32::from(u16::from_le_bytes(bytes));
    // The exponent moves into place, and the product corrects its bias.
    const BIAS: f32 = f32::from_bits((127 + 112) << 23);
    f32::from_bits((half & 0x8000) << 16 | (half & 0x7fff) << 13) * BIAS
}

#[cfg(test)]
mod tests {
    use sahl_testkit::random::Rng;

    use super::*;

    /// The colour of a quantity under the white of its space.
    fn color(uplifted: &Uplifted, space: ColorSpace) -> [f32; 3] {
        let white = cie::white(space);
        let value = |nm: f32| {
            let t = (nm - 0.5 * (RANGE[0] + RANGE[1])) / (0.5 * (RANGE[1] - RANGE[0]));
            uplifted.sigmoid.at(Vec4::splat(t)).x * uplifted.scale
        };
        let seen = space.xyz_to_rgb(cie::xyz(|nm| white.at(nm) * value(nm)));
        let white = space.xyz_to_rgb(cie::xyz(|nm| white.at(nm)));
        std::array::from_fn(|i| seen[i] / white[i])
    }

    /// The largest and the mean difference of a component over `count` colours that `next` draws.
    fn errors(space: ColorSpace, count: u32, mut next: impl FnMut() -> [f32; 3]) -> (f32, f32) {
        let (mut worst, mut sum) = (0.0_f32, 0.0);
        for _ in 0..count {
            let rgb = next();
            let found = color(&Uplifted::albedo(rgb, space), space);
            let error = (0..3).map(|i| (found[i] - rgb[i]).abs()).fold(0.0, f32::max);
            worst = worst.max(error);
            sum += error;
        }
        (worst, sum / count as f32)
    }

    #[test]
    fn colours_survive_the_way_through_spectra() {
        let mut rng = Rng::new(0x5eed);
        let srgb = ColorSpace::Srgb;
        let (worst, mean) = errors(srgb, 2000, || std::array::from_fn(|_| rng.next_f32()));
        assert!(worst < 2.5e-3 && mean < 6e-4, "{worst} {mean}");
        let (worst, mean) = errors(srgb, 1000, || std::array::from_fn(|_| 0.05 * rng.next_f32()));
        assert!(worst < 4e-4 && mean < 8e-5, "dark: {worst} {mean}");
        let mut face = 0;
        let (worst, mean) = errors(srgb, 1000, || {
            face += 1;
            let mut rgb = std::array::from_fn(|_| rng.next_f32());
            rgb[face % 3] = (face / 3 % 2) as f32;
            rgb
        });
        assert!(worst < 4e-3 && mean < 6e-4, "border: {worst} {mean}");
        // The widest spaces hold colours that no reflectance has: what lies well inside is met in all.
        for space in ColorSpace::ALL {
            let (worst, mean) = errors(space, 500, || std::array::from_fn(|_| 0.3 + 0.4 * rng.next_f32()));
            assert!(worst < 4e-3 && mean < 1e-3, "{space:?}: {worst} {mean}");
        }
    }

    #[test]
    fn colours_that_no_reflectance_has_are_no_further_off_than_the_table_has_them() {
        let levels = [0.0, 0.02, 0.05, 0.1, 0.3, 0.5, 0.8, 0.9, 1.0_f32];
        for place in 0..levels.len().pow(3) {
            let rgb =
                [place, place / levels.len(), place / levels.len().pow(2)].map(|i| levels[i % levels.len()]);
            for space in ColorSpace::ALL {
                let off = |uplifted: &Uplifted| {
                    let found = color(uplifted, space);
                    (0..3).map(|i| (found[i] - rgb[i]).abs()).fold(0.0, f32::max)
                };
                let by_table = off(&Uplifted::albedo(rgb, space));
                let exact = off(&Uplifted::exact_albedo(rgb, space));
                assert!(exact <= by_table + 1e-5, "{rgb:?} in {space:?}: {exact}, by the table {by_table}");
            }
        }
        let dark = Uplifted::albedo([1e-38, 0.0, 0.0], ColorSpace::Srgb);
        assert!(dark.lanes(&HeroWavelengths::sample(0.5)).max_element() < 1e-8);
    }

    #[test]
    fn what_is_given_once_is_met_exactly() {
        let mut rng = Rng::new(0xe4ac);
        for i in 0..200 {
            let rgb = std::array::from_fn(|_| 0.05 + 0.9 * rng.next_f32());
            // The widest space holds colours that no reflectance has.
            let space = if i % 2 == 0 { ColorSpace::Srgb } else { ColorSpace::DciP3 };
            let found = color(&Uplifted::exact_albedo(rgb, space), space);
            let other = color(&Uplifted::exact_unbounded(rgb.map(|x| 40.0 * x), space), space);
            for lane in 0..3 {
                assert!((found[lane] - rgb[lane]).abs() < 2e-6, "{rgb:?}: {found:?}");
                assert!((other[lane] / 40.0 - rgb[lane]).abs() < 2e-6, "{rgb:?}: {other:?}");
            }
        }
        // Black and saturated colours stay what the table has.
        assert_eq!(Uplifted::exact_unbounded([0.0; 3], ColorSpace::Srgb).scale, 0.0);
        let pure = Uplifted::exact_unbounded([0.0, 1.0, 0.0], ColorSpace::Rec2020);
        assert!(pure.lanes(&HeroWavelengths::sample(0.5)).is_finite());
    }

    #[test]
    fn light_is_met_more_closely_than_reflectances() {
        let mut rng = Rng::new(0x11647);
        for space in [ColorSpace::Srgb, ColorSpace::DciP3, ColorSpace::Rec2020] {
            let (mut worst, mut sum) = (0.0_f32, 0.0);
            for _ in 0..500 {
                let rgb = std::array::from_fn(|_| 0.2 + 0.8 * rng.next_f32());
                let found = color(&UpliftedLight::new(rgb, space).color, space);
                let error = (0..3).map(|i| (found[i] - rgb[i]).abs()).fold(0.0, f32::max);
                (worst, sum) = (worst.max(error), sum + error);
            }
            assert!(worst < 1.5e-3 && sum / 500.0 < 6e-4, "{space:?} {worst} {}", sum / 500.0);
        }
        // A blue sky in the space in which skies are measured; its table is that of another white (`xtask/src/uplift/plane`).
        let (space, sky) = (ColorSpace::Aces2065_1, [0.08, 0.085, 0.13]);
        let found = color(&UpliftedLight::new(sky, space).color, space);
        assert!((0..3).all(|i| (found[i] / sky[i] - 1.0).abs() < 2e-3), "{found:?}");
    }

    #[test]
    fn greys_are_flat_and_exact() {
        let hero = HeroWavelengths::sample(0.37);
        for value in [0.0, 1e-6, 0.18, 0.5, 1.0] {
            for space in ColorSpace::ALL {
                assert_eq!(Uplifted::albedo([value; 3], space).lanes(&hero), Vec4::splat(value));
                assert_eq!(
                    Uplifted::unbounded([7.0 * value; 3], space).lanes(&hero),
                    Vec4::splat(7.0 * value)
                );
            }
        }
    }

    #[test]
    fn reflectances_stay_between_zero_and_one() {
        let mut rng = Rng::new(1);
        for i in 0..20_000 {
            let hero = HeroWavelengths::sample(rng.next_f32());
            let rgb =
                std::array::from_fn(|_| (1.2 * rng.next_f32() - 0.1) * if i % 3 == 0 { 0.01 } else { 1.0 });
            for space in ColorSpace::ALL {
                let lanes = Uplifted::albedo(rgb, space).lanes(&hero);
                assert!(lanes.min_element() >= 0.0 && lanes.max_element() <= 1.0, "{rgb:?} {lanes}");
            }
        }
    }

    #[test]
    fn quantities_scale_with_their_colour() {
        let hero = HeroWavelengths::sample(0.8);
        let once = UpliftedLight::new([0.2, 0.7, 0.1], ColorSpace::Srgb).lanes(&hero);
        let often = UpliftedLight::new([200.0, 700.0, 100.0], ColorSpace::Srgb).lanes(&hero);
        assert!((often / once - Vec4::splat(1000.0)).abs().max_element() < 0.1);
        let huge = Uplifted::unbounded([f32::MAX, 1.0, f32::INFINITY], ColorSpace::Srgb).lanes(&hero);
        assert!(huge.is_finite(), "{huge}");
    }

    #[test]
    fn light_of_a_colour_has_its_luminance() {
        let rgb = [3.0, 5.0, 0.5];
        let light = UpliftedLight::new(rgb, ColorSpace::Srgb);
        let seen = color(&light.color, ColorSpace::Srgb);
        for i in 0..3 {
            assert!((seen[i] - rgb[i]).abs() < 0.02, "{seen:?}");
        }
    }
}
