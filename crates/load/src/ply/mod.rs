//! The PLY format (Turk 1994, "The PLY Polygon File Format"): meshes as tables of vertices and faces, as text or binary
//! of either byte order.
//!
//! What is read: the vertex properties `x y z`, `nx ny nz` and one pair of `u v`, `s t`, `texture_u texture_v` or
//! `texture_s texture_t`, of any type and in any order; the face properties `vertex_indices` or `vertex_index`, and `face_indices`,
//! the number of the face among those that a texture has images for. Triangles
//! stay triangles, quadrilaterals become bilinear patches as in pbrt-v4, larger polygons become fans of triangles.
//! Every other property and element, colours among them, is skipped.
//!
//! The files may be hostile. A declared count is believed only as far as the bytes that follow can hold it.
//!
//! Deliberately absent: triangle strips, and point clouds, which have no surface.

mod faces;
mod header;
mod values;
mod vertices;

use std::fmt;
use std::sync::Arc;

use sahl_math::Transform;
use sahl_scene::{Diagnostic, Geometry, Material, Origin, PatchMesh, SceneDesc, Shape, Span, TriangleMesh};

use crate::words::span;
use crate::{Loaded, framing, gzip, normals};
use faces::Faces;
use header::{Element, Format, Header};
use values::{Ascii, Binary, Values};
use vertices::Vertices;

/// What a PLY file holds; at least one of the meshes is there. They share their vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PlyMesh {
    /// The faces with three vertices, and those with more than four, split.
    pub(crate) triangles: Option<TriangleMesh>,
    /// The faces with four vertices.
    pub(crate) patches: Option<PatchMesh>,
    /// What was left out or repaired.
    pub(crate) warnings: Vec<String>,
}

/// Why a PLY file could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PlyError {
    /// What is wrong.
    pub(crate) message: String,
    /// Where, in bytes from the start of the file.
    pub(crate) offset: usize,
    /// The line from one, in the header and in files of text.
    pub(crate) line: Option<usize>,
}

impl fmt::Display for PlyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}", self.message),
            None => write!(f, "byte {}: {}", self.offset, self.message),
        }
    }
}

impl std::error::Error for PlyError {}

impl PlyError {
    fn at(offset: usize, message: impl Into<String>) -> Self {
        Self { message: message.into(), offset, line: None }
    }

    /// Finds the line, if `text`, the part of the file that is text, reaches that far.
    fn with_line(self, text: &[u8]) -> Self {
        let before = text.get(..self.offset);
        let line = before.map(|before| {
            let ends = |byte: u8| before.iter().filter(|&&b| b == byte).count();
            // Lines end with a line feed, or with a carriage return alone.
            1 + if ends(b'\n') > 0 { ends(b'\n') } else { ends(b'\r') }
        });
        Self { line, ..self }
    }
}

/// Reads a PLY file, which must not be compressed.
///
/// # Errors
/// [`PlyError`] if the header is not understood, the file ends early, an index is out of range, a coordinate is not
/// finite, or no face is left.
pub(crate) fn read(bytes: &[u8]) -> Result<PlyMesh, PlyError> {
    let located = |error: PlyError| error.with_line(text(bytes));
    let header = Header::read(bytes).map_err(located)?;
    read_body(&header, bytes).map_err(located)
}

/// Reads a PLY file, which may be compressed, as a scene: grey, and framed.
pub(crate) fn load(name: &str, bytes: Vec<u8>) -> Loaded {
    let bytes = match gzip::decompress(bytes) {
        Ok(bytes) => bytes,
        Err(error) => return Loaded::failed("unreadable-file", format!("can't read `{name}`: {error}")),
    };
    let mut loaded = Loaded::default();
    let file = loaded.sources.add(name, text(&bytes));
    match read(&bytes) {
        Ok(mesh) => {
            let origin = Origin::at(Span::of_file(file));
            for warning in &mesh.warnings {
                loaded.diagnostics.push(Diagnostic::warning("bad-mesh", origin.span, warning));
            }
            add_shapes(&mut loaded.scene, mesh, &origin);
            framing::frame(&mut loaded.scene);
        }
        Err(error) => {
            let place = span(file, error.offset, error.offset + 1);
            let message = if error.line.is_some() { error.message } else { error.to_string() };
            loaded.diagnostics.push(Diagnostic::error("bad-mesh", place, message));
        }
    }
    loaded
}

