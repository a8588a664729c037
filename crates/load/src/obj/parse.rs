//! The statements of an OBJ file.

use std::collections::BTreeMap;

use sahl_math::{Vec2, Vec3};
use sahl_scene::{Span, suggest};

use crate::words::{Lines, Messages, Word, Words};

/// No index.
pub(super) const NONE: u32 = u32::MAX;

/// A corner of a polygon: indices from zero, or [`NONE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: u32,
    pub(super) normal: u32,
}

/// The polygons of one material.
#[derive(Debug, Default)]
pub(super) struct Group {
    /// The name of the material; `None` before the first `usemtl`.
    pub(super) material: Option<String>,
    /// The first statement that names it.
    pub(super) span: Option<Span>,
    /// The corners of all polygons, one polygon after the other.
    pub(super) corners: Vec<Corner>,
    /// For each polygon the end of its corners.
    pub(super) ends: Vec<usize>,
}

/// A file of materials that an OBJ file names.
#[derive(Debug)]
pub(super) struct Library {
    pub(super) path: String,
    pub(super) span: Span,
}

/// The contents of an OBJ file.
#[derive(Debug, Default)]
pub(super) struct ObjFile {
    pub(super) positions: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    pub(super) normals: Vec<Vec3>,
    pub(super) groups: Vec<Group>,
    pub(super) libraries: Vec<Library>,
}

/// Statements that change nothing in the image: names of objects and groups, which only serve editing.
const WITHOUT_EFFECT: [&str; 2] = ["o", "g"];

/// Statements of the format that are not honoured, with what that means.
const NOT_HONOURED: [(&str, &str); 21] = [
    ("p", "points have no surface"),
    ("l", "lines have no surface"),
    ("curv", "free-form curves and surfaces are left out"),
    ("curv2", "free-form curves and surfaces are left out"),
    ("surf", "free-form curves and surfaces are left out"),
    ("vp", "free-form curves and surfaces are left out"),
    ("cstype", "free-form curves and surfaces are left out"),
    ("deg", "free-form curves and surfaces are left out"),
    ("bmat", "free-form curves and surfaces are left out"),
    ("step", "free-form curves and surfaces are left out"),
    ("parm", "free-form curves and surfaces are left out"),
    ("trim", "free-form curves and surfaces are left out"),
    ("hole", "free-form curves and surfaces are left out"),
    ("scrv", "free-form curves and surfaces are left out"),
    ("sp", "free-form curves and surfaces are left out"),
    ("end", "free-form curves and surfaces are left out"),
    ("mg", "free-form curves and surfaces are left out"),
    ("lod", "every level of detail is shown"),
    ("usemap", "textures come from materials alone"),
    ("maplib", "textures come from materials alone"),
    ("call", "no other file is included"),
];

/// Reads every statement; what is wrong goes to `messages` and is left out.
pub(super) fn parse(text: &[u8], messages: &mut Messages) -> ObjFile {
    let mut parser =
        Parser { file: ObjFile::default(), groups: BTreeMap::new(), group: 0, polygon: Vec::new() };
    parser.file.groups.push(Group::default());
    let mut smoothing = None;
    for line in Lines::new(text) {
        let mut words = line.words();
        let Some(keyword) = words.next() else { continue };
        match keyword.bytes {
            b"v" => parser.position(keyword, words, messages),
            b"vt" => parser.uv(keyword, words, messages),
            b"vn" => parser.normal(keyword, words, messages),
            b"f" | b"fo" => parser.face(keyword, words, messages),
            b"usemtl" => parser.use_material(keyword, words, messages),
            b"mtllib" => parser.library(keyword, words, messages),
            b"s" => {
                let is_off = |word: Word<'_>| matches!(word.bytes, b"off" | b"0");
                smoothing = smoothing.or(words.next().filter(|&word| !is_off(word)).map(|_| keyword));
            }
            _ => other(keyword, messages),
        }
    }
    if let Some(keyword) =
        smoothing.filter(|_| parser.file.normals.is_empty() && !parser.file.positions.is_empty())
    {
        let message =
            "smoothing groups are not honoured: without normals (`vn`) every face is flat".to_owned();
        messages.warn_once("not-honoured", "s", keyword, message);
    }
    parser.file
}

fn other(keyword: Word<'_>, messages: &mut Messages) {
    let name = String::from_utf8_lossy(keyword.bytes);
    if WITHOUT_EFFECT.contains(&name.as_ref()) {
        return;
    }
    if let Some((name, meaning)) = NOT_HONOURED.iter().find(|(known, _)| *known == name) {
        messages.warn_once("not-honoured", meaning, keyword, format!("`{name}` is not honoured: {meaning}"));
        return;
    }
    let known = ["v", "vt", "vn", "f", "usemtl", "mtllib", "s", "o", "g"];
    let nearest = suggest::nearest(&name, known);
    let hint = nearest.map_or_else(String::new, |nearest| format!("; did you mean `{nearest}`?"));
    messages.warn("unknown-statement", keyword, || format!("unknown statement {}{hint}", keyword.quoted()));
}

struct Parser {
    file: ObjFile,
    /// For each material its group.
    groups: BTreeMap<String, usize>,
    /// The group that faces go to.
    group: usize,
    /// The corners of the face that is being read.
    polygon: Vec<Corner>,
}

