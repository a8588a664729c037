//! Parameter lists: `"type name" value` and `"type name" [ value … ]`.
//!
//! Values are read straight into vectors of their type, without a token for each.

use std::cell::Cell;

use sahl_image::ColorSpace;
use sahl_scene::{Diagnostic, Span, suggest};

use super::lexer::{Token, TokenKind, unquote};
use super::number::{Integer, parse_f32, parse_i32};
use super::parameter::{KINDS, Kind, Parameter, Values};
use super::parser::{Abandoned, Parser};
use super::report::quote;

/// Parameters that one list may hold; no plugin has a tenth of them.
const LIST_LIMIT: usize = 256;

/// Types of other versions of the format, and what pbrt-v4 calls them.
const FORMER_KINDS: &[(&str, &str)] = &[
    ("point", "point3"),
    ("vector", "vector3"),
    ("color", "rgb"),
    ("xyz", "spectrum"),
    ("normal3", "normal"),
];

/// Reads the parameters that follow, up to the next token that is no string.
pub(super) fn parse(parser: &mut Parser<'_>) -> Result<Vec<Parameter>, Abandoned> {
    let mut list: Vec<Parameter> = Vec::new();
    loop {
        let token = parser.lexer.peek();
        match token.kind {
            TokenKind::Quoted => {}
            TokenKind::End => return Ok(list),
            TokenKind::Word if parser.is_keyword(token) => return Ok(list),
            // A word that may be a misspelt directive is for whoever reads directives.
            TokenKind::Word if parse_f32(parser.lexer.bytes(token)).is_none() => return Ok(list),
            _ => {
                let found = parser.describe(token);
                let message = format!("expected a parameter such as `\"float x\"`, found {found}");
                parser.report.push(parser.syntax_error(token, message));
                return Err(Abandoned);
            }
        }
        parser.lexer.next();
        if let Some(parameter) = parse_one(parser, token)? {
            add(parser, &mut list, parameter)?;
        }
    }
}

/// Adds a parameter to the list of its statement, unless the list has one of that name.
fn add(parser: &Parser<'_>, list: &mut Vec<Parameter>, parameter: Parameter) -> Result<(), Abandoned> {
    if let Some(first) = list.iter().find(|first| first.name == parameter.name) {
        let name = quote(parameter.name.as_bytes());
        let message = format!("parameter {name} is given twice: the first is used");
        let diagnostic = Diagnostic::warning("repeated-parameter", parameter.declaration, message);
        parser.report.push_with_place(diagnostic, "the first is in", first.declaration);
        return Ok(());
    }
    if list.len() == LIST_LIMIT {
        let message = format!("more than {LIST_LIMIT} parameters in one list");
        parser.report.error("too-many-parameters", parameter.declaration, message);
        return Err(Abandoned);
    }
    list.push(parameter);
    Ok(())
}

/// Reads the parameter declared by `token`; `None` if it has an error that leaves the rest of the list readable.
fn parse_one(parser: &mut Parser<'_>, token: Token) -> Result<Option<Parameter>, Abandoned> {
    let declaration = parser.lexer.span(token);
    let text = unquote(parser.lexer.bytes(token));
    let mut words = text.split_ascii_whitespace();
    let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
        let message =
            format!("expected a type and a name such as `\"float x\"`, found {}", quote(text.as_bytes()));
        parser.report.error("syntax", declaration, message);
        skip_values(parser)?;
        return Ok(None);
    };
    let start = parser.lexer.peek();
    let known = KINDS.iter().find(|(word, _)| *word == kind).map(|(_, kind)| *kind);
    let mut values = match (known, start.kind) {
        (None, _) => {
            let message = format!("unknown parameter type {}", quote(kind.as_bytes()));
            let diagnostic = Diagnostic::error("unknown-type", declaration, message);
            parser.report.push_with(diagnostic, |diagnostic| with_current_kind(kind, diagnostic));
            skip_values(parser)?;
            Values::Invalid
        }
        (Some(kind), TokenKind::Open) => {
            parser.lexer.next();
            let mut values = bracketed(parser, kind, start, name)?;
            values.shrink();
            values
        }
        (Some(kind), _) => single(parser, kind, name)?,
    };
    // The type of values that can't be read does not matter; the name does, to whoever asks for it.
    let kind = known.unwrap_or(Kind::Float);
    let value_span =
        Span { start: start.start, end: parser.position().max(start.end as usize) as u32, ..declaration };
    check_count(parser, kind, name, &mut values, value_span);
    let name = name.to_owned();
    Ok(Some(Parameter {
        kind,
        name,
        declaration,
        values,
        value_span,
        color_space: ColorSpace::Srgb,
        used: Cell::new(false),
    }))
}

/// Adds what to write instead of an unknown type.
fn with_current_kind(kind: &str, diagnostic: Diagnostic) -> Diagnostic {
    if let Some((_, current)) = FORMER_KINDS.iter().find(|(former, _)| *former == kind) {
        return diagnostic.with_help(format!("pbrt-v4 calls it `{current}`"));
    }
    match suggest::nearest(kind, KINDS.iter().map(|(name, _)| *name)) {
        Some(nearest) => diagnostic.with_help(format!("did you mean `{nearest}`?")),
        None => diagnostic,
    }
}

