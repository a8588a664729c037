//! The film on the base of [`super::OpenPbr`]: so thin that the light which its two faces reflect interferes.
//!
//! Design decision: Airy's sum over all orders is evaluated as it is. Four wavelengths have a phase each. In RGB mode a lane is a band of
//! wavelengths: the sum is taken at wave numbers a constant step apart, whose phases follow from each other by rotation, and averaged by
//! what the colour sees in daylight. So no lane reflects more than it gets, at any order, and both modes show the same colours where sRGB has them. Belcour
//! and Barla sum the first orders by fits of the Fourier transforms of the observer instead, which is made for fewer operations.
//!
//! Source: Born, Wolf, *Principles of Optics*, 7th ed., 1999, sections 1.6 and 14.4; Belcour, Barla, *A Practical Extension to
//! Microfacet Theory for the Modeling of Varying Iridescence*, SIGGRAPH 2017; Gulbrandsen, *Artist Friendly Metallic Fresnel*, JCGT
//! 3(4), 2014. Deviation from OpenPBR: the film lies in empty space, also where a coat covers it.

use std::f32::consts::TAU;
use std::sync::LazyLock;

use sahl_image::ColorSpace;
use sahl_math::safe_sqrt;

use crate::spectrum::cie;
use crate::spectrum::{Spectrum, Wavelengths};

/// Wave numbers that stand for all visible ones.
const NODES: usize = 48;
/// The first and the last, per micrometre: at 710 nm and at 390 nm. What lies outside counts to these.
const NODE_RANGE: [f32; 2] = [1000.0 / 710.0, 1000.0 / 390.0];
/// Differences of ways, in micrometres, beyond which the bands of RGB are too wide for fringes: there less than a thousandth of them is left.
const LONGEST_FRINGE: f32 = 10.0;
/// The most that is reflected by a metal with a finite index, as in [`fresnel::absorption_of_reflectance`](crate::bsdf::fresnel).
const MOST_REFLECTANCE: f32 = 0.9999;

/// A film that covers a share of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThinFilm {
    weight: f32,
    /// In micrometres.
    thickness: f32,
    /// Its index over that of what is outside; at least one.
    eta: f32,
    waves: Waves,
}

/// What the lanes of a path are to waves.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Waves {
    /// Bands of colour.
    Bands(&'static [Spectrum; NODES]),
    /// Single lines, by waves per micrometre.
    Lines([f32; 4]),
}

/// What lies below a film: its index η + i k over that of what is outside, lane by lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Substrate {
    eta: Spectrum,
    k: Spectrum,
}

/// The amplitudes that both faces of a film reflect, for one polarisation.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Faces {
    top: f32,
    /// Real and imaginary part.
    bottom: [f32; 2],
}

impl Substrate {
    /// Glass or what is below a varnish.
    pub(super) fn dielectric(eta: f32) -> Self {
        Self { eta: Spectrum::splat(eta), k: Spectrum::ZERO }
    }

    /// A metal that reflects `normal` at normal incidence, and near the edge about what Schlick's formula gives, times `edge`.
    ///
    /// By Gulbrandsen's parametrisation, with the tint in the place of his edge tint: his one is the metal without the dip before the
    /// edge that Schlick's formula leaves out, his zero has the deepest.
    pub(super) fn metal(normal: Spectrum, edge: Spectrum) -> Self {
        let index = normal.zip(edge, |r, edge| {
            let (r, edge) = (r.clamp(0.0, MOST_REFLECTANCE), edge.clamp(0.0, 1.0));
            let (least, most) = ((1.0 - r) / (1.0 + r), (1.0 + r.sqrt()) / (1.0 - r.sqrt()));
            most + (least - most) * edge
        });
        let k = normal.zip(index, |r, n| {
            let r = r.clamp(0.0, MOST_REFLECTANCE);
            safe_sqrt((r * (n + 1.0) * (n + 1.0) - (n - 1.0) * (n - 1.0)) / (1.0 - r))
        });
        Self { eta: index, k }
    }

    /// Whether all lanes are the same.
    fn is_grey(&self) -> bool {
        [self.eta, self.k].into_iter().all(|x| x.max_component() == x.min_component())
    }
}

impl Faces {
    /// For both polarisations: perpendicular and parallel to the plane of incidence. `cos` and `cos_film` are those of the ray outside and in
    /// the film, whose index is `film`; `below` is the index beneath.
    fn new((cos, cos_film): (f32, f32), film: f32, below: [f32; 2]) -> [Self; 2] {
        let [n, k] = below;
        // n₃² and n₃ cos θ₃.
        let square = [n * n - k * k, 2.0 * n * k];
        let q = square_root([square[0] - (1.0 - cos * cos), square[1]]);
        let perpendicular = Self {
            top: (cos - film * cos_film) / (cos + film * cos_film),
            bottom: difference_over_sum([film * cos_film, 0.0], q),
        };
        let parallel = Self {
            top: (film * cos - cos_film) / (film * cos + cos_film),
            bottom: difference_over_sum(square.map(|x| x * cos_film), q.map(|x| x * film)),
        };
        [perpendicular, parallel]
    }

