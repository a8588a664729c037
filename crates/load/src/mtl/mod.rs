//! The MTL format: the materials of OBJ files, in terms of Sahl's materials.
//!
//! The format describes a shading formula of 1988. What is made of it:
//!
//! | in the file | in the scene |
//! |---|---|
//! | `illum` 4, 6, 7 or 9, or opacity (`d`, or 1 − `Tr`) below 0.5 | smooth dielectric, η = `Ni` if above 1, else 1.5 |
//! | `Pm` of 0.5 or more | conductor, reflectance `Kd`, α = `Pr`² |
//! | `illum` 3 or 5 and `Ks` at least as bright as `Kd` | conductor, reflectance `Ks`, α = √(2 / (`Ns` + 2)) |
//! | anything else | diffuse, reflectance `Kd` × `map_Kd`; 0.5 if neither is there |
//! | `Ke` above zero | besides, emitted radiance `Ke`, on both sides: the sides of faces can't be trusted |
//!
//! Colours are linear sRGB, as most programs write them; image files decide about their own encoding. A black `Kd` beside
//! `map_Kd` counts as white, because exporters write that. α from `Ns` is the width of the Beckmann lobe with the same
//! peak as Phong's (Walter et al. 2007, section 5.1). `-s` and `-o` of a texture become its scale and offset, `-clamp on`
//! its border; textures are looked for from the directory of the MTL file, and then, by their name alone, in it.
//!
//! `Ka`, `map_Ka` and the other numbers of `illum` have no counterpart, since indirect light is computed. Everything else
//! that is there and not honoured is told, once a kind, with the materials it concerns.

mod material;
mod statement;
mod texture;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use sahl_scene::{AreaLight, Diagnostic, Diagnostics, Handle, Material, Origin, SceneDesc, Sources, Span};

use crate::words::Messages;
use crate::{AssetSource, gzip};
use statement::Statements;
use texture::Textures;

/// A material of an MTL file in the scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MtlMaterial {
    pub(crate) material: Handle<Material>,
    pub(crate) area_light: Option<AreaLight>,
}

/// The materials of the MTL files of a scene.
#[derive(Default)]
pub(crate) struct Library {
    entries: Vec<Statements>,
    by_name: BTreeMap<String, usize>,
    /// The materials that are in the scene.
    built: BTreeMap<usize, MtlMaterial>,
    textures: Textures,
    /// By what is not honoured: where it is first, and the materials.
    not_honoured: BTreeMap<&'static str, (Span, Vec<String>)>,
    lacks_a_file: bool,
}

impl Library {
    /// Adds the materials of an MTL file. Of several with one name the first counts.
    pub(crate) fn read(
        &mut self,
        path: &Path,
        bytes: Vec<u8>,
        sources: &mut Sources,
        diagnostics: &mut Diagnostics,
    ) {
        let name = path.to_string_lossy();
        let text = match gzip::decompress(bytes) {
            Ok(text) => text,
            Err(error) => {
                self.lacks_a_file = true;
                let message = format!("can't read `{name}`: {error}");
                diagnostics.push(Diagnostic::warning("unreadable-file", None, message));
                return;
            }
        };
        let file = sources.add(name, text);
        let text = Arc::clone(&sources.file(file).text);
        let mut messages = Messages::new(file);
        let directory = path.parent().unwrap_or(Path::new(""));
        for entry in statement::parse(&text, directory, &mut messages) {
            let index = self.entries.len();
            if *self.by_name.entry(entry.name.clone()).or_insert(index) == index {
                self.entries.push(entry);
            } else {
                let message = format!("a second material `{}` is left out", entry.name);
                messages.push(Diagnostic::warning("second-material", entry.span, message));
            }
        }
        diagnostics.extend(messages.finish());
    }

    /// Says that a file of materials could not be read.
    pub(crate) fn lacks_a_file(&mut self) {
        self.lacks_a_file = true;
    }

    /// Whether every file was read.
    pub(crate) fn is_complete(&self) -> bool {
        !self.lacks_a_file
    }

    /// The names of the materials.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().map(String::as_str)
    }

    /// The material called `name`, added to the scene with its textures when it is first asked for.
    pub(crate) fn material(
        &mut self,
        name: &str,
        scene: &mut SceneDesc,
        diagnostics: &mut Diagnostics,
        assets: &dyn AssetSource,
    ) -> Option<MtlMaterial> {
        let index = *self.by_name.get(name)?;
        if let Some(built) = self.built.get(&index) {
            return Some(built.clone());
        }
        let entry = &self.entries[index];
        let mut unheeded = entry.unheeded.clone();
        let texture = self.textures.add(entry, scene, diagnostics, assets, &mut unheeded);
        let (material, area_light) = material::translate(entry, texture, &mut unheeded);
        for (what, span) in unheeded {
            let (_, names) = self.not_honoured.entry(what).or_insert((span, Vec::new()));
            if !names.contains(&entry.name) {
                names.push(entry.name.clone());
            }
        }
        let material = scene.materials.push(material, Origin::named(name, entry.span));
        let built = MtlMaterial { material, area_light };
        self.built.insert(index, built.clone());
        Some(built)
    }

    /// Tells what the materials that are in the scene ask for in vain.
    pub(crate) fn report(&mut self, diagnostics: &mut Diagnostics) {
        for (what, (span, names)) in std::mem::take(&mut self.not_honoured) {
            let diagnostic = Diagnostic::warning("not-honoured", span, what);
            diagnostics.push(diagnostic.with_note(format!("in {}", list(&names))));
        }
    }
}

/// `material `a``, or `materials `a`, `b` and 7 more`.
fn list(names: &[String]) -> String {
    const SHOWN: usize = 6;
    let quoted: Vec<String> = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect();
    let more = names.len().saturating_sub(SHOWN);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let plural = if names.len() == 1 { "material" } else { "materials" };
    format!("{plural} {}{more}", quoted.join(", "))
}

#[cfg(test)]
mod tests;
