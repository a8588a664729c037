//! Shapes: from their own space into what the accelerator and the renderer need.

use std::sync::Arc;

use sahl_accel::{CurveSet, Cylinder, Disk, PatchMesh, Sphere, TriangleMesh, World};
use sahl_math::{Transform, Vec2, Vec3};
use sahl_scene::{
    AreaLight, CurveKind, Curves, Geometry, Handle, Material, Mesh, SceneDesc, Shape, SpectrumParam,
};

use super::displacement::displaced;
use super::lights::{EmittingSurface, LightBuilder};
use super::placement::{Placements, to_parent};
use crate::light::Presence;
use crate::material::{self, OpenPbrSource};
use crate::scene::SceneStats;
use crate::shape::{
    Attributes, Border, Emitter, PatchEmitter, QuadricEmitter, QuadricShape, SphereEmitter, SurfaceMap,
    TriangleEmitter, clamp_heights, clamp_sweep, uniform_scale,
};
use crate::texture::{FloatSource, TexturePoint, Textures};

/// Collects geometries and their attributes, which have the same indices.
pub(super) struct GeometryBuilder<'a> {
    description: &'a SceneDesc,
    textures: &'a Textures,
    pub(super) world: World,
    pub(super) attributes: Vec<Attributes>,
    pub(super) counts: SceneStats,
    placements: Placements,
    /// Whether borders of media count. They are left out where nothing else is to be seen of them.
    media: bool,
}

impl<'a> GeometryBuilder<'a> {
    pub(super) fn new(description: &'a SceneDesc, textures: &'a Textures, media: bool) -> Self {
        let counts = SceneStats::default();
        let placements = Placements::new(description);
        Self {
            description,
            textures,
            world: World::default(),
            attributes: Vec::new(),
            counts,
            placements,
            media,
        }
    }

    /// Adds every shape of the world and of the objects, and the lights that shapes of the world are.
    pub(super) fn build(mut self, lights: &mut LightBuilder<'_>) -> Self {
        for &handle in &self.description.world {
            if !self.is_there(handle) {
                continue;
            }
            let shape = &self.description.shapes[handle];
            let index = self.push(handle, lights);
            let span = self.description.shapes.origin(handle).span;
            if let Some((area_light, veil)) = self.emission(handle, lights) {
                if matches!(shape.geometry, Geometry::Curves(_)) {
                    lights.refuse_curve(span);
                } else if shape.motion.is_some() {
                    lights.refuse_moving(span);
                } else {
                    let surface = EmittingSurface {
                        emitters: self.emitters(shape, index),
                        maps: match area_light.radiance {
                            SpectrumParam::Constant(_) if veil.is_none() => Vec::new(),
                            _ => self.surface_maps(shape, index),
                        },
                        presence: self.presence(shape),
                        veil,
                    };
                    self.attributes[index as usize].lights = lights.add_area(&area_light, surface, span);
                }
            }
            match &shape.motion {
                _ if self.is_absent(shape) => {}
                Some(motion) => self.placements.add_shape(index, motion),
                None => self.world.world.push(index),
            }
        }
        for (object, shapes) in self.description.objects.iter() {
            let mut group = Vec::with_capacity(shapes.shapes.len());
            for &handle in &shapes.shapes {
                if !self.is_there(handle) {
                    continue;
                }
                let shape = &self.description.shapes[handle];
                let index = self.push(handle, lights);
                match &shape.motion {
                    _ if self.is_absent(shape) => {}
                    Some(motion) => self.placements.add_part(object, index, motion),
                    None => group.push(index),
                }
                let span = self.description.shapes.origin(handle).span;
                if shape.area_light.is_some() || lights.may_emit(shape.material) {
                    lights.refuse_instanced(span);
                }
            }
            self.world.groups.push(group);
        }
        for instance in self.description.instances.values() {
            self.placements.add_instance(instance);
        }
        self.counts.instances = self.description.instances.len() as u64;
        self.world.groups.append(&mut self.placements.groups);
        self.world.instances.append(&mut self.placements.instances);
        self
    }