impl Parser {
    fn position(&mut self, keyword: Word<'_>, mut words: Words<'_>, messages: &mut Messages) {
        let [x, y, z] = numbers(keyword, &mut words, 3, messages);
        self.file.positions.push(Vec3::new(x, y, z));
        // A fourth number is a weight, which polygons ignore; three or four more are a colour.
        if let Some(colour) = words.nth(2) {
            let message = "the colours of vertices are not honoured".to_owned();
            messages.warn_once("not-honoured", "vertex colours", colour, message);
        }
    }

    fn uv(&mut self, keyword: Word<'_>, mut words: Words<'_>, messages: &mut Messages) {
        // The second may be left out; a third has a meaning for solid textures alone.
        let wanted = words.clone().take(2).count();
        let [u, v, _] = numbers(keyword, &mut words, wanted, messages);
        self.file.uvs.push(Vec2::new(u, v));
    }

    fn normal(&mut self, keyword: Word<'_>, mut words: Words<'_>, messages: &mut Messages) {
        let [x, y, z] = normal_numbers(keyword, &mut words, messages);
        self.file.normals.push(Vec3::new(x, y, z));
    }

    fn face(&mut self, keyword: Word<'_>, words: Words<'_>, messages: &mut Messages) {
        self.polygon.clear();
        for word in words {
            match self.corner(word) {
                Ok(corner) => self.polygon.push(corner),
                Err(message) => return messages.error("bad-face", word, || message),
            }
        }
        if self.polygon.len() < 3 {
            let message = || format!("a face with {} corners is left out", self.polygon.len());
            return messages.warn("degenerate-face", keyword, message);
        }
        let group = &mut self.file.groups[self.group];
        group.corners.extend_from_slice(&self.polygon);
        group.ends.push(group.corners.len());
    }

    /// Reads `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: Word<'_>) -> Result<Corner, String> {
        let mut parts = word.bytes.split(|&byte| byte == b'/');
        let mut index = |what: &str, count: usize| match parts.next() {
            None | Some([]) => Ok(NONE),
            Some(part) => resolve(part, count, what),
        };
        let position = index("vertex", self.file.positions.len())?;
        let uv = index("texture coordinate", self.file.uvs.len())?;
        let normal = index("normal", self.file.normals.len())?;
        if position == NONE || parts.next().is_some() {
            return Err(format!("expected `v`, `v/vt`, `v//vn` or `v/vt/vn`, found {}", word.quoted()));
        }
        Ok(Corner { position, uv, normal })
    }

    fn use_material(&mut self, keyword: Word<'_>, mut words: Words<'_>, messages: &mut Messages) {
        let Some(name) = words.rest() else {
            return messages.error("bad-statement", keyword, || "`usemtl` without a name".to_owned());
        };
        let text = String::from_utf8_lossy(name.bytes).into_owned();
        let next = self.file.groups.len();
        self.group = *self.groups.entry(text.clone()).or_insert(next);
        if self.group == next {
            let span = Some(name.span(messages.file));
            self.file.groups.push(Group { material: Some(text), span, ..Group::default() });
        }
    }

    fn library(&mut self, keyword: Word<'_>, mut words: Words<'_>, messages: &mut Messages) {
        // The format allows several names in a line, and programs write names with blanks: one name it is.
        let Some(path) = words.rest() else {
            return messages.error("bad-statement", keyword, || "`mtllib` without a file name".to_owned());
        };
        let (path, span) = (String::from_utf8_lossy(path.bytes).into_owned(), path.span(messages.file));
        if !self.file.libraries.iter().any(|library| library.path == path) {
            self.file.libraries.push(Library { path, span });
        }
    }
}

/// The index from zero that a number in a face stands for: from one, or back from the latest if negative.
fn resolve(part: &[u8], count: usize, what: &str) -> Result<u32, String> {
    let text = std::str::from_utf8(part).unwrap_or("?");
    let index: i64 = text.parse().map_err(|_| format!("expected the number of a {what}, found `{text}`"))?;
    let from_zero = match index {
        1.. => usize::try_from(index - 1).ok(),
        0 => return Err(format!("{what} 0: numbers start from one")),
        _ => usize::try_from(index.unsigned_abs()).ok().and_then(|back| count.checked_sub(back)),
    };
    from_zero
        .filter(|&index| index < count)
        .and_then(|index| u32::try_from(index).ok())
        .filter(|&index| index != NONE)
        .ok_or_else(|| format!("{what} {index} is out of range: {count} are defined before this line"))
}

/// Reads up to three numbers, of which `wanted` must be there; what is not is zero.
fn numbers(keyword: Word<'_>, words: &mut Words<'_>, wanted: usize, messages: &mut Messages) -> [f32; 3] {
    let mut values = [0.0; 3];
    for value in values.iter_mut().take(wanted.max(1)) {
        match words.next() {
            Some(word) => match word.number() {
                Some(number) if number.is_finite() => *value = number,
                _ => {
                    let message = || format!("expected a finite number, found {}", word.quoted());
                    messages.error("bad-number", word, message);
                }
            },
            None => {
                let message = || format!("too few numbers after {}", keyword.quoted());
                messages.error("bad-number", keyword, message);
                break;
            }
        }
    }
    values
}

/// Reads a normal, whose numbers need not be finite: it can be repaired.
fn normal_numbers(keyword: Word<'_>, words: &mut Words<'_>, messages: &mut Messages) -> [f32; 3] {
    let parsed = words.clone().map(|word| word.number()).take(3);
    match parsed.collect::<Option<Vec<f32>>>().as_deref() {
        Some(&[x, y, z]) => [x, y, z],
        _ => numbers(keyword, words, 3, messages),
    }
}
