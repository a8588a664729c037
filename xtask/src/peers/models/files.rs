//! Meshes from files.

use std::path::Path;

use sahl_accel::TriangleMesh;
use sahl_load::DiskAssets;
use sahl_math::Vec3;
use sahl_scene::{Geometry, SceneDesc, Severity};

use crate::Result;

/// All triangles of a file as one mesh, in world space.
///
/// # Errors
/// The file can't be read or has errors or no triangles.
pub(crate) fn mesh(path: &Path) -> Result<TriangleMesh> {
    let loaded = sahl_load::load(path, &DiskAssets);
    if let Some(error) = loaded.diagnostics.iter().find(|diagnostic| diagnostic.severity == Severity::Error) {
        return Err(format!("{}: {}", path.display(), error.message).into());
    }
    let mesh = merge(&loaded.scene);
    if mesh.indices.is_empty() {
        return Err(format!("{} has no triangles", path.display()).into());
    }
    Ok(mesh)
}

fn merge(scene: &SceneDesc) -> TriangleMesh {
    let (mut indices, mut positions): (Vec<[u32; 3]>, Vec<Vec3>) = Default::default();
    for shape in scene.shapes.values() {
        let Geometry::Triangles(handle) = shape.geometry else { continue };
        let Some(mesh) = scene.triangle_meshes.get(handle) else { continue };
        let base = positions.len() as u32;
        indices.extend(mesh.indices.iter().map(|triangle| triangle.map(|index| index + base)));
        positions.extend(mesh.positions.iter().map(|&p| shape.shape_to_world.point(p)));
    }
    TriangleMesh { indices: indices.into(), positions: positions.into() }
}
