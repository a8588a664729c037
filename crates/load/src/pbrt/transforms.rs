//! Directives that change the current transforms, and named coordinate systems.

use sahl_math::Transform;
use sahl_scene::Diagnostic;

use super::interpreter::Interpreter;
use super::report::quote;
use super::statement::{Directive, Statement};

impl Interpreter<'_> {
    pub(super) fn transform(&mut self, statement: &Statement) {
        let n = &statement.numbers[..];
        let after = |change: Option<Transform>| move |current: &Transform| current.after(&change?);
        let changed = match (statement.rule.directive, n) {
            (Directive::Identity, _) => self.state.change(|_| Some(Transform::IDENTITY)),
            (Directive::Translate, &[x, y, z]) => self.state.change(after(Transform::translate(x, y, z))),
            (Directive::Scale, &[x, y, z]) => self.state.change(after(Transform::scale(x, y, z))),
            (Directive::Rotate, &[degrees, x, y, z]) => {
                self.state.change(after(Transform::rotate(degrees.to_radians(), [x, y, z])))
            }
            (Directive::LookAt, &[ex, ey, ez, lx, ly, lz, ux, uy, uz]) => {
                self.state.change(after(Transform::look_at([ex, ey, ez], [lx, ly, lz], [ux, uy, uz])))
            }
            (directive, numbers) => {
                let matrix = <[f64; 16]>::try_from(numbers).ok().and_then(Transform::from_columns);
                match directive {
                    Directive::Transform => self.state.change(|_| matrix),
                    _ => self.state.change(after(matrix)),
                }
            }
        };
        if changed.is_none() {
            self.bad_transform(statement);
        }
    }

    fn bad_transform(&self, statement: &Statement) {
        let reason = match statement.rule.directive {
            Directive::Scale => "a factor is zero, or makes the transform too large or too small",
            Directive::Rotate => "its axis has no direction",
            Directive::LookAt => "eye, target and up direction do not span a view",
            Directive::Translate => "the transform becomes too large",
            _ => "the matrix is singular, projective or too large",
        };
        let message = format!("`{}` can't be applied: {reason}", statement.rule.name);
        self.report().error("singular-transform", statement.span, message);
    }

    pub(super) fn active_transform(&mut self, statement: &Statement) {
        const TIMES: &[(&str, [bool; 2])] =
            &[("StartTime", [true, false]), ("EndTime", [false, true]), ("All", [true, true])];
        let [word] = &statement.names[..] else { return };
        match TIMES.iter().find(|(name, _)| *name == word.text) {
            Some((_, active)) => self.state.active = *active,
            None => {
                let message = format!("unknown time {}", quote(word.text.as_bytes()));
                let diagnostic = Diagnostic::error("unknown-value", word.span, message);
                self.report().push_with_choices(diagnostic, &word.text, TIMES.iter().map(|(name, _)| *name));
            }
        }
    }

    pub(super) fn transform_times(&mut self, statement: &Statement) {
        let [start, end] = statement.numbers[..] else { return };
        if start > end {
            let message = format!("transforms start at {start} and end before that, at {end}");
            self.report().error("invalid-value", statement.span, message);
            return;
        }
        self.transform_times = [start as f32, end as f32];
    }

    pub(super) fn coordinate_system(&mut self, statement: &Statement) {
        for name in &statement.names {
            self.coordinate_systems.insert(name.text.clone(), self.state.transforms);
        }
    }

    pub(super) fn coordinate_system_transform(&mut self, statement: &Statement) {
        let [name] = &statement.names[..] else { return };
        if let Some(transforms) = self.coordinate_systems.get(&name.text) {
            self.state.transforms = *transforms;
            return;
        }
        let message = format!("there is no coordinate system called {}", quote(name.text.as_bytes()));
        let diagnostic = Diagnostic::error("unknown-coordinate-system", name.span, message);
        let names = self.coordinate_systems.keys().map(String::as_str);
        self.report().push_with_choices(diagnostic, &name.text, names);
    }
}
