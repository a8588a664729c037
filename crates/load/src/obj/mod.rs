//! The Wavefront OBJ format: polygons with texture coordinates and normals, sorted by material.
//!
//! Everything of one material becomes one mesh of triangles, whatever objects and groups (`o`, `g`) it is in; polygons
//! are triangulated, convex or not. Indices may count from the start or, negative, from the latest. Corners that agree in
//! position, texture coordinate and normal share a vertex. Without normals (`vn`) faces are flat; smoothing groups (`s`)
//! are not honoured, and that is told. Materials come from MTL files (see [`crate::mtl`]).
//!
//! The reader is our own. The crate `tobj` was looked at first: its errors (4.0.5) name a kind of mistake and neither a
//! line nor a word, and the first one ends the reading, which rules out what a diagnostic has to say.
//!
//! Deliberately absent: points, lines, free-form curves and surfaces, which have no polygons.

mod mesh;
mod parse;
mod polygon;

use std::path::Path;

use sahl_math::Transform;
use sahl_scene::{Diagnostic, Geometry, Handle, Material, Origin, Shape, Span, suggest};

use crate::framing;
use crate::mtl::{Library, MtlMaterial};
use crate::words::Messages;
use crate::{AssetSource, Loaded, gzip};
use mesh::{Built, MeshBuilder};
use parse::{Group, ObjFile};

/// Reads an OBJ file, which may be compressed, with the materials and textures it names, and frames it.
pub(crate) fn load(name: &str, bytes: Vec<u8>, assets: &dyn AssetSource) -> Loaded {
    let text = match gzip::decompress(bytes) {
        Ok(text) => text,
        Err(error) => return Loaded::failed("unreadable-file", format!("can't read `{name}`: {error}")),
    };
    let mut loaded = Loaded::default();
    let file = loaded.sources.add(name, text);
    let text = std::sync::Arc::clone(&loaded.sources.file(file).text);
    let mut messages = Messages::new(file);
    let contents = parse::parse(&text, &mut messages);
    let library = read_libraries(&contents, Path::new(name), assets, &mut loaded, &mut messages);
    let mut scene =
        Assembly { loaded: &mut loaded, messages: &mut messages, library, default_material: None };
    let shapes = scene.add_shapes(&contents, assets);
    if shapes == 0 && !messages.has_errors() {
        let diagnostic = Diagnostic::error(
            "empty-mesh",
            Span::of_file(file),
            "no face has an area: there is nothing to render",
        );
        messages.push(diagnostic);
    }
    loaded.diagnostics.extend(messages.finish());
    framing::frame(&mut loaded.scene);
    loaded
}

fn read_libraries(
    contents: &ObjFile,
    obj: &Path,
    assets: &dyn AssetSource,
    loaded: &mut Loaded,
    messages: &mut Messages,
) -> Library {
    let mut library = Library::default();
    for entry in &contents.libraries {
        let path = obj.parent().unwrap_or(Path::new("")).join(entry.path.replace('\\', "/"));
        match assets.read(&path) {
            Ok(bytes) => library.read(&path, bytes, &mut loaded.sources, &mut loaded.diagnostics),
            Err(error) => {
                library.lacks_a_file();
                let message = format!("can't read `{}`: {}", path.display(), crate::assets::describe(&error));
                let diagnostic = Diagnostic::warning("unreadable-file", entry.span, message);
                messages.push(diagnostic.with_note("surfaces with materials of this file are grey"));
            }
        }
    }
    library
}

/// The scene that is being put together.
struct Assembly<'a> {
    loaded: &'a mut Loaded,
    messages: &'a mut Messages,
    library: Library,
    default_material: Option<Handle<Material>>,
}

impl Assembly<'_> {
    /// Adds a shape for each material that has triangles. Returns the number of shapes.
    fn add_shapes(&mut self, contents: &ObjFile, assets: &dyn AssetSource) -> usize {
        let mut builder = MeshBuilder::new(contents);
        let (mut degenerate, mut repaired) = (0, 0);
        for group in &contents.groups {
            let built = builder.build(group);
            degenerate += built.degenerate;
            repaired += built.repaired;
            if !built.mesh.indices.is_empty() {
                self.add_shape(group, built, assets);
            }
        }
        let file = Span::of_file(self.messages.file);
        if degenerate > 0 {
            let message =
                format!("{degenerate} triangles with fewer than three different vertices are left out");
            self.messages.push(Diagnostic::warning("degenerate-face", file, message));
        }
        if repaired > 0 {
            let message = format!("{repaired} normals without direction are computed from the faces");
            self.messages.push(Diagnostic::warning("bad-normal", file, message));
        }
        self.library.report(&mut self.loaded.diagnostics);
        self.loaded.scene.world.len()
    }

    fn add_shape(&mut self, group: &Group, built: Built, assets: &dyn AssetSource) {
        let MtlMaterial { material, area_light } = self.material(group, assets);
        let scene = &mut self.loaded.scene;
        let origin = Origin { name: group.material.clone(), span: group.span };
        let mesh = scene.triangle_meshes.push(built.mesh, origin.clone());
        let shape =
            Shape { area_light, ..Shape::new(Geometry::Triangles(mesh), Transform::IDENTITY, material) };
        let shape = scene.shapes.push(shape, origin);
        scene.world.push(shape);
    }

    fn material(&mut self, group: &Group, assets: &dyn AssetSource) -> MtlMaterial {
        let Some(name) = &group.material else { return self.grey() };
        let Loaded { scene, diagnostics, .. } = &mut *self.loaded;
        if let Some(material) = self.library.material(name, scene, diagnostics, assets) {
            return material;
        }
        // Where a library could not be read, that has been told.
        if self.library.is_complete() {
            let nearest = suggest::nearest(name, self.library.names());
            let message = format!("no material is called `{name}`; grey is used");
            let diagnostic = Diagnostic::warning("unknown-material", group.span, message);
            self.messages.push(match nearest {
                Some(nearest) => diagnostic.with_help(format!("did you mean `{nearest}`?")),
                None => diagnostic,
            });
        }
        self.grey()
    }

    fn grey(&mut self) -> MtlMaterial {
        let materials = &mut self.loaded.scene.materials;
        let new = || materials.push(Material::default(), Origin::default());
        MtlMaterial { material: *self.default_material.get_or_insert_with(new), area_light: None }
    }
}

#[cfg(test)]
mod tests;
