//! What a plugin asks of its parameter list.
//!
//! A [`Reader`] checks types, counts and values as they are asked for, remembers the names that were asked, and at the
//! end complains about parameters that nobody wanted, with the nearest name that somebody did. No plugin has a list of
//! its parameters: the code that reads them is the list.

use std::cell::RefCell;
use std::rc::Rc;

use sahl_image::ColorSpace;
use sahl_math::{Vec2, Vec3};
use sahl_scene::{Diagnostic, Span, suggest};

use super::parameter::{Kind, Parameter, Values};
use super::report::{Report, quote};
use super::statement::Name;

/// The parameters of one plugin, with those that `Attribute` set before.
pub(super) struct Reader<'p> {
    /// What messages call the plugin: ``shape `sphere` ``.
    what: String,
    /// Where the plugin is named.
    span: Span,
    own: &'p [Parameter],
    defaults: &'p [Rc<Parameter>],
    report: &'p Report,
    asked: RefCell<Vec<&'static str>>,
}

impl<'p> Reader<'p> {
    /// A reader of `own`, and of `defaults` for what is not there.
    pub(super) fn new(
        what: String,
        span: Span,
        own: &'p [Parameter],
        defaults: &'p [Rc<Parameter>],
        report: &'p Report,
    ) -> Self {
        Self { what, span, own, defaults, report, asked: RefCell::new(Vec::new()) }
    }

    /// What messages call the plugin.
    pub(super) fn what(&self) -> &str {
        &self.what
    }

    /// Where the plugin is named.
    pub(super) fn span(&self) -> Span {
        self.span
    }

