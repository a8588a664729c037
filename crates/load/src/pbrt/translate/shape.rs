//! Shapes.

use std::sync::Arc;

use sahl_math::{Vec2, Vec3};
use sahl_scene::{Geometry, Origin, PatchMesh, TriangleMesh};

use super::super::context::{Context, MeshFile};
use super::super::parameter::Kind;
use super::super::reader::Reader;
use super::super::report::quote;
use super::super::statement::Name;
use super::lookup;
use crate::ply;

/// Reads one kind of shape; what it gives may be several surfaces, or none.
type Read = fn(&mut Context<'_>, &Reader<'_>) -> Vec<Geometry>;

const SHAPES: &[(&str, Read)] = &[
    ("trianglemesh", triangle_mesh),
    ("bilinearmesh", bilinear_mesh),
    ("plymesh", ply_mesh),
    ("sphere", sphere),
    ("disk", disk),
    ("cylinder", cylinder),
    ("loopsubdiv", loop_subdivision),
    ("curve", curve),
];

/// The surfaces of the shape called `name`.
pub(in super::super) fn shape(cx: &mut Context<'_>, name: &str, p: &Reader<'_>) -> Vec<Geometry> {
    let Some(read) = lookup(SHAPES, name, p) else { return Vec::new() };
    p.unsupported(&["alpha"], "the surface is opaque");
    read(cx, p)
}

/// The sweep about z in radians.
fn sweep(p: &Reader<'_>) -> f32 {
    let valid = |degrees: f32| degrees > 0.0 && degrees <= 360.0;
    p.float_where("phimax", 360.0, valid, "greater than 0 and at most 360 degrees").to_radians()
}

fn sphere(_: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    let radius = p.positive("radius", 1.0);
    let within = |value: f32| value.clamp(-radius, radius);
    let (z0, z1) = (within(p.float("zmin", -radius)), within(p.float("zmax", radius)));
    let phi_max = sweep(p);
    if z0 == z1 {
        p.invalid("zmin", "meets `zmax`: nothing is left of the surface");
        return Vec::new();
    }
    vec![Geometry::Sphere { radius, z_min: z0.min(z1), z_max: z0.max(z1), phi_max }]
}

fn cylinder(_: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    let (z0, z1) = (p.float("zmin", -1.0), p.float("zmax", 1.0));
    let (radius, phi_max) = (p.positive("radius", 1.0), sweep(p));
    if z0 == z1 {
        p.invalid("zmin", "meets `zmax`: nothing is left of the surface");
        return Vec::new();
    }
    vec![Geometry::Cylinder { radius, z_min: z0.min(z1), z_max: z0.max(z1), phi_max }]
}

fn disk(_: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    let (height, radius) = (p.float("height", 0.0), p.positive("radius", 1.0));
    let within = |inner: f32| inner >= 0.0 && inner < radius;
    let inner_radius = p.float_where("innerradius", 0.0, within, "at least zero and less than the radius");
    vec![Geometry::Disk { height, radius, inner_radius, phi_max: sweep(p) }]
}

/// What meshes of triangles and of patches share.
struct Vertices {
    positions: Arc<[Vec3]>,
    normals: Option<Arc<[Vec3]>>,
    uvs: Option<Arc<[Vec2]>>,
}

/// Reads `P`, `N` and `uv`; `None`, reported, without positions.
fn vertices(p: &Reader<'_>) -> Option<Vertices> {
    // Only textures that are stored by face look at `faceIndices`. The others are named so that they are known even if
    // reading ends before them.
    p.without_effect(&["faceIndices", "indices", "N", "uv"]);
    let Some(positions) = p.vectors("P", Kind::Point3) else {
        if !p.has("P") {
            p.report().error("missing-parameter", p.span(), format!("{} needs `point3 P`", p.what()));
        }
        return None;
    };
    let count = positions.len();
    let normals = p.vectors("N", Kind::Normal).filter(|normals| same_count(p, "N", normals.len(), count));
    let uvs = p.pairs("uv").filter(|uvs| same_count(p, "uv", uvs.len(), count));
    Some(Vertices { positions: positions.into(), normals: normals.map(Into::into), uvs: uvs.map(Into::into) })
}

fn same_count(p: &Reader<'_>, name: &'static str, found: usize, expected: usize) -> bool {
    if found != expected {
        let span = p.find(name).map_or(p.span(), |parameter| parameter.value_span);
        let message = format!("{} has {expected} vertices, but {found} values of `{name}`", p.what());
        p.report().error("wrong-count", span, message);
    }
    found == expected
}

