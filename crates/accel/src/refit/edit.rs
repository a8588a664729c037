//! Edits: what can be changed of a world.

use std::fmt;
use std::sync::Arc;

use sahl_math::Vec3;

use crate::world::{Geometry, Placement, World};

/// A change of a world that leaves what refers to what.
#[derive(Clone, Debug)]
pub enum Edit {
    /// Other vertices for a mesh of triangles that stand still, or of patches.
    Positions {
        /// Which geometry.
        geometry: u32,
        /// All vertices. Their number may be another: primitives whose indices are beyond the end cannot be hit, and may come back
        /// by a later edit; vertices that no primitive refers to do nothing.
        positions: Arc<[Vec3]>,
    },
    /// Other vertices for a mesh of triangles that move.
    MovingPositions {
        /// Which geometry.
        geometry: u32,
        /// All vertices when the shutter opens, and when it closes. Either list may have another length, as in [`Self::Positions`]; a
        /// triangle needs its vertices in both.
        positions: [Arc<[Vec3]>; 2],
    },
    /// Another place, or another motion, for an instance.
    Placement {
        /// Which instance.
        instance: u32,
        /// From the group's space to the world.
        to_world: Placement,
    },
}

/// The first edit of a list that does not fit the world: there is no such geometry or instance, or the geometry is of another kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnfitEdit {
    /// Its place in the list.
    pub place: usize,
}

impl fmt::Display for UnfitEdit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "edit {} is of a geometry or instance that is not there or is of another kind", self.place)
    }
}

impl std::error::Error for UnfitEdit {}

/// What edits touch.
pub(super) struct Changes {
    geometries: Vec<bool>,
    pub(super) instances: Vec<bool>,
}

impl Edit {
    /// Whether the world has what is to be changed.
    pub(super) fn fits(&self, world: &World) -> bool {
        match self {
            Self::Positions { geometry, .. } => matches!(
                world.geometries.get(*geometry as usize),
                Some(Geometry::Triangles(_) | Geometry::Patches(_))
            ),
            Self::MovingPositions { geometry, .. } => {
                matches!(world.geometries.get(*geometry as usize), Some(Geometry::MovingTriangles(_)))
            }
            Self::Placement { instance, .. } => (*instance as usize) < world.instances.len(),
        }
    }

    /// Changes the world that it fits.
    pub(super) fn apply(self, world: &mut World) {
        match self {
            Self::Positions { geometry, positions } => match &mut world.geometries[geometry as usize] {
                Geometry::Triangles(mesh) => mesh.positions = positions,
                Geometry::Patches(mesh) => mesh.positions = positions,
                _ => {}
            },
            Self::MovingPositions { geometry, positions } => {
                if let Geometry::MovingTriangles(mesh) = &mut world.geometries[geometry as usize] {
                    mesh.positions = positions;
                }
            }
            Self::Placement { instance, to_world } => world.instances[instance as usize].to_world = to_world,
        }
    }
}

impl Changes {
    /// What some edits touch that fit.
    pub(super) fn of(edits: &[Edit], world: &World) -> Self {
        let mut geometries = vec![false; world.geometries.len()];
        let mut instances = vec![false; world.instances.len()];
        for edit in edits {
            match edit {
                Edit::Positions { geometry, .. } | Edit::MovingPositions { geometry, .. } => {
                    geometries[*geometry as usize] = true;
                }
                Edit::Placement { instance, .. } => instances[*instance as usize] = true,
            }
        }
        Self { geometries, instances }
    }

    /// Whether a geometry is changed.
    pub(super) fn geometry(&self, geometry: u32) -> bool {
        self.geometries.get(geometry as usize).is_some_and(|&is_changed| is_changed)
    }

    /// Whether any of some geometries is changed.
    pub(super) fn any_of(&self, geometries: &[u32]) -> bool {
        geometries.iter().any(|&geometry| self.geometry(geometry))
    }

    /// The geometries that are changed, ascending.
    pub(super) fn changed_geometries(&self) -> impl Iterator<Item = u32> {
        (0..).zip(&self.geometries).filter(|(_, is_changed)| **is_changed).map(|(geometry, _)| geometry)
    }
}