    /// The share of light that both faces reflect together, given the cosine and the sine of the phase between them; rounding may take it a
    /// little out of [0, 1].
    #[inline]
    fn reflectance(&self, [cos, sin]: [f32; 2]) -> f32 {
        let [re, im] = self.bottom;
        let (top2, bottom2) = (self.top * self.top, re * re + im * im);
        let mixed = 2.0 * self.top * (re * cos - im * sin);
        let passed = 1.0 + top2 * bottom2 + mixed;
        if passed > 0.0 { (top2 + bottom2 + mixed) / passed } else { 1.0 }
    }

    /// Its mean over all phases.
    fn mean(&self) -> f32 {
        let [re, im] = self.bottom;
        let (top2, bottom2) = (self.top * self.top, re * re + im * im);
        let caught = 1.0 - top2 * bottom2;
        if caught > 0.0 { (1.0 - (1.0 - top2) * (1.0 - bottom2) / caught).clamp(0.0, 1.0) } else { 1.0 }
    }
}

impl ThinFilm {
    /// A film over `weight` of a surface, `thickness` micrometres thick, of the index `eta` ≥ 1; `None` if it changes nothing.
    pub(super) fn new(weight: f32, thickness: f32, eta: f32, wavelengths: &Wavelengths) -> Option<Self> {
        let is_there = weight > 0.0 && thickness > 0.0 && thickness.is_finite() && eta > 1.0;
        is_there.then(|| {
            let waves = match wavelengths {
                Wavelengths::Rgb => Waves::Bands(bands()),
                Wavelengths::Sampled(hero) => Waves::Lines(hero.lambda().map(|lambda| 1000.0 / lambda)),
            };
            Self { weight, thickness, eta, waves }
        })
    }

    /// The reflectance of a surface of which `below` is what the film covers, and `bare` the reflectance of what it does not. `cos` is that of
    /// the ray outside.
    #[inline(never)]
    pub(super) fn over(&self, bare: Spectrum, cos: f32, below: &Substrate) -> Spectrum {
        bare + (self.reflectance(cos, below) - bare) * self.weight
    }

    /// The reflectance under the film.
    fn reflectance(&self, cos: f32, below: &Substrate) -> Spectrum {
        let cos = cos.clamp(0.0, 1.0);
        if cos == 0.0 {
            return Spectrum::ONE;
        }
        let eta2 = self.eta * self.eta;
        // In this form it is the cosine outside, to the last bit, where the film has no index of its own.
        let cos_film = ((eta2 - 1.0 + cos * cos) / eta2).sqrt();
        let (etas, ks) = (below.eta.lanes(), below.k.lanes());
        let faces = |lane: usize| Faces::new((cos, cos_film), self.eta, [etas[lane], ks[lane]]);
        let longer = 2.0 * self.thickness * self.eta * cos_film;
        match self.waves {
            Waves::Lines(waves) => Spectrum::from_lanes(std::array::from_fn(|lane| {
                let phase = phase(longer * waves[lane]);
                mean_of(faces(lane), |faces| faces.reflectance(phase)).clamp(0.0, 1.0)
            })),
            Waves::Bands(_) if longer > LONGEST_FRINGE => {
                Spectrum::from_rgb([0, 1, 2].map(|lane| mean_of(faces(lane), Faces::mean)))
            }
            Waves::Bands(weights) if below.is_grey() => {
                let faces = faces(0);
                over_bands(weights, longer, |phase| {
                    Spectrum::splat(mean_of(faces, |faces| faces.reflectance(phase)))
                })
            }
            Waves::Bands(weights) => {
                let lanes = [0, 1, 2].map(faces);
                over_bands(weights, longer, |phase| {
                    Spectrum::from_rgb(lanes.map(|faces| mean_of(faces, |faces| faces.reflectance(phase))))
                })
            }
        }
    }
}

/// The mean over both polarisations.
#[inline]
fn mean_of(faces: [Faces; 2], value: impl Fn(&Faces) -> f32) -> f32 {
    0.5 * (value(&faces[0]) + value(&faces[1]))
}

/// Cosine and sine of so many turns.
#[inline]
fn phase(turns: f32) -> [f32; 2] {
    let (sin, cos) = (TAU * turns.fract()).sin_cos();
    [cos, sin]
}

