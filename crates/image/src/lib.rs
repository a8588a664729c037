//! Images: pixel buffers, colour, files, tone mapping and error metrics.
#![forbid(unsafe_code)]

mod buffer;
mod color;

pub use buffer::{Image, Pixels};
pub use color::{ColorSpace, Encoding};
