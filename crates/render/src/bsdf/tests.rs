//! What holds exactly; the distributions are tested by the statistical tests of the crate.

use std::f32::consts::{FRAC_PI_2, PI};

use super::*;

fn direction(theta: f32, phi: f32) -> Vec3 {
    Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
}

fn every_kind() -> [Bsdf<'static>; 7] {
    let (silver, alpha) = ([Spectrum::splat(0.05), Spectrum::splat(3.5)], [0.3, 0.2]);
    [
        Diffuse::new(Spectrum::splat(0.5)).into(),
        Conductor::new(silver[0], silver[1], [0.0; 2]).into(),
        Conductor::new(silver[0], silver[1], alpha).into(),
        Dielectric::new(1.5, [0.0; 2]).into(),
        Dielectric::new(1.5, alpha).into(),
        ThinDielectric::new(1.5).into(),
        DiffuseTransmission::new(Spectrum::splat(0.3), Spectrum::splat(0.6)).into(),
    ]
}

#[test]
fn a_bsdf_is_small() {
    assert!(size_of::<Bsdf<'_>>() <= 64, "{}", size_of::<Bsdf<'_>>());
}

#[test]
fn directions_in_the_surface_scatter_nothing() {
    let (in_surface, up) = (Vec3::X, direction(0.5, 1.0));
    for bsdf in every_kind() {
        assert_eq!(bsdf.sample(in_surface, 0.5, Vec2::splat(0.3)), None, "{bsdf:?}");
        for (wo, wi) in [(in_surface, up), (up, in_surface), (in_surface, in_surface)] {
            assert!(bsdf.eval(wo, wi).is_zero() && bsdf.pdf(wo, wi) == 0.0, "{bsdf:?}");
        }
    }
}