/// What the bands see of `value`, a function of the phase, for ways that differ by `longer` micrometres.
fn over_bands(weights: &[Spectrum; NODES], longer: f32, value: impl Fn([f32; 2]) -> Spectrum) -> Spectrum {
    let [first, last] = NODE_RANGE;
    let [step_cos, step_sin] = phase(longer * (last - first) / (NODES - 1) as f32);
    let [mut cos, mut sin] = phase(longer * first);
    let mut sum = Spectrum::ZERO;
    for &weight in weights {
        sum += weight * value([cos, sin]);
        [cos, sin] = [cos * step_cos - sin * step_sin, sin * step_cos + cos * step_sin];
    }
    sum.clamp(0.0, 1.0)
}

/// How much each wave number counts in each lane of RGB mode: what the primaries of sRGB see in daylight, negative parts included.
fn bands() -> &'static [Spectrum; NODES] {
    static BANDS: LazyLock<[Spectrum; NODES]> = LazyLock::new(|| {
        let (observer, daylight) = (cie::observer(), cie::white(ColorSpace::Srgb));
        let [first, last] = NODE_RANGE;
        let mut bands = [[0.0_f32; 3]; NODES];
        for lambda in 360..=830 {
            let lambda = lambda as f32;
            let [x, y, z, _] = (observer.at(lambda) * daylight.at(lambda)).to_array();
            let seen = ColorSpace::Srgb.xyz_to_rgb([x, y, z]);
            let place = (1000.0 / lambda - first) / (last - first) * (NODES - 1) as f32;
            let place = place.clamp(0.0, (NODES - 1) as f32);
            let node = (place as usize).min(NODES - 2);
            let after = place - node as f32;
            for channel in 0..3 {
                bands[node][channel] += seen[channel] * (1.0 - after);
                bands[node + 1][channel] += seen[channel] * after;
            }
        }
        let total = [0, 1, 2].map(|channel| bands.iter().map(|band| band[channel]).sum::<f32>());
        bands.map(|band| Spectrum::from_rgb(std::array::from_fn(|channel| band[channel] / total[channel])))
    });
    &BANDS
}

/// (u − v) / (u + v) of complex numbers.
#[inline]
fn difference_over_sum(u: [f32; 2], v: [f32; 2]) -> [f32; 2] {
    let sum = [u[0] + v[0], u[1] + v[1]];
    let scale = 1.0 / (sum[0] * sum[0] + sum[1] * sum[1]);
    let real = u[0] * u[0] + u[1] * u[1] - v[0] * v[0] - v[1] * v[1];
    [real * scale, 2.0 * (u[1] * v[0] - u[0] * v[1]) * scale]
}