    /// Where messages go.
    pub(super) fn report(&self) -> &'p Report {
        self.report
    }

    /// The parameter called `name`, whatever its type, counted as used.
    pub(super) fn find(&self, name: &'static str) -> Option<&'p Parameter> {
        self.asked.borrow_mut().push(name);
        let defaults = self.defaults.iter().map(Rc::as_ref);
        let parameter = self.own.iter().chain(defaults).find(|parameter| parameter.name == name)?;
        parameter.used.set(true);
        Some(parameter)
    }

    /// Whether `name` is given.
    pub(super) fn has(&self, name: &'static str) -> bool {
        self.find(name).is_some()
    }

    /// The parameter called `name` if it has one of these types; another type is an error.
    fn typed(&self, name: &'static str, kinds: &[Kind]) -> Option<&'p Parameter> {
        let parameter = self.find(name)?;
        if parameter.values == Values::Invalid {
            return None;
        }
        if !kinds.contains(&parameter.kind) {
            self.wrong_kind(parameter, kinds);
            return None;
        }
        Some(parameter)
    }

    /// Reports a parameter that has none of the types `kinds`.
    pub(super) fn wrong_kind(&self, parameter: &Parameter, kinds: &[Kind]) {
        if parameter.values == Values::Invalid {
            return;
        }
        let names: Vec<String> = kinds.iter().map(|kind| format!("`{}`", kind.name())).collect();
        let message = format!(
            "parameter `{}` of {} has type {}, found `{}`",
            parameter.name,
            self.what,
            names.join(" or "),
            parameter.kind.name()
        );
        self.report.error("wrong-type", parameter.declaration, message);
    }

    /// The numbers of `name`, all finite.
    fn floats(&self, name: &'static str, kind: Kind) -> Option<&'p [f32]> {
        let parameter = self.typed(name, &[kind])?;
        self.finite(parameter)
    }

    /// The numbers of `parameter`; none of them if one is not finite.
    pub(super) fn finite<'v>(&self, parameter: &'v Parameter) -> Option<&'v [f32]> {
        let Values::Floats(values) = &parameter.values else { return None };
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            self.report_non_finite(parameter, index);
            return None;
        }
        Some(values)
    }

    /// Reports that value number `index` of `parameter` is infinite or not a number.
    fn report_non_finite(&self, parameter: &Parameter, index: usize) {
        let message = format!("parameter `{}`: value {} is not a finite number", parameter.name, index + 1);
        self.report.error("non-finite-number", self.report.value_span(parameter.value_span, index), message);
    }

    /// One value; any other number of them is an error.
    pub(super) fn one<'v, T>(&self, parameter: &Parameter, values: &'v [T]) -> Option<&'v T> {
        if let [value] = values {
            return Some(value);
        }
        let message = format!("parameter `{}` expects one value, found {}", parameter.name, values.len());
        self.report.error("wrong-count", parameter.value_span, message);
        None
    }

    /// A number.
    pub(super) fn float(&self, name: &'static str, default: f32) -> f32 {
        self.optional_float(name).unwrap_or(default)
    }

    /// A number, if it is given.
    pub(super) fn optional_float(&self, name: &'static str) -> Option<f32> {
        let parameter = self.typed(name, &[Kind::Float])?;
        self.one(parameter, self.finite(parameter)?).copied()
    }

    /// A number that may be infinite.
    pub(super) fn float_or_infinity(&self, name: &'static str) -> f32 {
        let Some(parameter) = self.typed(name, &[Kind::Float]) else { return f32::INFINITY };
        match &parameter.values {
            Values::Floats(values) if matches!(**values, [f32::INFINITY]) => f32::INFINITY,
            _ => self.positive(name, f32::INFINITY),
        }
    }

    /// A number greater than zero.
    pub(super) fn positive(&self, name: &'static str, default: f32) -> f32 {
        self.float_where(name, default, |value| value > 0.0, "greater than zero")
    }

    /// A number that is not negative.
    pub(super) fn non_negative(&self, name: &'static str, default: f32) -> f32 {
        self.float_where(name, default, |value| value >= 0.0, "at least zero")
    }

    /// A number that satisfies `valid`; any other is an error that says that it must be `requirement`.
    pub(super) fn float_where(
        &self,
        name: &'static str,
        default: f32,
        valid: impl Fn(f32) -> bool,
        requirement: &str,
    ) -> f32 {
        let value = self.float(name, default);
        if value.to_bits() == default.to_bits() || valid(value) {
            return value;
        }
        self.invalid(name, &format!("must be {requirement}, found {value}"));
        default
    }

    /// Reports that the value of `name` is of no use.
    pub(super) fn invalid(&self, name: &'static str, complaint: &str) {
        let span = self.find(name).map_or(self.span, |parameter| parameter.value_span);
        self.report.error("invalid-value", span, format!("parameter `{name}` of {} {complaint}", self.what));
    }

    /// Exactly `N` numbers.
    pub(super) fn float_array<const N: usize>(&self, name: &'static str) -> Option<[f32; N]> {
        let values = self.floats(name, Kind::Float)?;
        self.array(name, values)
    }

    /// Exactly `N` integers.
    pub(super) fn integer_array<const N: usize>(&self, name: &'static str) -> Option<[i32; N]> {
        let values = self.integers(name)?;
        self.array(name, values)
    }

    fn array<T: Copy, const N: usize>(&self, name: &'static str, values: &[T]) -> Option<[T; N]> {
        let array = <[T; N]>::try_from(values).ok();
        if array.is_none() {
            let span = self.find(name).map_or(self.span, |parameter| parameter.value_span);
            let message = format!("parameter `{name}` expects {N} values, found {}", values.len());
            self.report.error("wrong-count", span, message);
        }
        array
    }

    /// Numbers, all finite.
    pub(super) fn float_values(&self, name: &'static str) -> Option<&'p [f32]> {
        self.floats(name, Kind::Float)
    }

    /// Colours, all finite and not negative, and the space in which they are given.
    pub(super) fn rgb_values(&self, name: &'static str) -> Option<(&'p [[f32; 3]], ColorSpace)> {
        let parameter = self.typed(name, &[Kind::Rgb])?;
        let values = self.finite(parameter)?;
        if let Some(index) = values.iter().position(|&value| value < 0.0) {
            let span = self.report.value_span(parameter.value_span, index);
            let message = format!("`{name}` of {} is negative here: expected zero or more", self.what);
            self.report.error("invalid-value", span, message);
            return None;
        }
        Some((values.as_chunks().0, parameter.color_space))
    }

    /// Integers.
    pub(super) fn integers(&self, name: &'static str) -> Option<&'p [i32]> {
        match &self.typed(name, &[Kind::Integer])?.values {
            Values::Integers(values) => Some(values),
            _ => None,
        }
    }

    /// An integer from `least` to `most`; one outside is an error.
    pub(super) fn integer(&self, name: &'static str, default: i32, least: i32, most: i32) -> i32 {
        let Some(values) = self.integers(name) else { return default };
        let Some(&value) = self.find(name).and_then(|parameter| self.one(parameter, values)) else {
            return default;
        };
        if !(least..=most).contains(&value) {
            self.invalid(name, &format!("must lie from {least} to {most}, found {value}"));
            return default;
        }
        value
    }

    /// An integer that is not negative.
    pub(super) fn count(&self, name: &'static str, default: u32) -> u32 {
        let default = i32::try_from(default).unwrap_or(i32::MAX);
        self.integer(name, default, 0, i32::MAX).unsigned_abs()
    }

    /// A truth value.
    pub(super) fn bool(&self, name: &'static str, default: bool) -> bool {
        let Some(parameter) = self.typed(name, &[Kind::Bool]) else { return default };
        match &parameter.values {
            Values::Bools(values) => self.one(parameter, values).copied().unwrap_or(default),
            _ => default,
        }
    }

    /// Strings.
    pub(super) fn strings(&self, name: &'static str) -> Option<&'p [Name]> {
        match &self.typed(name, &[Kind::Text])?.values {
            Values::Strings(values) => Some(values),
            _ => None,
        }
    }

    /// A string.
    pub(super) fn string(&self, name: &'static str) -> Option<&'p Name> {
        let values = self.strings(name)?;
        self.one(self.find(name)?, values)
    }

    /// What the string `name` stands for in `choices`; a string that is not there is an error.
    pub(super) fn choice<T: Copy>(&self, name: &'static str, choices: &[(&str, T)], default: T) -> T {
        let Some(given) = self.string(name) else { return default };
        match choices.iter().find(|(choice, _)| *choice == given.text) {
            Some((_, value)) => *value,
            None => {
                let message = format!(
                    "parameter `{name}` of {}: unknown value {}",
                    self.what,
                    quote(given.text.as_bytes())
                );
                let names = choices.iter().map(|(choice, _)| *choice);
                self.report.push_with_choices(
                    Diagnostic::error("unknown-value", given.span, message),
                    &given.text,
                    names,
                );
                default
            }
        }
    }

    /// A point.
    pub(super) fn point(&self, name: &'static str, default: Vec3) -> Vec3 {
        let Some(parameter) = self.typed(name, &[Kind::Point3]) else { return default };
        match self.vectors(name, Kind::Point3) {
            Some(points) => self.one(parameter, &points).copied().unwrap_or(default),
            None => default,
        }
    }

    /// Triples of numbers: points, vectors or normals.
    pub(super) fn vectors(&self, name: &'static str, kind: Kind) -> Option<Vec<Vec3>> {
        let values = self.floats(name, kind)?;
        Some(values.as_chunks().0.iter().map(|&[x, y, z]| Vec3::new(x, y, z)).collect())
    }

    /// Pairs of numbers.
    pub(super) fn pairs(&self, name: &'static str) -> Option<Vec<Vec2>> {
        let values = self.floats(name, Kind::Point2)?;
        Some(values.as_chunks().0.iter().map(|&[x, y]| Vec2::new(x, y)).collect())
    }

    /// Warns about each of `names` that is given: Sahl does not have it, and does `instead`.
    pub(super) fn unsupported(&self, names: &[&'static str], instead: &str) {
        for name in names {
            if let Some(parameter) = self.find(name) {
                let message = format!("parameter `{name}` of {} is not supported: {instead}", self.what);
                self.report.warning("unsupported-parameter", parameter.declaration, message);
            }
        }
    }

    /// Accepts `names`, which change nothing that Sahl computes.
    pub(super) fn without_effect(&self, names: &[&'static str]) {
        for name in names {
            self.find(name);
        }
    }

    /// Accepts every parameter: the plugin as a whole has been reported.
    pub(super) fn ignore_all(&self) {
        for parameter in self.own {
            parameter.used.set(true);
        }
    }

    /// Warns that the plugin is not supported, and that Sahl does `instead`.
    pub(super) fn unsupported_plugin(&self, code: &'static str, instead: &str) {
        self.report.warning(code, self.span, format!("{} is not supported: {instead}", self.what));
    }

    /// Warns about the parameters that nobody asked for. Those of `Attribute` are meant for some plugins only.
    pub(super) fn finish(self) {
        let asked = self.asked.into_inner();
        for parameter in self.own.iter().filter(|parameter| !parameter.used.get()) {
            let message = format!("{} has no parameter {}", self.what, quote(parameter.name.as_bytes()));
            let diagnostic = Diagnostic::warning("unknown-parameter", parameter.declaration, message);
            self.report.push_with(diagnostic, |diagnostic| {
                match suggest::nearest(&parameter.name, asked.iter().copied()) {
                    Some(nearest) => diagnostic.with_help(format!("did you mean `{nearest}`?")),
                    None => diagnostic.with_note("it is ignored"),
                }
            });
        }
    }
}
