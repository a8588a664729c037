//! Scenes: one mesh and Embree's tree over it.

use std::sync::Arc;

use sahl_accel::TriangleMesh;

use super::device::Device;
use super::ffi::{self, SceneHandle};
use crate::Result;

/// Build quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quality {
    /// Binned SAH; the default.
    Medium,
    /// With spatial splits.
    High,
}

/// A mesh handed over to Embree, without a tree, so that nothing can be asked of it.
#[derive(Debug)]
pub(crate) struct Draft(Scene);

/// A mesh with Embree's tree over it, which does not change any more.
#[derive(Debug)]
pub(crate) struct Scene {
    pub(super) device: Arc<Device>,
    pub(super) handle: SceneHandle,
    /// Read by Embree as long as the scene lives.
    vertices: Vec<f32>,
    /// As above.
    mesh: TriangleMesh,
}

// SAFETY: Embree's scenes may be used and released from any thread; while they change, in [`Draft`], one thread owns them.
unsafe impl Send for Scene {}
// SAFETY: queries on a committed scene are meant for any number of threads at once, and a draft offers none.
unsafe impl Sync for Scene {}

impl Draft {
    /// A scene of the mesh, whose buffers are shared with Embree.
    ///
    /// # Errors
    /// An index is out of range, which Embree would not notice, or Embree refuses.
    pub(crate) fn new(
        device: &Arc<Device>,
        mesh: &TriangleMesh,
        quality: Quality,
        robust: bool,
    ) -> Result<Self> {
        let api = &device.api;
        let count = mesh.positions.len();
        if let Some(index) = mesh.indices.as_flattened().iter().find(|index| **index as usize >= count) {
            return Err(format!("vertex {index} of a mesh of {count}").into());
        }
        // Embree reads vertices by loads of 16 bytes: room for one float after the last.
        let vertices: Vec<f32> =
            mesh.positions.iter().flat_map(|&p| <[f32; 3]>::from(p)).chain([0.0; 4]).collect();
        let quality = match quality {
            Quality::Medium => ffi::BUILD_QUALITY_MEDIUM,
            Quality::High => ffi::BUILD_QUALITY_HIGH,
        };
        // SAFETY: the device is alive.
        let handle = unsafe { (api.new_scene)(device.handle) };
        if handle.is_null() {
            device.check()?;
            return Err("Embree makes no scene".into());
        }
        let scene = Scene { device: Arc::clone(device), handle, vertices, mesh: mesh.clone() };
        // SAFETY: the scene is alive, and the values are those of its flags and qualities.
        unsafe {
            (api.set_scene_flags)(handle, if robust { ffi::SCENE_FLAG_ROBUST } else { ffi::SCENE_FLAG_NONE });
            (api.set_scene_build_quality)(handle, quality);
        }
        scene.attach_mesh();
        device.check()?;
        Ok(Self(scene))
    }

    /// Builds the tree.
    ///
    /// # Errors
    /// Embree fails.
    pub(crate) fn commit(self) -> Result<Scene> {
        let Self(scene) = self;
        // SAFETY: the scene is alive and not in use, since only its draft knew it.
        unsafe {
            (scene.device.api.commit_scene)(scene.handle);
        }
        scene.device.check()?;
        Ok(scene)
    }
}

impl Scene {
    /// Makes the scene's mesh its geometry.
    fn attach_mesh(&self) {
        let api = &self.device.api;
        let vertices = (ffi::BUFFER_TYPE_VERTEX, ffi::FORMAT_FLOAT3, self.vertices.as_ptr().cast());
        let indices = (ffi::BUFFER_TYPE_INDEX, ffi::FORMAT_UINT3, self.mesh.indices.as_ptr().cast());
        let counts = [self.mesh.positions.len(), self.mesh.indices.len()];
        // SAFETY: handles are alive; the buffers hold as many elements of three times four bytes as is said, in these formats, with
        // indices in range and the padding that Embree asks for, at heap addresses that stay when the scene is moved, and live as long
        // as it.
        unsafe {
            let geometry = (api.new_geometry)(self.device.handle, ffi::GEOMETRY_TYPE_TRIANGLE);
            for ((kind, format, start), count) in [vertices, indices].into_iter().zip(counts) {
                (api.set_shared_geometry_buffer)(geometry, kind, 0, format, start, 0, 12, count);
            }
            (api.commit_geometry)(geometry);
            (api.attach_geometry)(self.handle, geometry);
            (api.release_geometry)(geometry);
        }
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: the handle came from `rtcNewScene` and is released once, before the buffers are freed.
        unsafe {
            (self.device.api.release_scene)(self.handle);
        }
    }
}
