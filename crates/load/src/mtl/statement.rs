//! The statements of an MTL file.

use std::path::{Path, PathBuf};

use sahl_scene::{Span, UvMapping, Wrap, suggest};

use crate::words::{Lines, Messages, Word, Words};

/// The statements of one material.
#[derive(Clone, Debug)]
pub(super) struct Statements {
    pub(super) name: String,
    /// Where it is named.
    pub(super) span: Span,
    /// Where its textures are looked for.
    pub(super) directory: PathBuf,
    pub(super) kd: Option<Color>,
    pub(super) ks: Option<Color>,
    pub(super) ke: Option<Color>,
    pub(super) tf: Option<Color>,
    pub(super) ns: Option<f32>,
    pub(super) ni: Option<f32>,
    pub(super) opacity: Option<(f32, Span)>,
    pub(super) illum: Option<f32>,
    pub(super) pr: Option<f32>,
    pub(super) pm: Option<f32>,
    pub(super) map_kd: Option<Map>,
    /// What is there and not honoured in any material.
    pub(super) unheeded: Vec<(&'static str, Span)>,
}

/// A colour and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Color {
    pub(super) rgb: [f32; 3],
    pub(super) span: Span,
}

impl Color {
    /// The largest component.
    pub(super) fn max(&self) -> f32 {
        self.rgb.into_iter().fold(0.0, f32::max)
    }
}

/// A texture statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    pub(super) path: String,
    pub(super) span: Span,
    pub(super) mapping: UvMapping,
    pub(super) wrap: Wrap,
}

/// Statements without counterpart, with what that means.
const NOT_HONOURED: [(&[&str], &str); 12] = [
    (&["map_bump", "bump", "norm", "map_kn"], "bump and normal maps are not honoured: surfaces are smooth"),
    (&["map_d", "map_opacity", "map_tr"], "opacity maps (`map_d`) are not honoured: surfaces are whole"),
    (&["disp"], "displacement (`disp`) is not honoured"),
    (&["map_ks", "map_ns"], "maps of highlights (`map_Ks`, `map_Ns`) are not honoured"),
    (&["map_ke"], "maps of emission (`map_Ke`) are not honoured"),
    (
        &["map_pr", "map_pm", "map_ps", "map_rma", "map_orm"],
        "maps of roughness and metalness are not honoured",
    ),
    (&["ps", "pc", "pcr"], "sheen and clear coat (`Ps`, `Pc`, `Pcr`) are not honoured"),
    (&["aniso", "anisor"], "anisotropy (`aniso`) is not honoured"),
    (&["refl", "map_refl"], "reflection maps (`refl`) are not honoured"),
    (&["decal"], "decals are not honoured"),
    (&["sharpness"], "`sharpness` is not honoured"),
    (&["map_aat"], "`map_aat` is not honoured"),
];

/// Statements that the path tracer makes pointless: the ambient term stands for the indirect light that it computes.
const WITHOUT_EFFECT: [&str; 2] = ["ka", "map_ka"];

/// The statements that are read, for suggestions.
const KNOWN: [&str; 14] =
    ["newmtl", "Kd", "Ks", "Ke", "Ka", "Tf", "Ns", "Ni", "d", "Tr", "illum", "map_Kd", "map_Bump", "map_d"];

/// Reads every material; what is wrong goes to `messages` and is left out.
pub(super) fn parse(text: &[u8], directory: &Path, messages: &mut Messages) -> Vec<Statements> {
    let mut entries: Vec<Statements> = Vec::new();
    for line in Lines::new(text) {
        let mut words = line.words();
        let Some(keyword) = words.next() else { continue };
        if keyword.bytes.eq_ignore_ascii_case(b"newmtl") {
            match words.rest() {
                Some(name) => entries.push(Statements::new(name, directory, messages)),
                None => messages.error("bad-statement", keyword, || "`newmtl` without a name".to_owned()),
            }
        } else if let Some(entry) = entries.last_mut() {
            entry.statement(keyword, words, messages);
        } else {
            let message = || format!("{} before the first `newmtl` is left out", keyword.quoted());
            messages.warn("bad-statement", keyword, message);
        }
    }
    entries
}

impl Statements {
    fn new(name: Word<'_>, directory: &Path, messages: &Messages) -> Self {
        Self {
            name: String::from_utf8_lossy(name.bytes).into_owned(),
            span: name.span(messages.file),
            directory: directory.to_owned(),
            kd: None,
            ks: None,
            ke: None,
            tf: None,
            ns: None,
            ni: None,
            opacity: None,
            illum: None,
            pr: None,
            pm: None,
            map_kd: None,
            unheeded: Vec::new(),
        }
    }

    fn statement(&mut self, keyword: Word<'_>, words: Words<'_>, messages: &mut Messages) {
        let name = String::from_utf8_lossy(keyword.bytes).to_ascii_lowercase();
        match name.as_str() {
            "kd" => self.kd = color(keyword, words, messages).or(self.kd),
            "ks" => self.ks = color(keyword, words, messages).or(self.ks),
            "ke" => self.ke = color(keyword, words, messages).or(self.ke),
            "tf" => self.tf = color(keyword, words, messages).or(self.tf),
            "ns" => self.ns = scalar(keyword, words, messages).or(self.ns),
            "ni" => self.ni = scalar(keyword, words, messages).or(self.ni),
            "pr" => self.pr = scalar(keyword, words, messages).or(self.pr),
            "pm" => self.pm = scalar(keyword, words, messages).or(self.pm),
            "illum" => self.illum = scalar(keyword, words, messages).or(self.illum),
            "d" | "tr" => {
                // `d -halo x` fades towards the silhouette.
                let mut words = words;
                let halo = words.clone().next().filter(|word| word.bytes == b"-halo");
                if let Some(halo) = halo {
                    words.next();
                    self.unheeded.push(("`d -halo` is not honoured", halo.span(messages.file)));
                }
                if let Some(value) = scalar(keyword, words, messages) {
                    let opacity = if name == "d" { value } else { 1.0 - value };
                    self.opacity = Some((opacity, keyword.span(messages.file)));
                }
            }
            "map_kd" => self.map_kd = self.map(keyword, words, messages).or(self.map_kd.take()),
            _ => self.other(&name, keyword, messages),
        }
    }

