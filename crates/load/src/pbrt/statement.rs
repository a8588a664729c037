//! The directives of the format: their names, their arguments, and where they may stand.

use sahl_scene::Span;

use super::parameter::Parameter;

/// One directive with its arguments.
#[derive(Debug)]
pub(super) struct Statement {
    /// Which it is.
    pub(super) rule: &'static Rule,
    /// The directive and the names after it: what messages and entities point at.
    pub(super) span: Span,
    /// Numbers, in the order of the text.
    pub(super) numbers: Vec<f64>,
    /// Strings, in the order of the text.
    pub(super) names: Vec<Name>,
    /// The parameter list.
    pub(super) parameters: Vec<Parameter>,
}

/// A string of the file, its escapes resolved, with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Name {
    /// The string.
    pub(super) text: String,
    /// Where it stands, quotes included.
    pub(super) span: Span,
}

/// What the format says about a directive.
#[derive(Debug)]
pub(super) struct Rule {
    /// Its keyword.
    pub(super) name: &'static str,
    /// What it does.
    pub(super) directive: Directive,
    /// What follows the keyword.
    pub(super) arguments: Arguments,
    /// Where it may stand.
    pub(super) block: Block,
}

/// What follows a keyword.
#[derive(Clone, Copy, Debug)]
pub(super) enum Arguments {
    /// So many numbers.
    Numbers(usize),
    /// Sixteen numbers in brackets.
    Matrix,
    /// At least and at most so many strings.
    Names(usize, usize),
    /// So many strings and a parameter list.
    Parameters(usize),
    /// A string and one bare value.
    Value,
    /// A bare word.
    Word,
}

/// The part of a scene in which a directive may stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Block {
    /// Before `WorldBegin`.
    Options,
    /// After `WorldBegin`.
    World,
    /// Before or after.
    Either,
}

/// What a directive does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Directive {
    Accelerator,
    ActiveTransform,
    AreaLightSource,
    Attribute,
    AttributeBegin,
    AttributeEnd,
    Camera,
    ColorSpace,
    ConcatTransform,
    CoordSysTransform,
    CoordinateSystem,
    Film,
    Identity,
    Import,
    Include,
    Integrator,
    LightSource,
    LookAt,
    MakeNamedMaterial,
    MakeNamedMedium,
    Material,
    MediumInterface,
    NamedMaterial,
    ObjectBegin,
    ObjectEnd,
    ObjectInstance,
    Option,
    PixelFilter,
    ReverseOrientation,
    Rotate,
    Sampler,
    Scale,
    Shape,
    Texture,
    Transform,
    TransformBegin,
    TransformEnd,
    TransformTimes,
    Translate,
    WorldBegin,
}

/// Writes one row of the table; the keyword is the name of the variant.
macro_rules! rule {
    ($name:ident, $arguments:expr, $block:ident) => {
        Rule {
            name: stringify!($name),
            directive: Directive::$name,
            arguments: $arguments,
            block: Block::$block,
        }
    };
}

use Arguments::{Matrix, Names, Numbers, Parameters, Value, Word};

/// Every directive.
pub(super) const RULES: &[Rule] = &[
    rule!(Shape, Parameters(1), World),
    rule!(AttributeBegin, Numbers(0), World),
    rule!(AttributeEnd, Numbers(0), World),
    rule!(ObjectInstance, Names(1, 1), World),
    rule!(Translate, Numbers(3), Either),
    rule!(Scale, Numbers(3), Either),
    rule!(Rotate, Numbers(4), Either),
    rule!(Transform, Matrix, Either),
    rule!(ConcatTransform, Matrix, Either),
    rule!(NamedMaterial, Names(1, 1), World),
    rule!(Material, Parameters(1), World),
    rule!(Texture, Parameters(3), World),
    rule!(Accelerator, Parameters(1), Options),
    rule!(ActiveTransform, Word, Either),
    rule!(AreaLightSource, Parameters(1), World),
    rule!(Attribute, Parameters(1), Either),
    rule!(Camera, Parameters(1), Options),
    rule!(ColorSpace, Names(1, 1), Either),
    rule!(CoordSysTransform, Names(1, 1), Either),
    rule!(CoordinateSystem, Names(1, 1), Either),
    rule!(Film, Parameters(1), Options),
    rule!(Identity, Numbers(0), Either),
    rule!(Import, Names(1, 1), World),
    rule!(Include, Names(1, 1), Either),
    rule!(Integrator, Parameters(1), Options),
    rule!(LightSource, Parameters(1), World),
    rule!(LookAt, Numbers(9), Either),
    rule!(MakeNamedMaterial, Parameters(1), World),
    rule!(MakeNamedMedium, Parameters(1), Either),
    rule!(MediumInterface, Names(1, 2), Either),
    rule!(ObjectBegin, Names(1, 1), World),
    rule!(ObjectEnd, Numbers(0), World),
    rule!(Option, Value, Either),
    rule!(PixelFilter, Parameters(1), Options),
    rule!(ReverseOrientation, Numbers(0), World),
    rule!(Sampler, Parameters(1), Options),
    rule!(TransformBegin, Numbers(0), World),
    rule!(TransformEnd, Numbers(0), World),
    rule!(TransformTimes, Numbers(2), Options),
    rule!(WorldBegin, Numbers(0), Either),
];

/// The directive with this keyword.
pub(super) fn rule(keyword: &[u8]) -> Option<&'static Rule> {
    RULES.iter().find(|rule| rule.name.as_bytes() == keyword)
}
