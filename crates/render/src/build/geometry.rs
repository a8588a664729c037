//! Shapes: from their own space into what the accelerator and the renderer need.

use std::sync::Arc;

use sahl_accel::{Cylinder, Disk, Instance, PatchMesh, Sphere, TriangleMesh, World};
use sahl_math::{Transform, Vec3};
use sahl_scene::{Geometry, Handle, Material, SceneDesc, Shape};

use super::lights::LightBuilder;
use crate::material;
use crate::scene::SceneStats;
use crate::shape::{
    Attributes, Border, Emitter, PatchEmitter, QuadricEmitter, QuadricShape, SphereEmitter, TriangleEmitter,
    clamp_heights, clamp_sweep, uniform_scale,
};

/// Collects geometries and their attributes, which have the same indices.
pub(super) struct GeometryBuilder<'a> {
    description: &'a SceneDesc,
    pub(super) world: World,
    pub(super) attributes: Vec<Attributes>,
    pub(super) counts: SceneStats,
    /// Whether borders of media count. They are left out where nothing else is to be seen of them.
    media: bool,
}

impl<'a> GeometryBuilder<'a> {
    pub(super) fn new(description: &'a SceneDesc, media: bool) -> Self {
        let counts = SceneStats::default();
        Self { description, world: World::default(), attributes: Vec::new(), counts, media }
    }

    /// Adds every shape of the world and of the objects, and the lights that shapes of the world are.
    pub(super) fn build(mut self, lights: &mut LightBuilder<'_>) -> Self {
        for &handle in &self.description.world {
            if !self.is_there(handle) {
                continue;
            }
            let index = self.push(handle);
            let shape = &self.description.shapes[handle];
            if let Some(area_light) = shape.area_light.as_ref().filter(|_| !self.is_open(handle)) {
                let emitters = self.emitters(shape, index);
                let span = self.description.shapes.origin(handle).span;
                self.attributes[index as usize].lights = lights.add_area(area_light, emitters, span);
            }
            self.world.world.push(index);
        }
        for object in self.description.objects.values() {
            let mut group = Vec::with_capacity(object.shapes.len());
            for &handle in &object.shapes {
                if !self.is_there(handle) {
                    continue;
                }
                group.push(self.push(handle));
                if self.description.shapes[handle].area_light.is_some() {
                    lights.refuse_instanced(self.description.shapes.origin(handle).span);
                }
            }
            self.world.groups.push(group);
        }
        for instance in self.description.instances.values() {
            let group = instance.object.index() as u32;
            self.world.instances.push(Instance { group, to_world: instance.object_to_world });
        }
        self.counts.instances = self.world.instances.len() as u64;
        self
    }

    /// Whether the shape is no more than the border of a medium.
    fn is_open(&self, shape: Handle<Shape>) -> bool {
        self.description.materials[self.description.shapes[shape].material] == Material::Interface
    }

    /// Whether the shape has anything to do with light.
    fn is_there(&self, shape: Handle<Shape>) -> bool {
        self.media || !self.is_open(shape)
    }

    /// Adds a shape's geometry and attributes; returns their index.
    fn push(&mut self, handle: Handle<Shape>) -> u32 {
        let shape = &self.description.shapes[handle];
        let to_parent = shape.shape_to_world;
        let traits = material::traits(self.description, shape.material);
        let mut attributes = Attributes {
            flip: shape.reverse_orientation,
            material: shape.material.index() as u32,
            needs_tangent: traits.needs_tangent,
            is_composed: traits.is_composed,
            normals: None,
            uvs: None,
            lights: None,
            border: Border::new(shape, self.is_open(handle)),
        };
        let geometry = match shape.geometry {
            Geometry::Triangles(mesh) => {
                let mesh = &self.description.triangle_meshes[mesh];
                attributes.flip ^= to_parent.swaps_handedness();
                attributes.normals = self.normals(mesh.normals.as_ref(), shape);
                attributes.uvs = mesh.uvs.clone();
                self.counts.triangles += mesh.indices.len() as u64;
                let (indices, positions) =
                    (mesh.indices.clone(), baked_positions(&mesh.positions, &to_parent));
                self.count_bytes(&[size_of_val(&*indices), size_of_val(&*positions)], &attributes);
                sahl_accel::Geometry::Triangles(TriangleMesh { indices, positions })
            }
            Geometry::Patches(mesh) => {
                let mesh = &self.description.patch_meshes[mesh];
                attributes.flip ^= to_parent.swaps_handedness();
                attributes.normals = self.normals(mesh.normals.as_ref(), shape);
                attributes.uvs = mesh.uvs.clone();
                self.counts.patches += mesh.indices.len() as u64;
                let (indices, positions) =
                    (mesh.indices.clone(), baked_positions(&mesh.positions, &to_parent));
                self.count_bytes(&[size_of_val(&*indices), size_of_val(&*positions)], &attributes);
                sahl_accel::Geometry::Patches(PatchMesh { indices, positions })
            }
            Geometry::Sphere { radius, z_min, z_max, phi_max } => {
                sahl_accel::Geometry::Sphere(Sphere { radius, z_min, z_max, phi_max, to_parent })
            }
            Geometry::Disk { height, radius, inner_radius, phi_max } => {
                sahl_accel::Geometry::Disk(Disk { height, radius, inner_radius, phi_max, to_parent })
            }
            Geometry::Cylinder { radius, z_min, z_max, phi_max } => {
                sahl_accel::Geometry::Cylinder(Cylinder { radius, z_min, z_max, phi_max, to_parent })
            }
        };
        if !matches!(shape.geometry, Geometry::Triangles(_) | Geometry::Patches(_)) {
            self.counts.quadrics += 1;
        }
        self.world.geometries.push(geometry);
        self.attributes.push(attributes);
        (self.attributes.len() - 1) as u32
    }