    fn other(&mut self, name: &str, keyword: Word<'_>, messages: &mut Messages) {
        if WITHOUT_EFFECT.contains(&name) {
            return;
        }
        if let Some((_, meaning)) = NOT_HONOURED.iter().find(|(names, _)| names.contains(&name)) {
            self.unheeded.push((meaning, keyword.span(messages.file)));
            return;
        }
        let nearest = suggest::nearest(name, KNOWN);
        let hint = nearest.map_or_else(String::new, |nearest| format!("; did you mean `{nearest}`?"));
        messages
            .warn("unknown-statement", keyword, || format!("unknown statement {}{hint}", keyword.quoted()));
    }

    /// Reads the options and the file name of a texture.
    fn map(&mut self, keyword: Word<'_>, mut words: Words<'_>, messages: &mut Messages) -> Option<Map> {
        let (mut mapping, mut wrap) = (UvMapping::default(), Wrap::Repeat);
        loop {
            let before = words.clone();
            let option = words.next()?;
            let most = match option.bytes {
                b"-s" | b"-o" | b"-t" => 3,
                b"-mm" => 2,
                b"-clamp" | b"-blendu" | b"-blendv" | b"-cc" | b"-texres" | b"-bm" | b"-boost"
                | b"-imfchan" | b"-type" => 1,
                _ => {
                    let name = before.clone().rest()?;
                    let path = String::from_utf8_lossy(name.bytes).into_owned();
                    return Some(Map { path, span: name.span(messages.file), mapping, wrap });
                }
            };
            let values = values(&mut words, most, matches!(option.bytes, b"-s" | b"-o" | b"-t" | b"-mm"));
            let number = |at: usize, default: f32| values.get(at).and_then(Word::number).unwrap_or(default);
            match option.bytes {
                b"-s" => mapping.scale = [number(0, 1.0), number(1, 1.0)],
                b"-o" => mapping.offset = [number(0, 0.0), number(1, 0.0)],
                b"-clamp" if values.first().is_some_and(|word| word.bytes == b"on") => wrap = Wrap::Clamp,
                b"-clamp" => wrap = Wrap::Repeat,
                _ => self.unheeded.push((
                    "of the options of textures only `-s`, `-o` and `-clamp` are honoured",
                    option.span(messages.file),
                )),
            }
            if !(mapping.scale.iter().chain(&mapping.offset)).all(|value| value.is_finite()) {
                messages.error("bad-number", option, || {
                    format!("{} with a number that is not finite", option.quoted())
                });
                mapping = UvMapping::default();
            }
            if words.clone().next().is_none() {
                messages
                    .error("bad-statement", keyword, || format!("{} without a file name", keyword.quoted()));
            }
        }
    }
}

/// The values of an option: at most `most`; where they are numbers, as many as there are.
fn values<'a>(words: &mut Words<'a>, most: usize, numeric: bool) -> Vec<Word<'a>> {
    let mut values = Vec::new();
    while values.len() < most {
        let mut ahead = words.clone();
        match ahead.next() {
            Some(word) if !numeric || word.number().is_some() => values.push(word),
            _ => break,
        }
        *words = ahead;
    }
    values
}

fn scalar(keyword: Word<'_>, mut words: Words<'_>, messages: &mut Messages) -> Option<f32> {
    let word = words.next();
    let value = word.and_then(|word| word.number()).filter(|value| value.is_finite());
    if value.is_none() {
        let found = word.map_or_else(|| "nothing".to_owned(), |word| word.quoted());
        let message = || format!("expected a finite number after {}, found {found}", keyword.quoted());
        messages.error("bad-number", word.unwrap_or(keyword), message);
    }
    value
}

/// A colour: three numbers, or one for all three.
fn color(keyword: Word<'_>, words: Words<'_>, messages: &mut Messages) -> Option<Color> {
    let span = keyword.span(messages.file);
    let first = words.clone().next()?;
    if matches!(first.bytes, b"spectral" | b"xyz") {
        let message =
            format!("{} {} is not honoured: give red, green and blue", keyword.quoted(), first.quoted());
        messages.warn("not-honoured", first, || message);
        return None;
    }
    let mut rgb = [0.0; 3];
    let mut count = 0;
    for (value, word) in rgb.iter_mut().zip(words) {
        match word.number().filter(|value| value.is_finite() && *value >= 0.0) {
            Some(number) => *value = number,
            None => {
                let message = || format!("expected a number of zero or more, found {}", word.quoted());
                messages.error("bad-number", word, message);
                return None;
            }
        }
        count += 1;
    }
    match count {
        1 => Some(Color { rgb: [rgb[0]; 3], span }),
        3 => Some(Color { rgb, span }),
        _ => {
            messages.error("bad-number", keyword, || {
                format!("{} with {count} numbers: expected three", keyword.quoted())
            });
            None
        }
    }
}
