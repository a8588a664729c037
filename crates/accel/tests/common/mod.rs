//! Meshes, worlds and random numbers that the tests and the watertightness example share.
#![allow(
    dead_code,
    clippy::allow_attributes,
    reason = "each program that includes this file uses a part of it"
)]

pub(crate) mod agreement;
pub(crate) mod meshes;
pub(crate) mod moving;
pub(crate) mod watertight;
pub(crate) mod worlds;

use sahl_accel::{Accel, BuildOptions, Builder, Geometry, World};
use sahl_math::Vec3;

/// A counter-based generator with a fixed seed: splitmix64 of Steele, Lea, Flood, 2014.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1_u64 << 24) as f32
    }

    /// Uniform in [low, high).
    pub(crate) fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.bits() % limit as u64) as usize
    }

    /// Uniform in the cube of half edge `half`.
    pub(crate) fn point(&mut self, half: f32) -> Vec3 {
        Vec3::new(self.range(-half, half), self.range(-half, half), self.range(-half, half))
    }

    /// Uniform on the unit sphere.
    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let p = self.point(1.0);
            if (1e-3..=1.0).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }
}

/// A world in which all geometries stand.
pub(crate) fn world_of(geometries: Vec<Geometry>) -> World {
    let world = (0..geometries.len() as u32).collect();
    World { geometries, world, ..World::default() }
}

pub(crate) fn build(world: &World, builder: Builder) -> Accel {
    Accel::build(world.clone(), &BuildOptions { builder, ..BuildOptions::default() })
}
