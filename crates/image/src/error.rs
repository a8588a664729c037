//! What can be wrong with an image, its file or a request about it.

use thiserror::Error;

use crate::Format;

/// Why an image could not be made, read, written or compared.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ImageError {
    /// Neither the first bytes nor the name tell the format.
    #[error("`{name}` is in no image format known here: expected PNG, JPEG, EXR, HDR, PFM, PPM or TGA")]
    UnknownFormat {
        /// The name the bytes came with.
        name: String,
    },
    /// A feature of the format that is not implemented.
    #[error("{format}: {feature} not supported")]
    Unsupported {
        /// Format of the file.
        format: Format,
        /// What was asked for, ending in "is" or "are".
        feature: String,
    },
    /// The bytes break the rules of their format, or end too early.
    #[error("not a valid {format} file: {message}")]
    Malformed {
        /// Format of the file.
        format: Format,
        /// What is wrong with it.
        message: String,
    },
    /// The header claims more pixels than are accepted, or than the bytes that follow can hold.
    #[error("{format}: the header claims {width}x{height} pixels of {pixel_bytes} bytes, {reason}")]
    TooLarge {
        /// Format of the file.
        format: Format,
        /// Claimed width in pixels.
        width: u64,
        /// Claimed height in pixels.
        height: u64,
        /// Decoded bytes a pixel.
        pixel_bytes: u64,
        /// The limit that is exceeded.
        reason: String,
    },
    /// The picture can't be written in this format.
    #[error("can't write {format}: {message}")]
    Encode {
        /// Format asked for.
        format: Format,
        /// What stands against it.
        message: String,
    },
    /// The number of values does not fit the size.
    #[error("{width}x{height} pixels with {channels} channels need {expected} values, found {found}")]
    WrongLength {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
        /// Channels a pixel.
        channels: usize,
        /// `width × height × channels`; `usize::MAX` where that overflows.
        expected: usize,
        /// Values given.
        found: usize,
    },
    /// An image has one to four channels.
    #[error("an image has one to four channels, found {found}")]
    ChannelCount {
        /// Channels asked for.
        found: usize,
    },
    /// A rectangle or channel lies outside the image, or is empty.
    #[error("{what} is outside the image of {width}x{height} pixels with {channels} channels")]
    OutOfBounds {
        /// The rectangle or channel asked for.
        what: String,
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
        /// Channels a pixel.
        channels: usize,
    },
    /// Images to be compared differ in size.
    #[error(
        "images of different size can't be compared: expected {}x{}, found {}x{}",
        expected[0], expected[1], found[0], found[1]
    )]
    SizesDiffer {
        /// Width and height of the reference.
        expected: [usize; 2],
        /// Width and height of the other image.
        found: [usize; 2],
    },
    /// A metric was asked of images that it is not defined for.
    #[error("{0}")]
    Metric(String),
}

impl ImageError {
    /// A [`ImageError::Malformed`] with the message of another library, its first letter made small.
    #[expect(clippy::needless_pass_by_value, reason = "`map_err` hands errors over by value")]
    pub(crate) fn malformed(format: Format, message: impl ToString) -> ImageError {
        ImageError::Malformed { format, message: lower_first(&message.to_string()) }
    }

    /// An [`ImageError::Encode`] with the message of another library, its first letter made small.
    #[expect(clippy::needless_pass_by_value, reason = "`map_err` hands errors over by value")]
    pub(crate) fn encode(format: Format, message: impl ToString) -> ImageError {
        ImageError::Encode { format, message: lower_first(&message.to_string()) }
    }

    /// An [`ImageError::Unsupported`]; `feature` ends in "is" or "are".
    pub(crate) fn unsupported(format: Format, feature: impl Into<String>) -> ImageError {
        ImageError::Unsupported { format, feature: feature.into() }
    }
}

/// Makes the first letter small unless an acronym begins there.
fn lower_first(message: &str) -> String {
    let mut letters = message.trim_end_matches('.').chars();
    let Some(first) = letters.next() else { return String::new() };
    let rest = letters.as_str();
    if rest.starts_with(|second: char| second.is_uppercase()) {
        return format!("{first}{rest}");
    }
    format!("{}{rest}", first.to_lowercase())
}

#[cfg(test)]
mod tests {
    use super::lower_first;

    #[test]
    fn foreign_messages_begin_small_and_end_without_a_stop() {
        assert_eq!(lower_first("Unexpected end of file."), "unexpected end of file");
        assert_eq!(lower_first("CRC error"), "CRC error");
        assert_eq!(lower_first(""), "");
    }
}
