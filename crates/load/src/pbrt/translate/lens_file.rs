//! Files of lenses: four numbers an element, from the scene to the film.
//!
//! Curvature radius, thickness, index of refraction and diameter, lengths in millimetres; a radius of zero is the aperture stop. `#` starts
//! a comment. Where lines end does not matter.

use sahl_scene::{FileId, LensElement, Span};

use super::super::context::Context;
use super::super::report::{Report, quote};
use super::super::statement::Name;

/// Elements that a lens may have: each ray meets them all.
const MOST_ELEMENTS: usize = 256;

/// A number of the file, and where it stands.
#[derive(Clone, Copy)]
struct Number {
    value: f32,
    span: Span,
}

/// The elements in the file called `name`; `None`, reported, if there are none or they make no sense.
pub(super) fn lens_file(cx: &Context<'_>, name: &Name) -> Option<Vec<LensElement>> {
    let (path, bytes) = cx.read_file(name)?;
    if u32::try_from(bytes.len()).is_err() {
        cx.report.error("bad-lens", name.span, format!("`{}` is too long for a lens", name.text));
        return None;
    }
    let file = cx.report.add_source(path.to_string_lossy().into_owned(), bytes.clone());
    let numbers = numbers(&cx.report, file, &bytes)?;
    let (rows, rest) = numbers.as_chunks::<4>();
    if let Some(first) = rest.first() {
        let message = format!(
            "a lens has four numbers an element (radius, thickness, index, diameter): {} are left over",
            rest.len()
        );
        cx.report.error("bad-lens", first.span, message);
        return None;
    }
    if rows.is_empty() || rows.len() > MOST_ELEMENTS {
        let message = format!(
            "the lens {} has {} elements: expected 1 to {MOST_ELEMENTS}",
            quote(name.text.as_bytes()),
            rows.len()
        );
        cx.report.error("bad-lens", name.span, message);
        return None;
    }
    rows.iter().map(|row| element(&cx.report, row)).collect()
}

/// The numbers of a file; `None`, reported, if a word is none.
fn numbers(report: &Report, file: FileId, bytes: &[u8]) -> Option<Vec<Number>> {
    let mut numbers = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        match bytes[at] {
            b'#' => at += bytes[at..].iter().position(|&byte| byte == b'\n').unwrap_or(bytes.len() - at),
            byte if byte.is_ascii_whitespace() => at += 1,
            _ => {
                let ends = |byte: &u8| byte.is_ascii_whitespace() || *byte == b'#';
                let length = bytes[at..].iter().position(ends).unwrap_or(bytes.len() - at);
                let word = &bytes[at..at + length];
                let span = Span { file, start: at as u32, end: (at + length) as u32 };
                let value = std::str::from_utf8(word).ok().and_then(|word| word.parse::<f32>().ok());
                let Some(value) = value.filter(|value| value.is_finite()) else {
                    let message = format!("a lens is made of numbers, found {}", quote(word));
                    report.error("bad-lens", span, message);
                    return None;
                };
                numbers.push(Number { value, span });
                at += length;
            }
        }
    }
    Some(numbers)
}

/// One element, in metres; `None`, reported, if a number is out of its range.
fn element(report: &Report, [radius, thickness, eta, diameter]: &[Number; 4]) -> Option<LensElement> {
    let complaint = if thickness.value < 0.0 {
        Some((thickness, "the thickness of a lens element must be at least zero"))
    } else if eta.value < 0.0 {
        Some((eta, "an index of refraction must be positive, or zero for air"))
    } else if diameter.value <= 0.0 {
        Some((diameter, "the diameter of a lens element must be greater than zero"))
    } else {
        None
    };
    if let Some((number, complaint)) = complaint {
        report.error("bad-lens", number.span, format!("{complaint}, found {}", number.value));
        return None;
    }
    Some(LensElement {
        curvature_radius: radius.value / 1000.0,
        thickness: thickness.value / 1000.0,
        eta: eta.value,
        diameter: diameter.value / 1000.0,
    })
}
