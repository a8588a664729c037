//! Images as the metrics take them.

use crate::{ColorSpace, Image, ImageError};

/// Linear light with sRGB primaries, every value finite.
pub(super) struct RgbPixels {
    pub(super) size: [usize; 2],
    pub(super) colors: Vec<[f32; 3]>,
    /// Pixels of which a value was not finite.
    pub(super) non_finite: usize,
    /// Pixels of which a value is negative.
    pub(super) negative: usize,
}

impl RgbPixels {
    /// Converts an image; values that are not finite become 0.
    pub(super) fn new(image: &Image) -> RgbPixels {
        let mut colors = image.to_rgb(ColorSpace::Srgb);
        let (mut non_finite, mut negative) = (0, 0);
        for color in &mut colors {
            if color.iter().any(|value| !value.is_finite()) {
                non_finite += 1;
                *color = color.map(|value| if value.is_finite() { value } else { 0.0 });
            }
            negative += usize::from(color.iter().any(|value| *value < 0.0));
        }
        RgbPixels { size: [image.width, image.height], colors, non_finite, negative }
    }

    /// Converts an image that must have as many pixels as `self`.
    pub(super) fn matching(&self, image: &Image) -> Result<RgbPixels, ImageError> {
        let found = [image.width, image.height];
        if found != self.size {
            return Err(ImageError::SizesDiffer { expected: self.size, found });
        }
        Ok(RgbPixels::new(image))
    }

    /// Converts a reference and a test of the same size, at least one pixel.
    pub(super) fn pair(test: &Image, reference: &Image) -> Result<(RgbPixels, RgbPixels), ImageError> {
        let reference = RgbPixels::new(reference);
        let test = reference.matching(test)?;
        if reference.colors.is_empty() {
            return Err(ImageError::Metric("images without pixels can't be compared".into()));
        }
        Ok((test, reference))
    }
}
