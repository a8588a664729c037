//! Golden images: references kept with the tests, by which a render is judged.
//!
//! A reference of a noisy render is two files, `name.exr` and `name.var.exr`: the mean of each pixel and the variance
//! of that mean. A render passes when it estimates the same picture ([`crate::ztest`]), so that a change of the random
//! numbers needs no new reference and a bias fails even where no eye would see it. Images without noise (positions,
//! normals, labs) have one file and a tolerance.
//!
//! With the environment variable `SAHL_BLESS` set, the reference is written from the render at hand and the test still
//! fails, so that no run passes on a reference that nobody has looked at.

use std::error::Error;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use sahl_image::{EncodeOptions, Format, Image, ImageError, Pixels, read};

use crate::ztest::{Estimate, ImageTest, ZReport};

/// The environment variable that makes every check write its reference.
pub const BLESS: &str = "SAHL_BLESS";

/// How renders are judged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Golden {
    /// The comparison; its `samples` and `tests` should be those of the test at hand.
    pub test: ImageTest,
    /// Writes the reference, as if [`BLESS`] were set.
    pub bless: bool,
}

/// How far an image without noise may be from its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// The largest difference of a value.
    pub absolute: f32,
    /// The largest difference of a value as a share of its reference; whichever of the two allows more counts.
    pub relative: f32,
    /// The share of values that may differ by more: pixels on an edge, which a rounding moves.
    pub outliers: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { absolute: 1e-5, relative: 1e-4, outliers: 0.0 }
    }
}

/// Why a golden test failed.
pub struct GoldenFailure {
    /// Name of the test.
    pub name: String,
    /// What is wrong, with figures.
    pub reason: String,
    /// What was written for the eye: the render, the picture of differences, or the new reference.
    pub files: Vec<PathBuf>,
}

impl fmt::Display for GoldenFailure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "golden image `{}`: {}", self.name, self.reason)?;
        self.files.iter().try_for_each(|file| write!(f, "\n  wrote {}", file.display()))
    }
}

/// As [`fmt::Display`]: it is what `unwrap` prints in a test.
impl fmt::Debug for GoldenFailure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Error for GoldenFailure {}

impl Golden {
    /// Judges a render by `folder/name.exr` and `folder/name.var.exr`.
    ///
    /// `mean` and `variance` are linear images of the same shape; `variance` is that of the mean. On failure the
    /// render, a picture of the z scores and a picture of the differences are written to the target folder.
    pub fn check(
        &self,
        name: &str,
        folder: &Path,
        mean: &Image,
        variance: &Image,
    ) -> Result<(), GoldenFailure> {
        let paths = ["exr", "var.exr"].map(|extension| folder.join(format!("{name}.{extension}")));
        let [reference_mean, reference_variance] = self.references(name, &paths, &[mean, variance])?;
        let reference = Estimate { mean: &reference_mean, variance: &reference_variance };
        let report = match self.test.compare(Estimate { mean, variance }, reference) {
            Ok(ZReport { failure: None, .. }) => return Ok(()),
            Ok(report) => report,
            Err(reason) => return Err(failure(name, reason, &[("test.exr", Some(mean))])),
        };
        let scores = score_picture(mean, &report.z);
        let difference = signed_difference(mean, &reference_mean);
        let pictures =
            [("test.exr", Some(mean)), ("z.png", scores.as_ref()), ("difference.exr", difference.as_ref())];
        Err(failure(name, report.to_string(), &pictures))
    }

    /// Judges an image without noise by `folder/name.exr`, value by value.
    pub fn check_exact(
        &self,
        name: &str,
        folder: &Path,
        image: &Image,
        tolerance: Tolerance,
    ) -> Result<(), GoldenFailure> {
        let path = folder.join(format!("{name}.exr"));
        let [reference] = self.references(name, &[path], &[image])?;
        let difference = signed_difference(image, &reference);
        let pictures = [("test.exr", Some(image)), ("difference.exr", difference.as_ref())];
        let reason = if difference.is_none() {
            let shape = |i: &Image| [i.width, i.height, i.channels];
            Some(format!("the image is {:?}, the reference {:?}", shape(image), shape(&reference)))
        } else {
            outliers(&values(image), &values(&reference), tolerance)
        };
        reason.map_or(Ok(()), |reason| Err(failure(name, reason, &pictures)))
    }

