//! Parameters: their types and values.

use std::cell::Cell;

use sahl_image::ColorSpace;
use sahl_scene::Span;

use super::lexer::{TokenKind, unquote};
use super::number::{Integer, parse_f32, parse_i32};
use super::parser::Parser;
use super::statement::Name;

/// One parameter as written.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    /// The type before the name.
    pub(super) kind: Kind,
    /// The name.
    pub(super) name: String,
    /// The string that holds both.
    pub(super) declaration: Span,
    /// What follows.
    pub(super) values: Values,
    /// Where that stands.
    pub(super) value_span: Span,
    /// The space of its RGB values: the one in force where it stands.
    pub(super) color_space: ColorSpace,
    /// Whether somebody asked for it.
    pub(super) used: Cell<bool>,
}

/// The values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Floats(Vec<f32>),
    Integers(Vec<i32>),
    Bools(Vec<bool>),
    Strings(Vec<Name>),
    /// Values that could not be read, which has been reported.
    Invalid,
}

/// The types of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Bool,
    Integer,
    Float,
    Point2,
    Vector2,
    Point3,
    Vector3,
    Normal,
    Text,
    Texture,
    Spectrum,
    Rgb,
    Blackbody,
}

/// The names of the types.
pub(super) const KINDS: &[(&str, Kind)] = &[
    ("bool", Kind::Bool),
    ("integer", Kind::Integer),
    ("float", Kind::Float),
    ("point2", Kind::Point2),
    ("vector2", Kind::Vector2),
    ("point3", Kind::Point3),
    ("vector3", Kind::Vector3),
    ("normal", Kind::Normal),
    ("string", Kind::Text),
    ("texture", Kind::Texture),
    ("spectrum", Kind::Spectrum),
    ("rgb", Kind::Rgb),
    ("blackbody", Kind::Blackbody),
];

impl Kind {
    /// The name in the file.
    pub(super) fn name(self) -> &'static str {
        KINDS.iter().find(|(_, kind)| *kind == self).map_or("", |(name, _)| name)
    }

    /// Numbers that make one value.
    pub(super) fn components(self) -> usize {
        match self {
            Self::Point2 | Self::Vector2 => 2,
            Self::Point3 | Self::Vector3 | Self::Normal | Self::Rgb => 3,
            _ => 1,
        }
    }
}

impl Values {
    /// No values of the type; `first` tells whether a spectrum is given by numbers or by name.
    pub(super) fn empty(kind: Kind, first: TokenKind) -> Self {
        match kind {
            Kind::Bool => Self::Bools(Vec::new()),
            Kind::Integer => Self::Integers(Vec::new()),
            Kind::Text | Kind::Texture => Self::Strings(Vec::new()),
            Kind::Spectrum if first == TokenKind::Quoted => Self::Strings(Vec::new()),
            _ => Self::Floats(Vec::new()),
        }
    }

    /// Number of values.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Floats(values) => values.len(),
            Self::Integers(values) => values.len(),
            Self::Bools(values) => values.len(),
            Self::Strings(values) => values.len(),
            Self::Invalid => 0,
        }
    }

    /// Gives back what growing took beyond need: meshes are kept by the million.
    pub(super) fn shrink(&mut self) {
        match self {
            Self::Floats(values) => values.shrink_to_fit(),
            Self::Integers(values) => values.shrink_to_fit(),
            _ => {}
        }
    }

    /// What one value of this list is called.
    pub(super) fn expected(&self) -> &'static str {
        match self {
            Self::Bools(_) => "`true` or `false`",
            Self::Integers(_) => "an integer",
            Self::Strings(_) => "a string",
            _ => "a number",
        }
    }

    /// Reads one value; `false` if the next token is none.
    #[inline]
    pub(super) fn read(&mut self, parser: &mut Parser<'_>) -> bool {
        match self {
            Self::Floats(values) => match parse_f32(parser.lexer.rest()) {
                Some((value, length)) => {
                    parser.lexer.take(length);
                    values.push(value);
                    true
                }
                None => false,
            },
            Self::Integers(values) => match parse_i32(parser.lexer.rest()) {
                Integer::Value(value, length) => {
                    parser.lexer.take(length);
                    values.push(value);
                    true
                }
                _ => false,
            },
            Self::Bools(values) => {
                let token = parser.lexer.peek();
                let value = match parser.lexer.bytes(token) {
                    b"true" => true,
                    b"false" => false,
                    _ => return false,
                };
                parser.lexer.next();
                values.push(value);
                true
            }
            Self::Strings(values) => {
                let token = parser.lexer.peek();
                if token.kind != TokenKind::Quoted {
                    return false;
                }
                parser.lexer.next();
                values
                    .push(Name { text: unquote(parser.lexer.bytes(token)), span: parser.lexer.span(token) });
                true
            }
            Self::Invalid => false,
        }
    }
}
