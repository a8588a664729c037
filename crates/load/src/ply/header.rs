//! The header: the format, and the tables that follow with their columns.

use sahl_scene::suggest;

use super::PlyError;

/// Files with more kinds of elements are refused; meshes have two or three.
const MOST_ELEMENTS: usize = 256;

/// How the values after the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// The names in use: those of the original and those with sizes.
    const NAMES: [(&'static str, Self); 16] = [
        ("char", Self::I8),
        ("uchar", Self::U8),
        ("short", Self::I16),
        ("ushort", Self::U16),
        ("int", Self::I32),
        ("uint", Self::U32),
        ("float", Self::F32),
        ("double", Self::F64),
        ("int8", Self::I8),
        ("uint8", Self::U8),
        ("int16", Self::I16),
        ("uint16", Self::U16),
        ("int32", Self::I32),
        ("uint32", Self::U32),
        ("float32", Self::F32),
        ("float64", Self::F64),
    ];

    /// Bytes in binary files.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// What a cell of a table holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// One number.
    Scalar(Scalar),
    /// A count and so many numbers.
    List { count: Scalar, item: Scalar },
}

/// A column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// Where the header declares it.
    pub(super) offset: usize,
}

/// A table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    /// Rows, as the header claims.
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Where the header declares it.
    pub(super) offset: usize,
}

impl Element {
    /// The column called `name`.
    pub(super) fn position(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|property| property.name == name)
    }

    /// An error, told to be in row `row`, from zero.
    pub(super) fn in_row(&self, row: u64, mut error: PlyError) -> PlyError {
        error.message += &format!(" (in row {} of {} of `{}`)", row + 1, self.count, self.name);
        error
    }
}

/// What stands before the values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// Where the values start.
    pub(super) body: usize,
}

impl Header {
    pub(super) fn read(bytes: &[u8]) -> Result<Self, PlyError> {
        let mut lines = Lines::new(bytes)?;
        let mut format = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            let Some(line) = lines.next() else {
                return Err(PlyError::at(bytes.len(), "the header does not end: expected `end_header`"));
            };
            let words = line.words();
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            match words.as_slice() {
                [] | ["comment" | "obj_info", ..] => {}
                ["end_header"] => break,
                ["format", name, version] => {
                    let found =
                        read_format(name, version).map_err(|message| PlyError::at(line.offset, message))?;
                    if format.replace(found).is_some() {
                        return Err(PlyError::at(line.offset, "a second `format`"));
                    }
                }
                ["element", name, count] => {
                    let element = read_element(name, count, line.offset)?;
                    if elements.iter().any(|other| other.name == element.name) {
                        return Err(PlyError::at(line.offset, format!("a second element `{name}`")));
                    }
                    if elements.len() == MOST_ELEMENTS {
                        return Err(PlyError::at(line.offset, format!("more than {MOST_ELEMENTS} elements")));
                    }
                    elements.push(element);
                }
                ["property", kind @ .., name] => {
                    let Some(element) = elements.last_mut() else {
                        return Err(PlyError::at(line.offset, "a `property` before the first `element`"));
                    };
                    let kind = read_kind(kind).map_err(|message| PlyError::at(line.offset, message))?;
                    element.properties.push(Property { name: (*name).to_owned(), kind, offset: line.offset });
                }
                [keyword, ..] => return Err(PlyError::at(line.offset, unknown_keyword(keyword))),
            }
        }
        let format = format.ok_or_else(|| PlyError::at(0, "the header has no `format`"))?;
        Ok(Self { format, elements, body: lines.offset })
    }

    /// The element called `name`, which a mesh can't do without.
    pub(super) fn element(&self, name: &str) -> Result<&Element, PlyError> {
        self.elements.iter().find(|element| element.name == name).ok_or_else(|| {
            let names: Vec<String> =
                self.elements.iter().map(|element| format!("`{}`", element.name)).collect();
            PlyError::at(0, format!("no element `{name}`; the file has {}", or_nothing(&names.join(", "))))
        })
    }
}

fn or_nothing(list: &str) -> &str {
    if list.is_empty() { "none" } else { list }
}

