//! Values with a syntax of their own.

use std::str::FromStr;
use std::time::Duration;

/// `WxH`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Resolution(pub(crate) [u32; 2]);

/// `x0,x1,y0,y1` in pixels, the maxima exclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Crop(pub(crate) [u32; 4]);

/// `x0,x1,y0,y1` as shares of the width and the height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fractions(pub(crate) [f32; 4]);

/// `x,y`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PixelPosition(pub(crate) [u32; 2]);

/// `90`, `90s`, `1.5m`, `2h`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seconds(pub(crate) Duration);

/// `key=value`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Definition {
    pub(crate) key: String,
    pub(crate) value: String,
}

/// Splits `text` into exactly `N` values.
fn split<T: FromStr, const N: usize>(text: &str, separator: char, form: &str) -> Result<[T; N], String> {
    let values: Option<Vec<T>> = text.split(separator).map(|part| part.trim().parse().ok()).collect();
    values.and_then(|values| values.try_into().ok()).ok_or_else(|| format!("expected {form}"))
}

impl FromStr for Resolution {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let size: [u32; 2] = split(text, 'x', "width x height in pixels, such as `640x480`")?;
        if size.contains(&0) {
            return Err("an image needs at least one pixel each way".to_owned());
        }
        Ok(Self(size))
    }
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bounds: [u32; 4] = split(text, ',', "four numbers of pixels, `x0,x1,y0,y1`")?;
        if bounds[0] >= bounds[1] || bounds[2] >= bounds[3] {
            return Err("expected `x0,x1,y0,y1` with x0 < x1 and y0 < y1".to_owned());
        }
        Ok(Self(bounds))
    }
}

impl FromStr for Fractions {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bounds: [f32; 4] = split(text, ',', "four shares between 0 and 1, `x0,x1,y0,y1`")?;
        let inside = bounds.iter().all(|bound| (0.0..=1.0).contains(bound));
        if !inside || bounds[0] >= bounds[1] || bounds[2] >= bounds[3] {
            return Err("expected `x0,x1,y0,y1` between 0 and 1 with x0 < x1 and y0 < y1".to_owned());
        }
        Ok(Self(bounds))
    }
}

impl FromStr for PixelPosition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        split(text, ',', "column and row of a pixel, `x,y`").map(Self)
    }
}

impl FromStr for Seconds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, unit) = match text.find(|c: char| c.is_ascii_alphabetic()) {
            Some(at) => text.split_at(at),
            None => (text, "s"),
        };
        let factor = match unit {
            "s" => 1.0,
            "m" | "min" => 60.0,
            "h" => 3600.0,
            _ => return Err("expected a number of seconds, or one followed by `s`, `m` or `h`".to_owned()),
        };
        let seconds =
            number.parse::<f64>().ok().filter(|seconds| *seconds > 0.0).map(|seconds| seconds * factor);
        let duration = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        duration.map(Self).ok_or_else(|| "expected a positive number of seconds".to_owned())
    }
}

impl FromStr for Definition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text.split_once('=').ok_or("expected `key=value`")?;
        Ok(Self { key: key.trim().to_owned(), value: value.trim().to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_as_people_write_them() {
        assert_eq!("640x480".parse(), Ok(Resolution([640, 480])));
        assert_eq!("1, 2,3,4".parse::<Crop>(), Ok(Crop([1, 2, 3, 4])));
        assert_eq!("0,0.5,0.25,1".parse(), Ok(Fractions([0.0, 0.5, 0.25, 1.0])));
        assert_eq!("3,4".parse(), Ok(PixelPosition([3, 4])));
        assert_eq!("1.5m".parse(), Ok(Seconds(Duration::from_secs(90))));
        assert_eq!("0.5".parse(), Ok(Seconds(Duration::from_millis(500))));
        let definition = Definition { key: "spp".to_owned(), value: "4".to_owned() };
        assert_eq!("spp=4".parse(), Ok(definition));
    }

    #[test]
    fn nonsense_is_refused() {
        for text in ["640", "0x480", "640x480x3", "640x-1", "ax b"] {
            assert!(text.parse::<Resolution>().is_err(), "{text}");
        }
        for text in ["4,4,0,1", "0,1,0", "0,1,2,1", "0.5,1,0,1"] {
            assert!(text.parse::<Crop>().is_err(), "{text}");
        }
        for text in ["0,2,0,1", "nan,1,0,1", "0.5,0.5,0,1"] {
            assert!(text.parse::<Fractions>().is_err(), "{text}");
        }
        for text in ["0", "-1", "soon", "3 days", "inf", "1e300h", "nan"] {
            assert!(text.parse::<Seconds>().is_err(), "{text}");
        }
    }
}