    /// Unit shading normals in the space of the positions, on the front: pbrt turns them round with the shape.
    fn normals(&self, normals: Option<&Arc<[Vec3]>>, shape: &Shape) -> Option<Arc<[Vec3]>> {
        let sign = if shape.reverse_orientation { -1.0 } else { 1.0 };
        let to_parent = &shape.shape_to_world;
        let bake = |n: &Vec3| to_parent.normal(*n).try_normalize().unwrap_or(Vec3::ZERO) * sign;
        normals.map(|normals| normals.iter().map(bake).collect())
    }

    fn count_bytes(&mut self, sizes: &[usize], attributes: &Attributes) {
        let normals = attributes.normals.as_ref().map_or(0, |normals| size_of_val(&**normals));
        let uvs = attributes.uvs.as_ref().map_or(0, |uvs| size_of_val(&**uvs));
        self.counts.data_bytes += (sizes.iter().sum::<usize>() + normals + uvs) as u64;
    }

    /// The primitives of a shape of the world as emitters, in order.
    fn emitters(&self, shape: &Shape, index: u32) -> Vec<Emitter> {
        let Attributes { flip, normals, .. } = &self.attributes[index as usize];
        let (flip, to_world) = (*flip, &shape.shape_to_world);
        match &self.world.geometries[index as usize] {
            sahl_accel::Geometry::Triangles(mesh) => {
                let emitter = |&indices: &[u32; 3]| {
                    let vertices = gather(&mesh.positions, indices);
                    let normals = normals.as_ref().map(|normals| gather(normals, indices));
                    Emitter::Triangle(TriangleEmitter::new(vertices, flip, normals))
                };
                mesh.indices.iter().map(emitter).collect()
            }
            sahl_accel::Geometry::Patches(mesh) => {
                let emitter = |&indices: &[u32; 4]| {
                    let corners = gather(&mesh.positions, indices);
                    let normals = normals.as_ref().map(|normals| gather(normals, indices));
                    Emitter::Patch(Box::new(PatchEmitter::new(corners, flip, normals)))
                };
                mesh.indices.iter().map(emitter).collect()
            }
            _ => quadric_emitter(&shape.geometry, to_world, flip).into_iter().collect(),
        }
    }
}

/// The values at `indices`, which validation found to be in range.
fn gather<const N: usize>(values: &[Vec3], indices: [u32; N]) -> [Vec3; N] {
    indices.map(|i| values.get(i as usize).copied().unwrap_or(Vec3::ZERO))
}

/// The positions in the space into which `transform` leads; shared if that is where they are.
fn baked_positions(positions: &Arc<[Vec3]>, transform: &Transform) -> Arc<[Vec3]> {
    if *transform == Transform::IDENTITY {
        return positions.clone();
    }
    positions.iter().map(|&p| transform.point(p)).collect()
}

/// The emitter that a quadric is; `None` for meshes.
fn quadric_emitter(geometry: &Geometry, to_world: &Transform, flip: bool) -> Option<Emitter> {
    let shape = match *geometry {
        Geometry::Triangles(_) | Geometry::Patches(_) => return None,
        Geometry::Sphere { radius, z_min, z_max, phi_max } => {
            let ((z_min, z_max), phi_max) = (clamp_heights(z_min, z_max, radius), clamp_sweep(phi_max));
            let is_whole = z_min == -radius && z_max == radius && phi_max == clamp_sweep(f32::INFINITY);
            if let (true, Some(scale)) = (is_whole, uniform_scale(to_world)) {
                let center = to_world.point(Vec3::ZERO);
                return Some(Emitter::Sphere(SphereEmitter::new(center, radius * scale, flip)));
            }
            QuadricShape::Sphere { radius, z_min, z_max, phi_max }
        }
        Geometry::Disk { height, radius, inner_radius, phi_max } => QuadricShape::Disk {
            height,
            radius,
            inner_radius: inner_radius.max(0.0),
            phi_max: clamp_sweep(phi_max),
        },
        Geometry::Cylinder { radius, z_min, z_max, phi_max } => QuadricShape::Cylinder {
            radius,
            z_min: z_min.min(z_max),
            z_max: z_min.max(z_max),
            phi_max: clamp_sweep(phi_max),
        },
    };
    Some(Emitter::Quadric(Box::new(QuadricEmitter::new(shape, to_world, flip))))
}