/// Reads `indices` in groups of `N`, all of them below `vertices`. A mesh of one face needs none: its vertices are
/// taken in order.
fn faces<const N: usize>(p: &Reader<'_>, vertices: usize) -> Option<Arc<[[u32; N]]>> {
    let Some(indices) = p.integers("indices") else {
        if !p.has("indices") && vertices == N {
            return Some([std::array::from_fn(|corner| corner as u32)].into());
        }
        if !p.has("indices") {
            let message = format!("{} with {vertices} vertices needs `integer indices`", p.what());
            p.report().error("missing-parameter", p.span(), message);
        }
        return None;
    };
    let span_of = |index| match p.find("indices") {
        Some(parameter) => p.report().value_span(parameter.value_span, index),
        None => p.span(),
    };
    let (groups, rest) = indices.as_chunks::<N>();
    if !rest.is_empty() || groups.is_empty() {
        let message = format!("{} needs {N} indices a face, found {} in all", p.what(), indices.len());
        p.report().error("wrong-count", span_of(indices.len().saturating_sub(1)), message);
        return None;
    }
    let in_range = |&index: &i32| usize::try_from(index).is_ok_and(|index| index < vertices);
    if let Some(place) = indices.iter().position(|index| !in_range(index)) {
        let message = format!("index {} is out of range: there are {vertices} vertices", indices[place]);
        p.report().error("index-range", span_of(place), message);
        return None;
    }
    Some(groups.iter().map(|group| group.map(i32::cast_unsigned)).collect())
}

fn triangles(p: &Reader<'_>) -> Option<TriangleMesh> {
    let Vertices { positions, normals, uvs } = vertices(p)?;
    let indices = faces(p, positions.len())?;
    Some(TriangleMesh { indices, positions, normals, uvs })
}

fn add_triangles(cx: &mut Context<'_>, p: &Reader<'_>, mesh: Option<TriangleMesh>) -> Vec<Geometry> {
    let add = |mesh| Geometry::Triangles(cx.scene.triangle_meshes.push(mesh, Origin::at(p.span())));
    mesh.map(add).into_iter().collect()
}

fn triangle_mesh(cx: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    p.unsupported(&["S"], "tangents follow from the texture coordinates");
    add_triangles(cx, p, triangles(p))
}

fn bilinear_mesh(cx: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    p.unsupported(&["emissionfilename"], "emission is the same everywhere, as in pbrt-v4");
    let read = || {
        let Vertices { positions, normals, uvs } = vertices(p)?;
        let indices = faces(p, positions.len())?;
        Some(PatchMesh { indices, positions, normals, uvs })
    };
    let add = |mesh| Geometry::Patches(cx.scene.patch_meshes.push(mesh, Origin::at(p.span())));
    read().map(add).into_iter().collect()
}

fn loop_subdivision(cx: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    p.without_effect(&["levels", "scheme"]);
    p.unsupported_plugin("unsupported-shape", "its control mesh is used as it is");
    add_triangles(cx, p, triangles(p))
}

fn curve(_: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    p.without_effect(&["P", "N", "type", "basis", "degree", "width", "width0", "width1", "splitdepth"]);
    p.unsupported_plugin("unsupported-shape", "it is left out");
    Vec::new()
}

fn ply_mesh(cx: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    p.unsupported(&["displacement"], "the surface stays as it is");
    p.without_effect(&["edgelength"]);
    let Some(name) = p.string("filename") else {
        if !p.has("filename") {
            p.report().error("missing-parameter", p.span(), "shape `plymesh` needs a `string filename`");
        }
        return Vec::new();
    };
    let MeshFile { triangles, patches } = mesh_file(cx, name);
    triangles.map(Geometry::Triangles).into_iter().chain(patches.map(Geometry::Patches)).collect()
}

/// The meshes in the file called `name`, which is read once however many shapes use it.
fn mesh_file(cx: &mut Context<'_>, name: &Name) -> MeshFile {
    for path in cx.files.candidates(&name.text) {
        if let Some(meshes) = cx.meshes.get(&path) {
            return *meshes;
        }
    }
    let Some((path, bytes)) = cx.read_file(name) else { return MeshFile::default() };
    let mut meshes = MeshFile::default();
    match ply::read(&bytes) {
        Ok(mesh) => {
            for warning in &mesh.warnings {
                let message = format!("{}: {warning}", quote(name.text.as_bytes()));
                cx.report.warning("mesh-repair", name.span, message);
            }
            let origin = Origin::named(name.text.clone(), name.span);
            meshes.triangles = mesh.triangles.map(|mesh| cx.scene.triangle_meshes.push(mesh, origin.clone()));
            meshes.patches = mesh.patches.map(|mesh| cx.scene.patch_meshes.push(mesh, origin));
        }
        Err(error) => {
            let message = format!("can't read the mesh {}: {error}", quote(name.text.as_bytes()));
            cx.report.error("bad-mesh", name.span, message);
        }
    }
    cx.meshes.insert(path, meshes);
    meshes
}