/// Reports a list whose length is no multiple of what its type needs, and drops its values.
fn check_count(parser: &Parser<'_>, kind: Kind, name: &str, values: &mut Values, span: Span) {
    let Values::Floats(numbers) = values else { return };
    let components = kind.components();
    if !numbers.len().is_multiple_of(components) {
        let message = format!(
            "parameter {} of type `{}` needs {components} numbers a value, found {}",
            quote(name.as_bytes()),
            kind.name(),
            numbers.len()
        );
        parser.report.error("wrong-count", span, message);
        *values = Values::Invalid;
    }
}

/// Reads the value of a parameter without brackets.
fn single(parser: &mut Parser<'_>, kind: Kind, name: &str) -> Result<Values, Abandoned> {
    let token = parser.lexer.peek();
    let mut values = Values::empty(kind, token.kind);
    if values.read(parser) {
        return Ok(values);
    }
    parser.report.push(wrong_value(parser, &values, token, name));
    let skippable = matches!(token.kind, TokenKind::Word | TokenKind::Quoted) && !parser.is_keyword(token);
    if !skippable {
        return Err(Abandoned);
    }
    parser.lexer.next();
    Ok(Values::Invalid)
}

/// Reads values up to the closing bracket; `open` is the opening one.
fn bracketed(parser: &mut Parser<'_>, kind: Kind, open: Token, name: &str) -> Result<Values, Abandoned> {
    let mut values = Values::empty(kind, parser.lexer.peek().kind);
    loop {
        while values.read(parser) {
            // A string that looks like the next parameter tells that a bracket is missing.
            if let Values::Strings(strings) = &values
                && strings.len() > 1
                && strings.last().is_some_and(|last| is_declaration(&last.text))
            {
                return unclosed(parser, open, name, strings.last().map(|last| last.span.start));
            }
        }
        let token = parser.lexer.peek();
        match token.kind {
            TokenKind::Close => {
                parser.lexer.next();
                return Ok(values);
            }
            TokenKind::End | TokenKind::Open | TokenKind::Unterminated => {
                return unclosed(parser, open, name, None);
            }
            TokenKind::Quoted if is_declaration(&unquote(parser.lexer.bytes(token))) => {
                return unclosed(parser, open, name, Some(token.start));
            }
            TokenKind::Word if parser.is_keyword(token) => return unclosed(parser, open, name, None),
            TokenKind::Word | TokenKind::Quoted => {
                // Of several wrong values the first is told.
                if values != Values::Invalid {
                    parser.report.push(wrong_value(parser, &values, token, name));
                }
                values = Values::Invalid;
                parser.lexer.next();
            }
        }
    }
}

/// Reports a list without an end. If it ends where the next parameter starts, at byte `next`, reading goes on there.
fn unclosed(
    parser: &mut Parser<'_>,
    open: Token,
    name: &str,
    next: Option<u32>,
) -> Result<Values, Abandoned> {
    let token = parser.lexer.peek();
    let found = match next {
        Some(_) => "the next parameter".to_owned(),
        None => parser.describe(token),
    };
    let message = format!("the values of {} have no closing `]`", quote(name.as_bytes()));
    let end = match next {
        Some(start) => Token { start, ..token },
        None => token,
    };
    let diagnostic = Diagnostic::error("unclosed-bracket", parser.lexer.span(open), message);
    let note = format!("found {found} instead, in");
    parser.report.push_with_place(diagnostic, &note, parser.lexer.span(end));
    match next {
        Some(start) => {
            parser.lexer.seek(start);
            Ok(Values::Invalid)
        }
        None => Err(Abandoned),
    }
}

/// Whether a string reads like `type name`.
fn is_declaration(text: &str) -> bool {
    text.split_once(' ').is_some_and(|(kind, _)| KINDS.iter().any(|(name, _)| *name == kind))
}

/// The message that `token` is no value for such a list.
fn wrong_value(parser: &Parser<'_>, values: &Values, token: Token, name: &str) -> Diagnostic {
    let (bytes, name) = (parser.lexer.bytes(token), quote(name.as_bytes()));
    if let (Values::Integers(_), Integer::OutOfRange(_)) = (values, parse_i32(bytes)) {
        let message = format!("parameter {name}: {} does not fit in 32 bits", quote(bytes));
        return Diagnostic::error("integer-range", parser.lexer.span(token), message);
    }
    if token.kind == TokenKind::Unterminated {
        return parser.syntax_error(token, String::new());
    }
    let message = format!("parameter {name} expects {}, found {}", values.expected(), parser.describe(token));
    let diagnostic = Diagnostic::error("wrong-type", parser.lexer.span(token), message);
    match (values, bytes) {
        (Values::Bools(_), b"\"true\"" | b"\"false\"") => {
            diagnostic.with_help("pbrt-v4 writes it without quotes")
        }
        (Values::Strings(_), _) if token.kind == TokenKind::Word => {
            diagnostic.with_help("write it in quotes")
        }
        _ => diagnostic,
    }
}

/// Skips the value or the bracketed values of a parameter that can't be read.
fn skip_values(parser: &mut Parser<'_>) -> Result<(), Abandoned> {
    let open = parser.lexer.peek();
    match open.kind {
        TokenKind::Open => {}
        TokenKind::Word if parser.is_keyword(open) => return Ok(()),
        TokenKind::Word | TokenKind::Quoted => {
            parser.lexer.next();
            return Ok(());
        }
        _ => return Ok(()),
    }
    parser.lexer.next();
    loop {
        let token = parser.lexer.peek();
        if token.kind == TokenKind::End || parser.is_keyword(token) {
            return unclosed(parser, open, "?", None).map(|_| ());
        }
        parser.lexer.next();
        if token.kind == TokenKind::Close {
            return Ok(());
        }
    }
}
