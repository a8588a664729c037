//! Meshes, curves and images.

use sahl_image::Pixels;
use sahl_math::Vec3;

use super::{Check, called};
use crate::{Arena, CurveKind, Curves, Mesh, Origin};

impl Check<'_> {
    pub(super) fn meshes(&mut self) {
        self.meshes_of("triangle mesh", &self.scene.triangle_meshes);
        self.meshes_of("patch mesh", &self.scene.patch_meshes);
    }

    fn meshes_of<const N: usize>(&mut self, kind: &str, meshes: &Arena<Mesh<N>>) {
        for (handle, mesh) in meshes.iter() {
            self.mesh(kind, mesh, meshes.origin(handle));
        }
    }

    /// One message of each kind a mesh, for the first vertex or face that is wrong.
    fn mesh<const N: usize>(&mut self, kind: &str, mesh: &Mesh<N>, origin: &Origin) {
        let owner = called(kind, origin);
        let count = mesh.positions.len();
        if mesh.indices.is_empty() {
            self.error("empty-mesh", origin, format!("{owner} has no faces"));
        }
        let indices = mesh.indices.as_flattened();
        if let Some(at) = indices.iter().position(|&index| index as usize >= count) {
            let message = format!("face {} of {owner} refers to vertex {} of {count}", at / N, indices[at]);
            self.error("index-out-of-range", origin, message);
        }
        if let Some(vertex) = mesh.positions.iter().position(|position| !position.is_finite()) {
            let message = format!("the position of vertex {vertex} of {owner} is not finite");
            self.error("bad-number", origin, message);
        }
        let first_bad = |all: &[Vec3]| (all.len(), all.iter().position(|v| !v.is_finite()));
        self.attribute(&owner, "normal", count, mesh.normals.as_deref().map(first_bad), origin);
        self.attribute(&owner, "tangent", count, mesh.tangents.as_deref().map(first_bad), origin);
        let bad_uv = mesh.uvs.as_ref().map(|all| (all.len(), all.iter().position(|uv| !uv.is_finite())));
        self.attribute(&owner, "texture coordinate", count, bad_uv, origin);
        if let Some(numbers) = mesh.face_indices.as_ref().filter(|all| all.len() != mesh.indices.len()) {
            let message =
                format!("{owner} has {} face indices for {} faces", numbers.len(), mesh.indices.len());
            self.error("attribute-count", origin, message);
        }
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

    pub(super) fn curves(&mut self) {
        let scene = self.scene;
        for (handle, curves) in scene.curves.iter() {
            let origin = scene.curves.origin(handle);
            let owner = called("curve", origin);
            if curves.points.is_empty() {
                self.error("empty-mesh", origin, format!("{owner} has no segments"));
            }
            self.curve_counts(&owner, curves, origin);
            let points = curves.points.iter().position(|all| !all.iter().all(|p| p.is_finite()));
            let is_width = |width: &f32| width.is_finite() && *width >= 0.0;
            let widths = curves.widths.iter().position(|ends| !ends.iter().all(is_width));
            let is_bad = |ends: &[Vec3; 2]| !ends.iter().all(|n| n.is_finite());
            let normals = curves.normals.iter().position(is_bad);
            for (segment, what) in [
                (points, "a control point is not finite"),
                (widths, "a width is negative or not finite"),
                (normals, "a normal is not finite"),
            ] {
                if let Some(segment) = segment {
                    self.error("bad-number", origin, format!("segment {segment} of {owner}: {what}"));
                }
            }
        }
    }

    fn curve_counts(&mut self, owner: &str, curves: &Curves, origin: &Origin) {
        let count = curves.points.len();
        let normals = if curves.kind == CurveKind::Ribbon { count } else { 0 };
        for (what, found, expected) in
            [("widths", curves.widths.len(), count), ("normals", curves.normals.len(), normals)]
        {
            if found != expected {
                let message = format!("{owner} has {found} pairs of {what}: expected {expected}");
                self.error("attribute-count", origin, message);
            }
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
