//! `sahl compare`: how far images are from a reference, and whether by more than noise.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use sahl::image::metrics::{Comparison, ZTest, ZTestOptions, compare};
use sahl::image::{EncodeOptions, Format, Image, ImageError, ToneMap, false_color, read, read_layers};

use crate::args::CompareArgs;
use crate::commands::print;
use crate::failure::{Failure, Reason};
use crate::output::Output;

/// The layer in which a render keeps the variance of its pixels.
pub(crate) const VARIANCE_LAYER: &str = "Variance";

/// Reads, compares, prints and draws.
pub(crate) fn run(args: &CompareArgs) -> Result<ExitCode, Failure> {
    let (tests, reference) = roles(args)?;
    if !args.var.is_empty() && args.var.len() != tests.len() {
        let message = format!(
            "`--var` takes one image for each image under test: {}, not {}",
            tests.len(),
            args.var.len()
        );
        return Err(Failure::usage(message));
    }
    if args.ref_var.is_some() && tests.len() < 2 && args.var.is_empty() {
        return Err(Failure::usage(
            "the noise of one image alone is not known, so `--ref-var` has nothing to add to",
        )
        .with_help("compare several seeds, or give `--var`"));
    }
    let drawing = args.png.as_deref().map(drawing).transpose()?;
    let images = tests.iter().map(|path| read_image(path)).collect::<Result<Vec<_>, _>>()?;
    let reference_image = read_image(reference)?;
    let variances = args.var.iter().map(|path| read_variance(path)).collect::<Result<Vec<_>, _>>()?;
    let reference_variance = args.ref_var.as_deref().map(read_variance).transpose()?;
    let options = ZTestOptions {
        reference_variance: reference_variance.as_ref(),
        test_variances: (!variances.is_empty()).then_some(variances.as_slice()),
        ..ZTestOptions::default()
    };
    let comparison = compare(&images, &reference_image, &options).map_err(incomparable)?;
    if let Some(output) = drawing {
        let picture = false_color::comparison(&images[0], &reference_image, &ToneMap::default());
        let bytes = picture.and_then(|picture| picture.encode(Format::Png, &EncodeOptions::default()));
        output.write(&bytes.map_err(incomparable)?)?;
    }
    if args.json {
        // By the names of the fields; an infinite PSNR is null, which is all that JSON has for it.
        let json = serde_json::to_value(&comparison).map_err(|error| {
            Failure::new(Reason::Render, format!("the figures can't be printed: {error}"))
        })?;
        print(&format!("{json:#}\n"))?;
    } else {
        print(&text(&comparison))?;
    }
    let biased = comparison.z_test.as_ref().is_some_and(|test| test.figures.biased);
    Ok(if biased { Reason::Render.into() } else { ExitCode::SUCCESS })
}

/// Which images are under test, and which one is the reference.
fn roles(args: &CompareArgs) -> Result<(&[PathBuf], &Path), Failure> {
    match (&args.reference, args.images.as_slice()) {
        (Some(reference), tests) => Ok((tests, reference)),
        (None, [tests @ .., reference]) if tests.len() == 1 => Ok((tests, reference)),
        (None, images) => {
            let message = format!("there are {} images and none is the reference", images.len());
            Err(Failure::usage(message).with_help("`sahl compare A B`, or `sahl compare A1 A2 ... --ref B`"))
        }
    }
}

fn drawing(path: &Path) -> Result<Output, Failure> {
    if Format::from_path(path) != Some(Format::Png) {
        return Err(Failure::usage(format!("`--png {}`: the name must end in .png", path.display())));
    }
    Output::check(path)
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(|error| Failure::file("can't read", path, &error))
}

fn read_image(path: &Path) -> Result<Image, Failure> {
    read(&read_bytes(path)?, &path.to_string_lossy()).map_err(|error| unreadable(path, &error))
}

/// The layer of variances, or the only image there is.
fn read_variance(path: &Path) -> Result<Image, Failure> {
    let picture =
        read_layers(&read_bytes(path)?, &path.to_string_lossy()).map_err(|error| unreadable(path, &error))?;
    let named = picture.layers.iter().find(|layer| layer.name.as_deref() == Some(VARIANCE_LAYER));
    let layer = named.or_else(|| picture.beauty());
    layer.map(|layer| layer.image.clone()).ok_or_else(|| {
        Failure::new(Reason::File, format!("can't read `{}`: it has no channels", path.display()))
    })
}

fn unreadable(path: &Path, error: &ImageError) -> Failure {
    Failure::new(Reason::File, format!("can't read `{}`: {error}", path.display()))
}

#[expect(clippy::needless_pass_by_value, reason = "`map_err` hands the error over")]
fn incomparable(error: ImageError) -> Failure {
    Failure::usage(error.to_string())
}

fn text(comparison: &Comparison) -> String {
    let mut text = String::new();
    let mut row = |label: &str, value: String| {
        let _ = writeln!(text, "{label:22} {value}");
    };
    row("non-finite pixels", comparison.non_finite_pixels.to_string());
    row("negative pixels", negative(comparison.negative_pixels));
    if comparison.reference_non_finite_pixels > 0 {
        row("  of the reference", format!("{} not finite", comparison.reference_non_finite_pixels));
    }
    row("MSE", format!("{:.6e}", comparison.mse));
    row("relMSE", format!("{:.6e}", comparison.rel_mse));
    row("relMSE, all pixels", format!("{:.6e}", comparison.rel_mse_all));
    row("PSNR", format!("{:.3} dB", comparison.psnr));
    row("FLIP", format!("{:.6}", comparison.flip));
    match (&comparison.z_test, comparison.identical_tests) {
        (Some(test), _) => row("bias", verdict(test)),
        (None, Some([first, second])) => {
            let (first, second) = (first + 1, second + 1);
            row(
                "bias",
                format!("unknown: images {first} and {second} are identical; compare other seeds (`--seed`)"),
            );
        }
        (None, None) => {
            row("bias", "unknown: needs several seeds or `--var`, and more than 16x16 pixels".to_owned());
        }
    }
    text
}

/// How many there are, and where they come from if not from a mistake.
fn negative(pixels: usize) -> String {
    match pixels {
        0 => "0".to_owned(),
        _ => format!("{pixels} (filters such as `mitchell` and colours outside the gamut make some)"),
    }
}

fn verdict(test: &ZTest) -> String {
    let figures = &test.figures;
    format!(
        "{}\n  mean difference      {:+.4} %\n  z of the whole       {:+.3} (p {:.3})\n  \
         z of tiles, rms      {:.3} (p {:.3})\n  z of tiles, largest  {:.3} (p {:.3})\n  \
         tests, tiles         {}, {}\n  pixel correlation    {:.3}\n  differ without noise {}",
        if figures.biased { "YES" } else { "no" },
        figures.relative_mean_difference * 100.0,
        figures.z_global,
        figures.p_global,
        figures.z_rms,
        figures.p_rms,
        figures.z_max,
        figures.p_max,
        test.tests,
        figures.tiles,
        test.pixel_correlation,
        figures.different_without_noise,
    )
}
