//! Shapes.

use std::sync::Arc;

use sahl_math::{Vec2, Vec3};
use sahl_scene::{FloatParam, Geometry, Handle, Origin, PatchMesh, TriangleMesh};

use super::super::context::{Context, MeshFile};
use super::super::parameter::Kind;
use super::super::reader::Reader;
use super::super::report::quote;
use super::super::statement::Name;
use super::curve::curve;
use super::lookup;
use super::spectrum::{float_param, optional_float_param};
use crate::ply;
use crate::subdivision::loop_subdivide;

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

/// What a shape becomes: its surfaces, and the share of them that is there.
pub(in super::super) struct Surfaces {
    pub(in super::super) geometries: Vec<Geometry>,
    pub(in super::super) alpha: FloatParam,
}

/// The surfaces of the shape called `name`.
pub(in super::super) fn shape(cx: &mut Context<'_>, name: &str, p: &Reader<'_>) -> Surfaces {
    const OPAQUE: FloatParam = FloatParam::Constant(1.0);
    let Some(read) = lookup(SHAPES, name, p) else {
        return Surfaces { geometries: Vec::new(), alpha: OPAQUE };
    };
    let alpha = float_param(cx, p, "alpha", OPAQUE);
    Surfaces { geometries: read(cx, p), alpha }
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
    // They are named so that they are known even if reading ends before them.
    p.without_effect(&["faceIndices", "indices", "N", "uv"]);
    let positions = positions(p)?;
    let count = positions.len();
    let normals = p.vectors("N", Kind::Normal).filter(|normals| same_count(p, "N", normals.len(), count));
    let uvs = p.pairs("uv").filter(|uvs| same_count(p, "uv", uvs.len(), count));
    Some(Vertices { positions: positions.into(), normals: normals.map(Into::into), uvs: uvs.map(Into::into) })
}

/// Reads `P`; `None`, reported, if it is not there.
pub(super) fn positions(p: &Reader<'_>) -> Option<Vec<Vec3>> {
    let positions = p.vectors("P", Kind::Point3);
    if positions.is_none() && !p.has("P") {
        p.report().error("missing-parameter", p.span(), format!("{} needs `point3 P`", p.what()));
    }
    positions
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

/// The number of each of `faces` among those of textures that have an image a face.
fn face_indices(p: &Reader<'_>, faces: usize) -> Option<Arc<[u32]>> {
    let numbers = p.integers("faceIndices")?;
    let span = p.find("faceIndices").map_or(p.span(), |parameter| parameter.value_span);
    if numbers.len() != faces {
        let message =
            format!("{} has {faces} faces, but {} values of `faceIndices`", p.what(), numbers.len());
        p.report().error("wrong-count", span, message);
        return None;
    }
    if let Some(place) = numbers.iter().position(|&number| number < 0) {
        let message = format!("face index {} is negative", numbers[place]);
        p.report().error("index-range", p.report().value_span(span, place), message);
        return None;
    }
    Some(numbers.iter().map(|&number| number.cast_unsigned()).collect())
}

fn add_triangles(cx: &mut Context<'_>, p: &Reader<'_>, mesh: Option<TriangleMesh>) -> Vec<Geometry> {
    let add = |mesh| Geometry::Triangles(cx.scene.triangle_meshes.push(mesh, Origin::at(p.span())));
    mesh.map(add).into_iter().collect()
}

fn triangle_mesh(cx: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    let read = || {
        p.without_effect(&["S"]);
        let Vertices { positions, normals, uvs } = vertices(p)?;
        let tangents = p.vectors("S", Kind::Vector3);
        let tangents = tangents.filter(|all| same_count(p, "S", all.len(), positions.len())).map(Into::into);
        let indices = faces(p, positions.len())?;
        let face_indices = face_indices(p, indices.len());
        Some(TriangleMesh { indices, positions, normals, tangents, uvs, face_indices })
    };
    add_triangles(cx, p, read())
}

fn bilinear_mesh(cx: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    // In pbrt-v4 too the image does not emit: it says where on the patch to look for light, which changes noise alone.
    p.without_effect(&["emissionfilename"]);
    let read = || {
        let Vertices { positions, normals, uvs } = vertices(p)?;
        let indices = faces(p, positions.len())?;
        let face_indices = face_indices(p, indices.len());
        Some(PatchMesh { indices, positions, normals, tangents: None, uvs, face_indices })
    };
    let add = |mesh| Geometry::Patches(cx.scene.patch_meshes.push(mesh, Origin::at(p.span())));
    read().map(add).into_iter().collect()
}

fn loop_subdivision(cx: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    // There is one scheme.
    p.without_effect(&["scheme"]);
    let levels = p.count("levels", 3);
    let read = || {
        let positions = positions(p)?;
        let indices = faces(p, positions.len())?;
        let mesh = loop_subdivide(&indices, &positions, levels);
        let complain = |reason| p.report().error("bad-mesh", p.span(), format!("can't subdivide: {reason}"));
        mesh.map_err(complain).ok()
    };
    add_triangles(cx, p, read())
}

fn ply_mesh(cx: &mut Context<'_>, p: &Reader<'_>) -> Vec<Geometry> {
    let displacement = optional_float_param(cx, p, "displacement");
    let edge_length = p.positive("edgelength", 1.0);
    let Some(name) = p.string("filename") else {
        if !p.has("filename") {
            p.report().error("missing-parameter", p.span(), "shape `plymesh` needs a `string filename`");
        }
        return Vec::new();
    };
    let meshes = mesh_file(cx, name);
    if let Some(displacement) = displacement {
        let displaced = |mesh| Geometry::Displaced { mesh, displacement, edge_length };
        return all_triangles(cx, meshes).map(displaced).into_iter().collect();
    }
    let MeshFile { triangles, patches } = meshes;
    triangles.map(Geometry::Triangles).into_iter().chain(patches.map(Geometry::Patches)).collect()
}

/// All faces of a file as triangles, a quadrilateral cut in two.
fn all_triangles(cx: &mut Context<'_>, meshes: MeshFile) -> Option<Handle<TriangleMesh>> {
    let Some(patches) = meshes.patches else { return meshes.triangles };
    let origin = cx.scene.patch_meshes.origin(patches).clone();
    let PatchMesh { indices, positions, normals, tangents, uvs, face_indices } =
        cx.scene.patch_meshes[patches].clone();
    let halves = indices.iter().flat_map(|&[a, b, c, d]| [[a, b, d], [a, d, c]]);
    // The meshes of a file share their vertices, and either all its faces are numbered or none.
    let triangles = meshes.triangles.map(|mesh| cx.scene.triangle_meshes[mesh].clone()).unwrap_or_default();
    let face_indices = face_indices.map(|numbers| {
        let halves = numbers.iter().flat_map(|&number| [number; 2]);
        triangles.face_indices.iter().flat_map(|numbers| numbers.iter().copied()).chain(halves).collect()
    });
    let indices = triangles.indices.iter().copied().chain(halves).collect();
    let mesh = TriangleMesh { indices, positions, normals, tangents, uvs, face_indices };
    Some(cx.scene.triangle_meshes.push(mesh, origin))
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
