//! Images: pixel buffers, colour, files, tone mapping and error metrics.
//!
//! Files are bytes in and bytes out ([`read`], [`encode`]): this crate never opens one. Everything that is written is a
//! function of the picture and the options alone, without date or host name, so that equal pictures give equal bytes.
//!
//! Deliberately absent: a file system, image processing, ICC profiles, deep EXR, spectra.
#![forbid(unsafe_code)]

mod buffer;
mod codec;
mod color;
mod convert;
mod error;
pub mod false_color;
pub mod metrics;
mod picture;
mod tone_map;

pub use buffer::{Image, Pixels};
pub use codec::{BitDepth, EncodeOptions, Format, ImageInfo, Precision, encode, probe, read, read_layers};
pub use color::{Adaptation, Chromaticities, ColorSpace, Encoding};
pub use error::ImageError;
pub use picture::{Attribute, Layer, Metadata, Picture};
pub use tone_map::{Curve, ToneMap};