/// The square root of a complex number whose imaginary part is not negative, in the first quadrant.
#[inline]
fn square_root([re, im]: [f32; 2]) -> [f32; 2] {
    let length = re.hypot(im);
    [safe_sqrt(0.5 * (length + re)), safe_sqrt(0.5 * (length - re))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::fresnel;
    use crate::spectrum::HeroWavelengths;

    fn spectral() -> (Wavelengths, [f32; 4]) {
        let hero = HeroWavelengths::sample(0.3);
        (Wavelengths::Sampled(hero), hero.lambda())
    }

    /// Also one that would change nothing.
    fn film(thickness: f32, eta: f32, wavelengths: &Wavelengths) -> ThinFilm {
        let film = ThinFilm::new(1.0, 1.0, 2.0, wavelengths).unwrap();
        ThinFilm { thickness, eta, ..film }
    }

    #[test]
    fn what_changes_nothing_is_no_film() {
        for (weight, thickness, eta) in
            [(0.0, 0.5, 1.4), (1.0, 0.0, 1.4), (1.0, 0.5, 1.0), (1.0, f32::NAN, 1.4)]
        {
            assert_eq!(ThinFilm::new(weight, thickness, eta, &Wavelengths::Rgb), None);
        }
        assert!(ThinFilm::new(0.5, 0.1, 1.1, &Wavelengths::Rgb).is_some());
    }

    fn cosines() -> impl Iterator<Item = f32> {
        (0..=40).map(|i| i as f32 / 40.0)
    }

    #[test]
    fn a_film_without_thickness_is_not_there() {
        let metal =
            Substrate { eta: Spectrum::from_rgb([0.2, 0.9, 1.4]), k: Spectrum::from_rgb([3.5, 2.4, 1.8]) };
        for wavelengths in [Wavelengths::Rgb, spectral().0] {
            for cos in cosines() {
                let bare = fresnel::dielectric(cos, 1.5).reflectance;
                let filmed = film(0.0, 1.8, &wavelengths).reflectance(cos, &Substrate::dielectric(1.5));
                assert!((filmed.max_component() - bare).abs() < 2e-5, "{cos}: {filmed:?} {bare}");
                let bare = fresnel::conductor(cos, metal.eta, metal.k);
                let filmed = film(0.0, 1.8, &wavelengths).reflectance(cos, &metal);
                let difference = (filmed - bare).map(f32::abs).max_component();
                assert!(difference < 1e-4, "{cos}: {filmed:?} {bare:?}");
            }
        }
    }

    #[test]
    fn a_quarter_wave_of_the_middle_index_reflects_nothing() {
        let (wavelengths, lambda) = spectral();
        for (lane, lambda) in lambda.into_iter().enumerate() {
            let eta = 1.5_f32.sqrt();
            let quarter = film(lambda / 4000.0 / eta, eta, &wavelengths);
            assert!(quarter.reflectance(1.0, &Substrate::dielectric(1.5)).lanes()[lane] < 1e-6);
            // A half wave is as good as none.
            let half = film(lambda / 2000.0 / eta, eta, &wavelengths);
            let bare = fresnel::dielectric(1.0, 1.5).reflectance;
            assert!((half.reflectance(1.0, &Substrate::dielectric(1.5)).lanes()[lane] - bare).abs() < 1e-5);
        }
    }

    #[test]
    fn bands_see_what_wavelengths_show() {
        // The mean over many sets of four wavelengths, seen by the observer in daylight.
        let observer = cie::observer();
        let daylight = cie::white(ColorSpace::Srgb);
        let metal = Substrate::metal(Spectrum::splat(0.9), Spectrum::splat(1.0));
        for (thickness, below) in
            [(0.1, metal), (0.3, metal), (0.5, Substrate::dielectric(1.5)), (1.2, metal)]
        {
            for cos in [1.0, 0.5] {
                let shown = |nm: f32| {
                    let line = ThinFilm {
                        waves: Waves::Lines([1000.0 / nm; 4]),
                        ..film(thickness, 1.4, &Wavelengths::Rgb)
                    };
                    line.reflectance(cos, &below).lanes()[0] * daylight.at(nm)
                };
                let expected = ColorSpace::Srgb.xyz_to_rgb(observer.xyz(shown)).map(|x| x.clamp(0.0, 1.0));
                let found = film(thickness, 1.4, &Wavelengths::Rgb).reflectance(cos, &below).to_rgb();
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 0.01, "{thickness} {cos}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn thick_films_lose_their_fringes_in_bands() {
        let below = Substrate::metal(Spectrum::from_rgb([0.9, 0.6, 0.3]), Spectrum::splat(0.7));
        let (before, after) = (film(3.5, 1.4, &Wavelengths::Rgb), film(3.6, 1.4, &Wavelengths::Rgb));
        let difference = (before.reflectance(1.0, &below) - after.reflectance(1.0, &below)).map(f32::abs);
        assert!(difference.max_component() < 2e-3, "{difference:?}");
    }

    #[test]
    fn a_metal_reflects_its_colour() {
        let (normal, edge) = (Spectrum::from_rgb([0.95, 0.6, 0.02]), Spectrum::from_rgb([1.0, 0.5, 0.0]));
        let metal = Substrate::metal(normal, edge);
        let difference = (fresnel::conductor(1.0, metal.eta, metal.k) - normal).map(f32::abs);
        assert!(difference.max_component() < 1e-4, "{metal:?} {difference:?}");
    }

    #[test]
    fn two_faces_reflect_no_more_than_they_get() {
        for below in [[1.5, 0.0], [1.0, 0.0], [2.4, 0.0], [0.2, 3.5], [5e-5, 1.0]] {
            for eta in [1.001_f32, 1.33, 2.5] {
                for cos in cosines().skip(1).chain([1e-6]) {
                    let cos_film = ((eta * eta - 1.0 + cos * cos) / (eta * eta)).sqrt();
                    for faces in Faces::new((cos, cos_film), eta, below) {
                        for turn in 0..64 {
                            let r = faces.reflectance(phase(turn as f32 / 64.0));
                            assert!((-1e-5..=1.0 + 1e-5).contains(&r), "{below:?} {eta} {cos} {turn}: {r}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn no_film_reflects_more_than_it_gets() {
        for below in [
            Substrate::dielectric(1.5),
            Substrate::dielectric(1.0),
            Substrate::metal(Spectrum::ONE, Spectrum::ONE),
        ] {
            for wavelengths in [Wavelengths::Rgb, spectral().0] {
                for (thickness, eta) in [(0.05, 1.0), (0.4, 1.33), (0.9, 2.5), (50.0, 1.4)] {
                    for cos in cosines().chain([1e-30, 1e-6]) {
                        let r = film(thickness, eta, &wavelengths).reflectance(cos, &below);
                        let in_range = r.lanes().iter().all(|x| (0.0..=1.0).contains(x));
                        assert!(in_range, "{thickness} {eta} {cos}: {r:?}");
                    }
                }
            }
        }
    }
}