    /// Reads the references at `paths`; when blessing, writes `images` there and fails.
    fn references<const N: usize>(
        &self,
        name: &str,
        paths: &[PathBuf; N],
        images: &[&Image; N],
    ) -> Result<[Image; N], GoldenFailure> {
        let problem = |reason: String| GoldenFailure { name: name.to_owned(), reason, files: Vec::new() };
        if self.bless || std::env::var_os(BLESS).is_some() {
            for (path, image) in paths.iter().zip(images) {
                write(path, image, Format::Exr).map_err(|e| problem(format!("{}: {e}", path.display())))?;
            }
            let reason =
                "the reference is written; look at it, then run the test again without blessing".to_owned();
            return Err(GoldenFailure { name: name.to_owned(), reason, files: paths.to_vec() });
        }
        let mut references = Vec::new();
        for path in paths {
            match load(path) {
                Ok(image) => references.push(image),
                Err(e) => {
                    let reason = format!("no reference at {}: {e}; {BLESS}=1 writes one", path.display());
                    return Err(failure(name, reason, &[("test.exr", Some(images[0]))]));
                }
            }
        }
        references.try_into().map_err(|_| problem("a reference is missing".to_owned()))
    }
}

/// What is wrong with the values of an image without noise, `None` if all are near enough.
fn outliers(found: &[f32], expected: &[f32], tolerance: Tolerance) -> Option<String> {
    let excess = |i: usize| {
        let (f, e) = (found[i], expected[i]);
        if f == e || (f.is_nan() && e.is_nan()) {
            return 0.0;
        }
        (f - e).abs() / (tolerance.relative * e.abs()).max(tolerance.absolute)
    };
    // A NaN on one side alone is an outlier: the comparison is written so that NaN fails it.
    let beyond: Vec<usize> = (0..found.len()).filter(|&i| !matches!(excess(i), e if e <= 1.0)).collect();
    if beyond.len() as f64 <= tolerance.outliers * found.len() as f64 {
        return None;
    }
    let worst = beyond.iter().copied().max_by(|&a, &b| excess(a).total_cmp(&excess(b)))?;
    Some(format!(
        "{} of {} values differ, at most {:.3} % may; the worst is value {worst}: {} instead of {}",
        beyond.len(),
        found.len(),
        100.0 * tolerance.outliers,
        found[worst],
        expected[worst]
    ))
}

/// The failure of `name`, with those pictures that could be written.
fn failure(name: &str, reason: String, pictures: &[(&str, Option<&Image>)]) -> GoldenFailure {
    let folder = output_folder();
    let files = pictures.iter().filter_map(|(extension, image)| {
        let path = folder.join(format!("{name}.{extension}"));
        let format = Format::from_path(&path)?;
        // The picture only helps the eye: that it can't be written must not hide the failure itself.
        write(&path, (*image)?, format).ok().map(|()| path)
    });
    GoldenFailure { name: name.to_owned(), reason, files: files.collect() }
}

/// `golden` in the target folder of the running test, which lies in `<target>/<profile>/deps`.
fn output_folder() -> PathBuf {
    let executable = std::env::current_exe().unwrap_or_default();
    let target = executable.ancestors().find(|folder| folder.join("CACHEDIR.TAG").exists());
    target.map_or_else(std::env::temp_dir, Path::to_path_buf).join("golden")
}

fn write(path: &Path, image: &Image, format: Format) -> io::Result<()> {
    let bytes = image.encode(format, &EncodeOptions::default()).map_err(io::Error::other)?;
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(path, bytes)
}

fn load(path: &Path) -> io::Result<Image> {
    let decoded: Result<Image, ImageError> = read(&fs::read(path)?, &path.to_string_lossy());
    decoded.map_err(io::Error::other)
}

/// The linear values of an image.
fn values(image: &Image) -> Vec<f32> {
    match image.to_linear_f32().pixels {
        Pixels::F32(values) => values,
        Pixels::U8(_) => Vec::new(),
    }
}

/// Image less reference; `None` where the shapes differ.
fn signed_difference(image: &Image, reference: &Image) -> Option<Image> {
    let (found, expected) = (values(image), values(reference));
    let same = (image.width, image.height, image.channels)
        == (reference.width, reference.height, reference.channels);
    let differences = found.iter().zip(&expected).map(|(f, e)| f - e).collect();
    same.then(|| Image::new(image.width, image.height, image.channels, Pixels::F32(differences)).ok())?
}