fn add_shapes(scene: &mut SceneDesc, mesh: PlyMesh, origin: &Origin) {
    let material = scene.materials.push(Material::default(), Origin::default());
    let triangles =
        mesh.triangles.map(|mesh| Geometry::Triangles(scene.triangle_meshes.push(mesh, origin.clone())));
    let patches = mesh.patches.map(|mesh| Geometry::Patches(scene.patch_meshes.push(mesh, origin.clone())));
    for geometry in triangles.into_iter().chain(patches) {
        let shape = Shape::new(geometry, Transform::IDENTITY, material);
        let shape = scene.shapes.push(shape, origin.clone());
        scene.world.push(shape);
    }
}

/// The part of a PLY file that is text: all of it, or the header of a binary one.
pub(crate) fn text(bytes: &[u8]) -> &[u8] {
    match Header::read(bytes) {
        Ok(header) if header.format != Format::Ascii => &bytes[..header.body],
        Ok(_) => bytes,
        // What looks like text, in pieces: whatever follows may be binary.
        Err(error) => {
            let end = bytes[error.offset..].iter().position(|&byte| byte == b'\n' || byte == b'\r');
            &bytes[..end.map_or(bytes.len(), |end| error.offset + end)]
        }
    }
}

fn read_body(header: &Header, bytes: &[u8]) -> Result<PlyMesh, PlyError> {
    match header.format {
        Format::Ascii => read_elements(header, Ascii::new(bytes, header.body)),
        Format::LittleEndian => read_elements(header, Binary::<false>::new(bytes, header.body)),
        Format::BigEndian => read_elements(header, Binary::<true>::new(bytes, header.body)),
    }
}

fn read_elements(header: &Header, mut values: impl Values) -> Result<PlyMesh, PlyError> {
    let vertex_element = header.element("vertex")?;
    let vertex_count = u32::try_from(vertex_element.count).map_err(|_| {
        PlyError::at(
            vertex_element.offset,
            format!("{} vertices are more than indices can tell", vertex_element.count),
        )
    })?;
    let face_element = header.element("face")?;
    let mut warnings = Vec::new();
    let mut vertices = Vertices::default();
    let mut faces = Faces::default();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => vertices = Vertices::read(element, &mut values, &mut warnings)?,
            "face" => faces = Faces::read(element, vertex_count, &mut values)?,
            _ => skip_element(element, &mut values)?,
        }
    }
    if values.has_more() {
        warnings.push(format!("what follows the last element, from byte {} on, is ignored", values.offset()));
    }
    faces.warn(&mut warnings);
    if faces.triangles.is_empty() && faces.quads.is_empty() {
        return Err(PlyError::at(face_element.offset, "no face has an area: there is nothing to render"));
    }
    vertices.repair(&faces, &mut warnings);
    Ok(assemble(vertices, faces, warnings))
}

fn skip_element(element: &Element, values: &mut impl Values) -> Result<(), PlyError> {
    // An element without properties takes no bytes, however many of it there are said to be.
    let rows = if element.properties.is_empty() { 0 } else { element.count };
    for row in 0..rows {
        for property in &element.properties {
            values.skip(property.kind).map_err(|error| element.in_row(row, error))?;
        }
    }
    Ok(())
}

fn assemble(vertices: Vertices, faces: Faces, warnings: Vec<String>) -> PlyMesh {
    let positions: Arc<[_]> = vertices.positions.into();
    let normals: Option<Arc<[_]>> = vertices.normals.map(Into::into);
    let uvs: Option<Arc<[_]>> = vertices.uvs.map(Into::into);
    let triangles = (!faces.triangles.is_empty()).then(|| TriangleMesh {
        indices: faces.triangles.into(),
        positions: Arc::clone(&positions),
        normals: normals.clone(),
        tangents: None,
        uvs: uvs.clone(),
        face_indices: faces.triangle_numbers.map(Into::into),
    });
    let patches = (!faces.quads.is_empty()).then(|| PatchMesh {
        indices: faces.quads.into(),
        positions,
        normals,
        tangents: None,
        uvs,
        face_indices: faces.quad_numbers.map(Into::into),
    });
    PlyMesh { triangles, patches, warnings }
}

impl Vertices {
    /// Computes the normals that the file has as zero or as NaN from the faces about the vertex.
    fn repair(&mut self, faces: &Faces, warnings: &mut Vec<String>) {
        let Some(file_normals) = &mut self.normals else { return };
        // A patch's corners lie at (0,0), (1,0), (0,1), (1,1): its outline passes them in the order 0 1 3 2.
        let quads = faces.quads.iter().flat_map(|&[a, b, d, c]| [[a, b, c], [a, c, d]]);
        let triangles = faces.triangles.iter().copied().chain(quads);
        let repaired = normals::repair(file_normals, &self.positions, triangles);
        if repaired > 0 {
            warnings.push(format!("{repaired} normals without direction are computed from the faces"));
        }
    }
}

#[cfg(test)]
mod tests;