#[test]
fn extreme_numbers_give_finite_samples() {
    let below_one = 1.0 - f32::EPSILON / 2.0;
    let grazing = [
        direction(FRAC_PI_2 - 1e-5, 0.3),
        direction(FRAC_PI_2 + 1e-5, 2.0),
        Vec3::new(1.0, 0.0, 1e-30),
        Vec3::Z,
        -Vec3::Z,
    ];
    let alphas =
        [[0.0, 0.0], [1e-3, 1e-3], [1e-5, 1.0], [1.0, 1.0], [50.0, 50.0], [f32::NAN, 0.1], [-1.0, -1.0]];
    for alpha in alphas {
        let metal = Conductor::new(Spectrum::splat(0.05), Spectrum::splat(3.5), alpha);
        let bsdfs: [Bsdf<'_>; 3] =
            [metal.into(), Dielectric::new(1.5, alpha).into(), Dielectric::new(1.000_1, alpha).into()];
        for bsdf in bsdfs {
            for wo in grazing {
                for u in [0.0, 0.25, 0.5, 0.999, below_one] {
                    for v in [0.0, 0.5, below_one] {
                        let Some(sample) = bsdf.sample(wo, v, Vec2::new(v, u)) else { continue };
                        let usable = sample.pdf > 0.0 && sample.pdf.is_finite() && sample.weight.is_finite();
                        assert!(usable && sample.wi.is_finite(), "{bsdf:?} {wo:?} {u} {v}: {sample:?}");
                        let value = bsdf.eval(wo, sample.wi);
                        assert!(
                            value.is_finite() && value.min_component() >= 0.0,
                            "{bsdf:?} {wo:?} {sample:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_mirror_mirrors_on_both_sides() {
    let mirror: Bsdf<'_> = Conductor::new(Spectrum::splat(0.05), Spectrum::splat(3.5), [0.0; 2]).into();
    assert!(mirror.is_specular());
    for theta in [0.3, 2.8] {
        let wo = direction(theta, 0.7);
        let sample = mirror.sample(wo, 0.1, Vec2::splat(0.5)).unwrap();
        assert_eq!(sample.wi, Vec3::new(-wo.x, -wo.y, wo.z));
        assert_eq!(sample.kind, ScatterKind::SPECULAR_REFLECTION);
        assert_eq!(sample.weight, mirror.albedo(wo));
    }
}

#[test]
fn refraction_obeys_snell_on_both_sides() {
    let glass: Bsdf<'_> = Dielectric::new(1.5, [0.0; 2]).into();
    for (theta, eta) in [(0.9, 1.5), (PI - 0.4, 1.0 / 1.5)] {
        let wo = direction(theta, 0.7);
        let sample = glass.sample(wo, 0.999, Vec2::ZERO).unwrap();
        assert_eq!(sample.kind, ScatterKind::SPECULAR_TRANSMISSION);
        assert!((sample.eta - eta).abs() < 1e-6 && sample.wi.z * wo.z < 0.0);
        assert!((Vec2::new(sample.wi.x, sample.wi.y) * eta + Vec2::new(wo.x, wo.y)).length() < 1e-6);
        assert!((sample.wi.length() - 1.0).abs() < 1e-6);
        assert!((sample.weight.max_component() * eta * eta - 1.0).abs() < 1e-6);
    }
    // Beyond the critical angle from inside nothing gets out.
    let inside = direction(PI - 1.2, 0.0);
    let sample = glass.sample(inside, 0.999, Vec2::ZERO).unwrap();
    assert_eq!((sample.kind, sample.pdf), (ScatterKind::SPECULAR_REFLECTION, 1.0));
}

#[test]
fn matter_like_its_surroundings_is_invisible() {
    for eta in [1.0, 0.0, -2.0, f32::NAN, f32::INFINITY] {
        let air: Bsdf<'_> = Dielectric::new(eta, [0.5; 2]).into();
        assert!(air.is_specular());
        for theta in [0.0, 1.0, FRAC_PI_2 - 1e-4, 2.0] {
            let wo = direction(theta, 0.3);
            let sample = air.sample(wo, 0.0, Vec2::splat(0.5)).unwrap();
            assert!((sample.wi + wo).length() < 1e-3, "{theta}: {sample:?}");
            assert_eq!((sample.pdf, sample.eta, sample.weight), (1.0, 1.0, Spectrum::ONE));
        }
    }
}

#[test]
fn the_albedo_is_an_estimate_for_every_kind() {
    for bsdf in every_kind() {
        let albedo = bsdf.albedo(direction(0.4, 0.0)).max_component();
        assert!(albedo > 0.0 && albedo <= 1.0);
    }
    assert_eq!(Bsdf::from(Diffuse::new(Spectrum::splat(2.0))).albedo(Vec3::Z), Spectrum::ONE);
}

#[test]
fn coated_surfaces_survive_extreme_numbers() {
    let directions = [direction(0.3, 1.0), direction(FRAC_PI_2 - 1e-5, 0.3), direction(2.0, 4.0), Vec3::X];
    let strange = [0.0, 1e-3, 1.0, 1e30, f32::INFINITY, f32::NAN, -1.0];
    for alpha in [0.0, 1e-3, 0.3, 50.0] {
        for thickness in strange {
            for g in [0.0, 1.0, -1.0, f32::NAN] {
                let surface = Dielectric::new(1.5, [alpha; 2]);
                let albedo = Spectrum::splat(thickness);
                let coat =
                    Coat { surface, thickness, g, albedo, max_depth: 20, samples: 2, is_bright: alpha > 1.0 };
                let paper = Coated::new(coat, Diffuse::new(Spectrum::ONE), 3);
                let metal = Conductor::new(Spectrum::splat(0.05), Spectrum::splat(3.5), [alpha; 2]);
                let metal = Coated::new(coat, metal, 3);
                for bsdf in [Bsdf::from(&paper), Bsdf::from(&metal)] {
                    check_finite(&bsdf, &directions);
                }
            }
        }
    }
}

fn check_finite(bsdf: &Bsdf<'_>, directions: &[Vec3]) {
    for &wo in directions {
        for &wi in directions {
            let value = bsdf.eval(wo, wi);
            assert!(value.is_finite() && value.min_component() >= 0.0, "{bsdf:?} {wo:?} {wi:?}: {value:?}");
            let pdf = bsdf.pdf(wo, wi);
            assert!(pdf.is_finite() && pdf >= 0.0, "{bsdf:?} {wo:?} {wi:?}: {pdf}");
        }
        for u in [0.0, 0.3, 0.99] {
            let Some(sample) = bsdf.sample(wo, u, Vec2::new(1.0 - u, u)) else { continue };
            let usable = sample.pdf > 0.0 && sample.pdf.is_finite() && sample.weight.is_finite();
            assert!(usable && sample.wi.is_finite(), "{bsdf:?} {wo:?}: {sample:?}");
        }
    }
}

#[test]
fn a_pane_reflects_from_both_faces_and_bends_nothing() {
    let pane: Bsdf<'_> = ThinDielectric::new(1.5).into();
    for theta in [0.0, 0.8, 2.4] {
        let wo = direction(theta, 0.4);
        let through = pane.sample(wo, 0.999, Vec2::ZERO).unwrap();
        assert_eq!((through.wi, through.eta), (-wo, 1.0));
        assert_eq!(through.kind, ScatterKind::SPECULAR_TRANSMISSION);
        let r = fresnel::dielectric(wo.z.abs(), 1.5).reflectance;
        assert!((through.pdf - (1.0 - 2.0 * r / (1.0 + r))).abs() < 1e-6, "{theta}");
    }
}
