//! Meshes and images.

use sahl_image::Pixels;
use sahl_math::{Vec2, Vec3};

use super::{Check, called};
use crate::Origin;

/// What the two kinds of meshes have in common.
struct Mesh<'a> {
    faces: usize,
    indices: &'a [u32],
    positions: &'a [Vec3],
    normals: Option<&'a [Vec3]>,
    uvs: Option<&'a [Vec2]>,
}

impl Check<'_> {
    pub(super) fn meshes(&mut self) {
        let scene = self.scene;
        for (handle, mesh) in scene.triangle_meshes.iter() {
            let parts = Mesh {
                faces: mesh.indices.len(),
                indices: mesh.indices.as_flattened(),
                positions: &mesh.positions,
                normals: mesh.normals.as_deref(),
                uvs: mesh.uvs.as_deref(),
            };
            self.mesh("triangle mesh", &parts, scene.triangle_meshes.origin(handle));
        }
        for (handle, mesh) in scene.patch_meshes.iter() {
            let parts = Mesh {
                faces: mesh.indices.len(),
                indices: mesh.indices.as_flattened(),
                positions: &mesh.positions,
                normals: mesh.normals.as_deref(),
                uvs: mesh.uvs.as_deref(),
            };
            self.mesh("patch mesh", &parts, scene.patch_meshes.origin(handle));
        }
    }

    /// One message of each kind a mesh, for the first vertex or face that is wrong.
    fn mesh(&mut self, kind: &str, mesh: &Mesh<'_>, origin: &Origin) {
        let owner = called(kind, origin);
        let count = mesh.positions.len();
        if mesh.faces == 0 {
            self.error("empty-mesh", origin, format!("{owner} has no faces"));
        }
        if let Some(at) = mesh.indices.iter().position(|&index| index as usize >= count) {
            let (face, index) = (at / (mesh.indices.len() / mesh.faces), mesh.indices[at]);
            let message = format!("face {face} of {owner} refers to vertex {index} of {count}");
            self.error("index-out-of-range", origin, message);
        }
        if let Some(vertex) = mesh.positions.iter().position(|position| !position.is_finite()) {
            self.error(
                "bad-number",
                origin,
                format!("the position of vertex {vertex} of {owner} is not finite"),
            );
        }
        let bad_normal =
            mesh.normals.map(|all| (all.len(), all.iter().position(|normal| !normal.is_finite())));
        self.attribute(&owner, "normal", count, bad_normal, origin);
        let bad_uv = mesh.uvs.map(|all| (all.len(), all.iter().position(|uv| !uv.is_finite())));
        self.attribute(&owner, "texture coordinate", count, bad_uv, origin);
    }

    /// An attribute that each vertex must have, given by the number of its values and the first that is not finite.
    fn attribute(
        &mut self,
        owner: &str,
        what: &str,
        vertices: usize,
        values: Option<(usize, Option<usize>)>,
        origin: &Origin,
    ) {
        let Some((count, infinite)) = values else { return };
        if count != vertices {
            self.error(
                "attribute-count",
                origin,
                format!("{owner} has {count} {what}s for {vertices} vertices"),
            );
        }
        if let Some(vertex) = infinite {
            self.error(
                "bad-number",
                origin,
                format!("the {what} of vertex {vertex} of {owner} is not finite"),
            );
        }
    }

    pub(super) fn images(&mut self) {
        for (handle, image) in self.scene.images.iter() {
            let origin = self.scene.images.origin(handle);
            let owner = called("image", origin);
            let values = match &image.pixels {
                Pixels::U8(values) => values.len(),
                Pixels::F32(values) => values.len(),
            };
            let wanted =
                image.width.checked_mul(image.height).and_then(|pixels| pixels.checked_mul(image.channels));
            if image.width == 0
                || image.height == 0
                || !(1..=4).contains(&image.channels)
                || wanted != Some(values)
            {
                let message = format!(
                    "{owner} has {values} values for {} × {} pixels with {} channels",
                    image.width, image.height, image.channels
                );
                self.error("bad-image", origin, message);
            }
        }
    }
}
