//! What is traced: scanned and modelled meshes from files, and procedural ones that need none.
//!
//! Each model is one mesh of triangles, so that no program is measured by how it handles many.

pub(crate) mod closed;
mod files;
pub(crate) mod lattice;
mod stadium;

use std::path::Path;

use sahl_accel::TriangleMesh;
use sahl_math::{Bounds3, Vec3};

use crate::Result;

pub(crate) use closed::Body;

/// A mesh, where it is looked at from, and what lights it.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) name: &'static str,
    pub(crate) mesh: TriangleMesh,
    pub(crate) view: View,
    pub(crate) light: Light,
}

/// A pinhole camera; y is up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) eye: Vec3,
    pub(crate) target: Vec3,
    /// The angle between the left and the right edge of the square image, in degrees.
    pub(crate) field: f32,
}

/// A parallelogram that emits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    pub(crate) corner: Vec3,
    pub(crate) edges: [Vec3; 2],
}

/// A model that can be asked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) name: &'static str,
    /// Whether it belongs to a quick run.
    pub(crate) quick: bool,
    source: Source,
}

/// How a model comes about.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// From a file below the folder of scenes, looked at as an object from outside.
    Object(&'static str),
    /// From a file, looked at from inside.
    Place(&'static str, View, Light),
    /// By a function.
    Procedural(fn() -> Model),
}

/// All models, small ones first.
pub(crate) const MODELS: &[Entry] = &[
    Entry { name: "bunny", quick: true, source: Source::Object("meshes/bunny.ply") },
    Entry { name: "armadillo", quick: false, source: Source::Object("meshes/armadillo.obj") },
    Entry { name: "sponza", quick: true, source: Source::Place("sponza-crytek/sponza.obj", NAVE, COURT) },
    Entry { name: "dragon", quick: false, source: Source::Object("meshes/dragon_vrip.ply.gz") },
    Entry { name: "head", quick: true, source: Source::Procedural(head) },
    Entry { name: "stadium", quick: true, source: Source::Procedural(stadium::stadium) },
];

/// In the nave of Sponza, looking along it.
const NAVE: View = View { eye: Vec3::new(-7.5, 1.8, -0.25), target: Vec3::new(5.0, 2.6, 0.0), field: 75.0 };

/// Under the opening of Sponza's roof.
const COURT: Light = Light {
    corner: Vec3::new(-5.5, 7.8, -1.3),
    edges: [Vec3::new(10.5, 0.0, 0.0), Vec3::new(0.0, 0.0, 2.2)],
};

impl Entry {
    /// Whether [`Entry::load`] reads a file.
    pub(crate) fn needs_file(&self) -> bool {
        !matches!(self.source, Source::Procedural(_))
    }

    /// Makes the model; `scenes` is the folder of the files.
    ///
    /// # Errors
    /// Its file can't be read.
    pub(crate) fn load(&self, scenes: &Path) -> Result<Model> {
        match self.source {
            Source::Object(path) => Ok(object(self.name, files::mesh(&scenes.join(path))?)),
            Source::Place(path, view, light) => {
                Ok(Model { name: self.name, mesh: files::mesh(&scenes.join(path))?, view, light })
            }
            Source::Procedural(make) => Ok(make()),
        }
    }
}

/// A mesh seen from the front, half right and slightly from above, just filling the image; the light hangs over it, as large as
/// its bounding sphere.
fn object(name: &'static str, mesh: TriangleMesh) -> Model {
    let bounds = Bounds3::from_points(mesh.positions.iter().copied());
    let (center, radius) = (bounds.center(), bounds.diagonal().length() * 0.5);
    let (towards, field) = (Vec3::new(0.45, 0.4, 1.0).normalize(), 40.0_f32);
    let right = Vec3::Y.cross(towards).normalize();
    let up = towards.cross(right);
    // Each vertex asks for a distance at which it lies on the border of the image.
    let slope = (0.5 * field).to_radians().tan();
    let distance = (mesh.positions.iter().map(|&p| p - center))
        .map(|p| p.dot(towards) + p.dot(right).abs().max(p.dot(up).abs()) / slope)
        .fold(0.0, f32::max);
    let view = View { eye: center + towards * (1.02 * distance), target: center, field };
    let light = Light {
        corner: center + Vec3::new(-1.0, 1.6, -1.0) * radius,
        edges: [Vec3::X * (2.0 * radius), Vec3::Z * (2.0 * radius)],
    };
    Model { name, mesh, view, light }
}

/// The bodies whose vertices and edges are shot at; those of files only if the folder of scenes is known.
///
/// # Errors
/// A file can't be read, or what it holds is not closed.
pub(crate) fn bodies(scenes: Option<&Path>) -> Result<Vec<Body>> {
    let mut bodies = closed::bodies();
    if let Some(scenes) = scenes {
        let path = scenes.join("meshes/cow.obj");
        let body = Body::of_mesh("cow", &files::mesh(&path)?);
        bodies.push(body.ok_or_else(|| format!("{} is not closed", path.display()))?);
    }
    Ok(bodies)
}

/// Two million triangles of like size.
fn head() -> Model {
    object("head", closed::head(409).mesh())
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn the_large_models_have_two_million_triangles() {
        for entry in MODELS.iter().filter(|entry| !entry.needs_file()) {
            let model = entry.load(Path::new("")).unwrap();
            assert_eq!(model.name, entry.name);
            let count = model.mesh.indices.len();
            assert!((2_000_000..2_500_000).contains(&count), "{}: {count}", model.name);
            let vertices = model.mesh.positions.len() as u32;
            assert!(model.mesh.indices.iter().flatten().all(|&index| index < vertices), "{}", model.name);
            assert!(model.mesh.positions.iter().all(|p| p.is_finite()), "{}", model.name);
        }
    }

    #[test]
    fn models_are_made_the_same_each_time() {
        for entry in MODELS.iter().filter(|entry| !entry.needs_file()) {
            let [a, b] = [(); 2].map(|()| entry.load(Path::new("")).unwrap().mesh);
            assert!(a.indices == b.indices && a.positions == b.positions, "{}", entry.name);
        }
    }

    #[test]
    fn names_differ() {
        let names: HashSet<&str> = MODELS.iter().map(|entry| entry.name).collect();
        assert_eq!(names.len(), MODELS.len());
    }
}