    /// What a shape emits, by itself or by its material, with the material whose layers the light has to pass.
    fn emission(
        &self,
        handle: Handle<Shape>,
        lights: &mut LightBuilder<'_>,
    ) -> Option<(AreaLight, Option<Arc<OpenPbrSource>>)> {
        let shape = &self.description.shapes[handle];
        let span = self.description.shapes.origin(handle).span;
        let Some(area_light) = &shape.area_light else { return lights.emission_of(shape.material, span) };
        if lights.may_emit(shape.material) {
            lights.refuse_second_emission(span);
        }
        (!self.is_open(handle)).then(|| (area_light.clone(), None))
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
    fn push(&mut self, handle: Handle<Shape>, lights: &mut LightBuilder<'_>) -> u32 {
        let shape = &self.description.shapes[handle];
        let traits = material::traits(self.description, shape.material);
        let mut attributes = Attributes {
            flip: shape.reverse_orientation,
            alpha: self.alpha(shape),
            material: shape.material.index() as u32,
            needs_tangent: traits.needs_tangent,
            is_composed: traits.is_composed,
            normals: None,
            tangents: None,
            uvs: None,
            face_indices: None,
            lights: None,
            border: Border::new(shape, self.is_open(handle)),
        };
        let geometry = self.geometry(shape, &mut attributes).unwrap_or_else(|| {
            lights.refuse_displacement(self.description.shapes.origin(handle).span);
            sahl_accel::Geometry::Triangles(TriangleMesh { indices: [].into(), positions: [].into() })
        });
        if attributes.alpha.is_some() {
            self.world.filtered.push(self.attributes.len() as u32);
        }
        self.world.geometries.push(geometry);
        self.attributes.push(attributes);
        (self.attributes.len() - 1) as u32
    }

    /// The share of a shape that is there, unless it is all of it.
    fn alpha(&self, shape: &Shape) -> Option<FloatSource> {
        let alpha = self.textures.float_source(&shape.alpha);
        (!matches!(alpha, FloatSource::Constant(1.0..))).then_some(alpha)
    }

    /// Whether no ray meets a shape.
    fn is_absent(&self, shape: &Shape) -> bool {
        matches!(self.alpha(shape), Some(FloatSource::Constant(..=0.0)))
    }

    /// How a shape that emits is found.
    fn presence(&self, shape: &Shape) -> Presence {
        match self.alpha(shape) {
            None => Presence::Share(1.0),
            Some(FloatSource::Constant(..=0.0)) => Presence::Unseen,
            Some(FloatSource::Constant(alpha)) => Presence::Share(alpha),
            Some(FloatSource::Texture(_)) => Presence::Varying,
        }
    }

    /// The surface of a shape as the accelerator has it; what that leaves out goes to the attributes. `None` if it has too many
    /// triangles.
    fn geometry(&mut self, shape: &Shape, attributes: &mut Attributes) -> Option<sahl_accel::Geometry> {
        let (description, to_parent) = (self.description, to_parent(shape));
        if matches!(
            shape.geometry,
            Geometry::Sphere { .. } | Geometry::Disk { .. } | Geometry::Cylinder { .. }
        ) {
            self.counts.quadrics += 1;
        }
        Some(match shape.geometry {
            Geometry::Triangles(mesh) => {
                let (indices, positions) = self.mesh(&description.triangle_meshes[mesh], shape, attributes);
                self.counts.triangles += indices.len() as u64;
                sahl_accel::Geometry::Triangles(TriangleMesh { indices, positions })
            }
            Geometry::Displaced { mesh, displacement, edge_length } => {
                let source = self.textures.float_source(&displacement);
                let height = |at: &TexturePoint| self.textures.float(&source, at);
                let mesh = &description.triangle_meshes[mesh];
                let mesh = displaced(mesh, &shape.shape_to_world, edge_length, height)?;
                let (indices, positions) = self.mesh(&mesh, shape, attributes);
                self.counts.triangles += indices.len() as u64;
                sahl_accel::Geometry::Triangles(TriangleMesh { indices, positions })
            }
            Geometry::Patches(mesh) => {
                let (indices, positions) = self.mesh(&description.patch_meshes[mesh], shape, attributes);
                self.counts.patches += indices.len() as u64;
                sahl_accel::Geometry::Patches(PatchMesh { indices, positions })
            }
            Geometry::Curves(curves) => {
                attributes.flip ^= to_parent.swaps_handedness();
                self.curves(&description.curves[curves], to_parent)
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
        })
    }

    /// The faces and the positions of a mesh, moved to where the shape places them, as are the attributes of its vertices.
    fn mesh<const N: usize>(
        &mut self,
        mesh: &Mesh<N>,
        shape: &Shape,
        attributes: &mut Attributes,
    ) -> (Arc<[[u32; N]]>, Arc<[Vec3]>) {
        let to_parent = &to_parent(shape);
        attributes.flip ^= to_parent.swaps_handedness();
        attributes.normals = baked_normals(mesh.normals.as_ref(), shape);
        attributes.tangents =
            mesh.tangents.as_ref().map(|all| all.iter().map(|&tangent| to_parent.vector(tangent)).collect());
        attributes.uvs = mesh.uvs.clone();
        attributes.face_indices = mesh.face_indices.clone();
        let (indices, positions) = (mesh.indices.clone(), baked_positions(&mesh.positions, to_parent));
        self.count_bytes(&[size_of_val(&*indices), size_of_val(&*positions)], attributes);
        (indices, positions)
    }

    fn curves(&mut self, curves: &Curves, to_parent: Transform) -> sahl_accel::Geometry {
        let Curves { points, widths, normals, .. } = curves;
        self.counts.curves += points.len() as u64;
        let bytes = size_of_val(&**points) + size_of_val(&**widths) + size_of_val(&**normals);
        self.counts.data_bytes += bytes as u64;
        sahl_accel::Geometry::Curves(CurveSet {
            kind: match curves.kind {
                CurveKind::Flat => sahl_accel::CurveKind::Flat,
                CurveKind::Cylinder => sahl_accel::CurveKind::Cylinder,
                CurveKind::Ribbon => sahl_accel::CurveKind::Ribbon,
            },
            points: Arc::clone(points),
            widths: Arc::clone(widths),
            normals: Arc::clone(normals),
            split_depth: curves.split_depth,
            to_parent,
        })
    }

    fn count_bytes(&mut self, sizes: &[usize], attributes: &Attributes) {
        let vectors = [&attributes.normals, &attributes.tangents].into_iter().flatten();
        let vectors: usize = vectors.map(|vectors| size_of_val(&**vectors)).sum();
        let uvs = attributes.uvs.as_ref().map_or(0, |uvs| size_of_val(&**uvs));
        let faces = attributes.face_indices.as_ref().map_or(0, |faces| size_of_val(&**faces));
        self.counts.data_bytes += (sizes.iter().sum::<usize>() + vectors + uvs + faces) as u64;
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

    /// How textures lie on the primitives of a shape of the world, in order.
    fn surface_maps(&self, shape: &Shape, index: u32) -> Vec<SurfaceMap> {
        let uvs = self.attributes[index as usize].uvs.as_ref();
        let at = |uvs: &Arc<[Vec2]>, i: u32| uvs.get(i as usize).copied().unwrap_or(Vec2::ZERO);
        match &self.world.geometries[index as usize] {
            sahl_accel::Geometry::Triangles(mesh) => {
                let map = |indices: &[u32; 3]| {
                    uvs.map_or(SurfaceMap::PLAIN_TRIANGLE, |uvs| {
                        SurfaceMap::Triangle(indices.map(|i| at(uvs, i)))
                    })
                };
                mesh.indices.iter().map(map).collect()
            }
            sahl_accel::Geometry::Patches(mesh) => {
                let map = |indices: &[u32; 4]| {
                    uvs.map_or(SurfaceMap::PLAIN_PATCH, |uvs| SurfaceMap::Patch(indices.map(|i| at(uvs, i))))
                };
                mesh.indices.iter().map(map).collect()
            }
            _ => {
                let from_world = shape.shape_to_world.inverse();
                let map = |shape| SurfaceMap::Quadric { shape, from_world };
                quadric_shape(&shape.geometry).map(map).into_iter().collect()
            }
        }
    }
}

/// The values at `indices`, which validation found to be in range.
fn gather<const N: usize>(values: &[Vec3], indices: [u32; N]) -> [Vec3; N] {
    indices.map(|i| values.get(i as usize).copied().unwrap_or(Vec3::ZERO))
}

/// Unit shading normals in the space of the positions, on the front: pbrt turns them round with the shape.
fn baked_normals(normals: Option<&Arc<[Vec3]>>, shape: &Shape) -> Option<Arc<[Vec3]>> {
    let sign = if shape.reverse_orientation { -1.0 } else { 1.0 };
    let to_parent = to_parent(shape);
    let bake = |n: &Vec3| to_parent.normal(*n).try_normalize().unwrap_or(Vec3::ZERO) * sign;
    normals.map(|normals| normals.iter().map(bake).collect())
}

/// The positions in the space into which `transform` leads; shared if that is where they are.
fn baked_positions(positions: &Arc<[Vec3]>, transform: &Transform) -> Arc<[Vec3]> {
    if *transform == Transform::IDENTITY {
        return positions.clone();
    }
    positions.iter().map(|&p| transform.point(p)).collect()
}

/// The emitter that a quadric is; `None` for other shapes.
fn quadric_emitter(geometry: &Geometry, to_world: &Transform, flip: bool) -> Option<Emitter> {
    let shape = quadric_shape(geometry)?;
    if let QuadricShape::Sphere { radius, z_min, z_max, phi_max } = shape {
        let is_whole = z_min == -radius && z_max == radius && phi_max == clamp_sweep(f32::INFINITY);
        if let (true, Some(scale)) = (is_whole, uniform_scale(to_world)) {
            let center = to_world.point(Vec3::ZERO);
            return Some(Emitter::Sphere(SphereEmitter::new(center, radius * scale, flip)));
        }
    }
    Some(Emitter::Quadric(Box::new(QuadricEmitter::new(shape, to_world, flip))))
}

/// A quadric in its own space, within its limits; `None` for other shapes.
fn quadric_shape(geometry: &Geometry) -> Option<QuadricShape> {
    Some(match *geometry {
        Geometry::Triangles(_) | Geometry::Patches(_) | Geometry::Curves(_) | Geometry::Displaced { .. } => {
            return None;
        }
        Geometry::Sphere { radius, z_min, z_max, phi_max } => {
            let ((z_min, z_max), phi_max) = (clamp_heights(z_min, z_max, radius), clamp_sweep(phi_max));
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
    })
}