/// The z scores as a picture of the size of `like`: red where the render is too bright, blue where it is too dark,
/// full at five standard deviations, green where a value is not finite. Each pixel shows the worst of its channels.
fn score_picture(like: &Image, z: &[f64]) -> Option<Image> {
    let color = |scores: &[f64]| {
        if scores.iter().any(|z| z.is_nan()) {
            return [0.0, 1.0, 0.0];
        }
        let worst = scores.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0) as f32;
        [(worst / 5.0).clamp(0.0, 1.0), 0.0, (-worst / 5.0).clamp(0.0, 1.0)]
    };
    Image::rgb_f32(like.width, like.height, z.chunks(like.channels).flat_map(color).collect()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;

    /// A folder of its own for each test, empty.
    fn folder(test: &str) -> PathBuf {
        let folder = output_folder().join("selftest").join(test);
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    /// Normal noise of variance 0.01 about a ramp.
    fn render(seed: u64, bias: f32) -> [Image; 2] {
        let mut rng = Rng::new(seed);
        let noise = (0..32 * 24 * 3).map(|i| bias + (i / 3 % 32) as f32 / 32.0 + 0.1 * rng.normal() as f32);
        [noise.collect(), vec![0.01; 32 * 24 * 3]].map(|values| Image::rgb_f32(32, 24, values).unwrap())
    }

    const BLESSING: Golden = Golden {
        test: ImageTest { significance: 0.01, pass_fraction: 0.9975, samples: 1000, tile: 16, tests: 1 },
        bless: true,
    };
    const CHECKING: Golden = Golden { bless: false, ..BLESSING };

    #[test]
    fn a_blessing_fails_once_and_then_another_seed_passes() {
        let folder = folder("blessing");
        let [mean, variance] = render(1, 0.0);
        let missing = CHECKING.check("ramp", &folder, &mean, &variance).unwrap_err();
        assert!(missing.to_string().contains("no reference at"), "{missing}");
        let blessed = BLESSING.check("ramp", &folder, &mean, &variance).unwrap_err();
        assert_eq!(blessed.files, [folder.join("ramp.exr"), folder.join("ramp.var.exr")]);
        let [mean, variance] = render(2, 0.0);
        CHECKING.check("ramp", &folder, &mean, &variance).unwrap();
    }

    #[test]
    fn a_biased_render_fails_and_shows_itself() {
        let folder = folder("biased");
        let [mean, variance] = render(3, 0.0);
        BLESSING.check("biased", &folder, &mean, &variance).unwrap_err();
        let [mean, variance] = render(4, 0.03);
        let failure = CHECKING.check("biased", &folder, &mean, &variance).unwrap_err();
        assert!(failure.to_string().contains("p = "), "{failure}");
        assert_eq!(failure.files.len(), 3, "{failure}");
        assert_eq!(load(&failure.files[0]).unwrap(), mean);
        let scores = load(&failure.files[1]).unwrap();
        assert_eq!((scores.width, scores.height), (32, 24));
        let small = Image::filled(3, 3, 3, 0.0).unwrap();
        let failure = CHECKING.check("biased", &folder, &small, &small).unwrap_err();
        assert!(failure.to_string().contains("[3, 3, 3]"), "{failure}");
    }

    #[test]
    fn exact_images_are_held_to_their_tolerance() {
        let folder = folder("exact");
        let image = |values: &[f32]| Image::y_f32(values.len(), 1, values.to_vec()).unwrap();
        let reference = image(&[0.0, 1.0, 100.0, f32::INFINITY]);
        BLESSING.check_exact("exact", &folder, &reference, Tolerance::default()).unwrap_err();
        let check =
            |values: &[f32], tolerance| CHECKING.check_exact("exact", &folder, &image(values), tolerance);
        let strict = Tolerance::default();
        check(&[0.0, 1.0, 100.0, f32::INFINITY], strict).unwrap();
        check(&[5e-6, 1.000_05, 100.005, f32::INFINITY], strict).unwrap();
        for wrong in [
            [1e-4, 1.0, 100.0, f32::INFINITY],
            [0.0, 1.0, 100.1, f32::INFINITY],
            [0.0, f32::NAN, 100.0, f32::INFINITY],
            [0.0, 1.0, 100.0, 1e30],
        ] {
            let failure = check(&wrong, strict).unwrap_err();
            assert!(failure.to_string().contains("1 of 4 values differ"), "{failure}");
            check(&wrong, Tolerance { outliers: 0.25, ..strict }).unwrap();
        }
        let failure = check(&[0.0], strict).unwrap_err();
        assert!(failure.to_string().contains("[1, 1, 1]"), "{failure}");
    }
}
