//! The pbrt-v4 scene format (Pharr, Jakob, Humphreys, "pbrt-v4 File Format", pbrt.org, 2023).
//!
//! A scene goes through four stages, none of which stops at an error:
//! 1. [`lexer`] and [`number`]: bytes to tokens with their places;
//! 2. [`parser`] and [`parameter_list`]: tokens to [`statement::Statement`]s, by the table of directives in
//!    [`statement`];
//! 3. [`interpreter`]: statements to changes of the graphics state ([`state`], [`transforms`], [`scope`], [`objects`],
//!    [`materials`], [`media`], [`inclusion`], [`plugins`]);
//! 4. [`translate`]: the parameters of a plugin, asked for through a [`reader::Reader`], to a part of the scene.
//!
//! Where Sahl lacks what a file asks for, the nearest that it has is used, and a warning with its place says so.
//! Deviations from pbrt-v4: a name that is misspelt is an error with a suggestion instead of the end of the program; an
//! unknown parameter is a warning; environment maps in latitude-longitude layout are accepted; names are compared byte
//! by byte, without Unicode normalisation.

mod context;
mod inclusion;
mod interpreter;
mod lexer;
mod materials;
mod media;
mod motion;
mod number;
mod objects;
mod parameter;
mod parameter_list;
mod parser;
mod plugins;
mod reader;
mod report;
mod scope;
mod state;
mod statement;
mod transforms;
mod translate;

use sahl_scene::{Diagnostic, Span};

use crate::{AssetSource, Loaded, gzip};
use interpreter::Interpreter;

/// Reads the scene in `bytes`, which may be compressed, from the file called `name`.
pub(crate) fn read(name: &str, bytes: Vec<u8>, assets: &dyn AssetSource) -> Loaded {
    let text = match gzip::decompress(bytes) {
        Ok(text) => text,
        Err(error) => {
            let mut loaded = Loaded::default();
            // A file without text, so that the message has a place.
            let file = loaded.sources.add(name, Vec::new());
            let message = format!("can't read `{name}`: {error}");
            let span = Span { file, start: 0, end: 0 };
            loaded.diagnostics.push(Diagnostic::error("unreadable-file", span, message));
            return loaded;
        }
    };
    let mut interpreter = Interpreter::new(name, assets);
    interpreter.run(name, text);
    let (scene, diagnostics, sources) = interpreter.finish();
    Loaded { scene, diagnostics, sources }
}