fn read_format(name: &str, version: &str) -> Result<Format, String> {
    if version != "1.0" {
        return Err(format!("unknown PLY version `{version}`: expected `1.0`"));
    }
    match name {
        "ascii" => Ok(Format::Ascii),
        "binary_little_endian" => Ok(Format::LittleEndian),
        "binary_big_endian" => Ok(Format::BigEndian),
        _ => Err(format!(
            "unknown format `{name}`: expected `ascii`, `binary_little_endian` or `binary_big_endian`"
        )),
    }
}

fn read_element(name: &str, count: &str, offset: usize) -> Result<Element, PlyError> {
    let count = count
        .parse()
        .map_err(|_| PlyError::at(offset, format!("expected the number of `{name}`, found `{count}`")))?;
    Ok(Element { name: name.to_owned(), count, properties: Vec::new(), offset })
}

fn read_kind(words: &[&str]) -> Result<Kind, String> {
    match words {
        [scalar] => Ok(Kind::Scalar(read_scalar(scalar)?)),
        ["list", count, item] => {
            let (count, item) = (read_scalar(count)?, read_scalar(item)?);
            if !count.is_integer() {
                return Err("the length of a list must have an integer type".to_owned());
            }
            Ok(Kind::List { count, item })
        }
        _ => Err("expected `property TYPE NAME` or `property list TYPE TYPE NAME`".to_owned()),
    }
}

fn read_scalar(name: &str) -> Result<Scalar, String> {
    let known = Scalar::NAMES.iter().find(|(known, _)| *known == name);
    known.map(|&(_, scalar)| scalar).ok_or_else(|| {
        let nearest = suggest::nearest(name, Scalar::NAMES.iter().map(|(known, _)| *known));
        let hint = nearest.map_or_else(String::new, |nearest| format!("; did you mean `{nearest}`?"));
        format!("unknown type `{name}`{hint}")
    })
}

fn unknown_keyword(keyword: &str) -> String {
    let keywords = ["format", "element", "property", "comment", "obj_info", "end_header"];
    if keywords.contains(&keyword) {
        return format!("`{keyword}` with too few or too many words");
    }
    let nearest = suggest::nearest(keyword, keywords);
    let hint = nearest.map_or_else(String::new, |nearest| format!("; did you mean `{nearest}`?"));
    format!("unknown word `{keyword}` in the header{hint}")
}

/// One line of the header.
struct Line<'a> {
    text: &'a [u8],
    offset: usize,
}

impl Line<'_> {
    /// The first words, each cut to a length that fits a message; no line that is understood has more words.
    fn words(&self) -> Vec<String> {
        const MOST: usize = 6;
        const LONGEST: usize = 60;
        let words = self.text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).take(MOST);
        words.map(|word| String::from_utf8_lossy(&word[..word.len().min(LONGEST)]).into_owned()).collect()
    }
}

/// The lines after the first. Their ends are those of the first, because the values of a binary file follow the last
/// one at once and may start with any byte.
struct Lines<'a> {
    bytes: &'a [u8],
    offset: usize,
    end: &'static [u8],
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, PlyError> {
        let ends: [&[u8]; 3] = [b"\n", b"\r\n", b"\r"];
        let blanks = |after: &[u8]| after.iter().take_while(|&&byte| byte == b' ' || byte == b'\t').count();
        let after = bytes.strip_prefix(b"ply").map(|after| &after[blanks(after)..]);
        let end = after.and_then(|after| ends.into_iter().find(|end| after.starts_with(end)));
        match (after, end) {
            (Some(after), Some(end)) => {
                Ok(Self { bytes, offset: bytes.len() - after.len() + end.len(), end })
            }
            _ => Err(PlyError::at(0, "not a PLY file: the first line is not `ply`")),
        }
    }

    fn next(&mut self) -> Option<Line<'a>> {
        let rest = &self.bytes[self.offset..];
        let length = rest.windows(self.end.len()).position(|window| window == self.end)?;
        let line = Line { text: &rest[..length], offset: self.offset };
        self.offset += length + self.end.len();
        Some(line)
    }
}
