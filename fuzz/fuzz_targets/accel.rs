//! Acceleration structures: building ends, and every query of every tree on every tier finds whether there is a hit as brute force
//! does, and the same hit as the others; at any time, through filters, and after edits.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sahl_accel::{
    Accel, BuildOptions, Builder, CurveKind, CurveSet, Cylinder, Disk, Edit, Geometry, Hit, Instance,
    MovingTriangleMesh, PatchMesh, Placement, Sphere, Tier, TriangleMesh, World,
};
use sahl_math::{AnimatedTransform, Ray, Transform, Vec3};

/// Bytes as the numbers that they are asked for; zeros where there are no more.
struct Input<'a>(&'a [u8]);

impl Input<'_> {
    fn byte(&mut self) -> u8 {
        let Some((&byte, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        byte
    }

    /// A number of a small grid, or one of any bits.
    fn number(&mut self) -> f32 {
        let byte = self.byte();
        if byte < 224 {
            return f32::from(byte % 16) * 0.25 - 2.0;
        }
        f32::from_bits(u32::from_le_bytes([(); 4].map(|()| self.byte())))
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    fn vectors(&mut self) -> Vec<Vec3> {
        (0..self.byte() % 64).map(|_| self.vector()).collect()
    }

    /// Indices, of which some are out of range.
    fn faces<const N: usize>(&mut self) -> Vec<[u32; N]> {
        (0..self.byte()).map(|_| [(); N].map(|()| u32::from(self.byte() % 65))).collect()
    }

    fn transform(&mut self) -> Transform {
        let [x, y, z] = [(); 3].map(|()| f64::from(self.number()));
        let scale = f64::from(self.number());
        let moved = Transform::translate(x, y, z);
        let scaled = Transform::scale(scale, 1.0, -1.0);
        moved.and_then(|moved| moved.after(&scaled?)).unwrap_or(Transform::IDENTITY)
    }

    fn placement(&mut self) -> Placement {
        let start = self.transform();
        if self.byte() % 2 == 0 {
            return start.into();
        }
        let (end, times) = (self.transform(), [self.number(), self.number()]);
        AnimatedTransform::new(start, end, times).map_or(start.into(), Placement::from)
    }

    /// An edit, of which some do not fit.
    fn edit(&mut self) -> Edit {
        let index = u32::from(self.byte() % 7);
        match self.byte() % 3 {
            0 => Edit::Positions { geometry: index, positions: self.vectors().into() },
            1 => Edit::MovingPositions {
                geometry: index,
                positions: [self.vectors().into(), self.vectors().into()],
            },
            _ => Edit::Placement { instance: index, to_world: self.placement() },
        }
    }

    fn geometry(&mut self) -> Geometry {
        match self.byte() % 9 {
            0 => Geometry::Sphere(Sphere {
                radius: self.number(),
                z_min: self.number(),
                z_max: self.number(),
                phi_max: self.number(),
                to_parent: self.transform(),
            }),
            1 => Geometry::Disk(Disk {
                height: self.number(),
                radius: self.number(),
                inner_radius: self.number(),
                phi_max: self.number(),
                to_parent: self.transform(),
            }),
            2 => Geometry::Patches(PatchMesh {
                positions: self.vectors().into(),
                indices: self.faces().into(),
            }),
            3 => Geometry::Cylinder(Cylinder {
                radius: self.number(),
                z_min: self.number(),
                z_max: self.number(),
                phi_max: self.number(),
                to_parent: self.transform(),
            }),
            4 => Geometry::Curves(self.curves()),
            5 => Geometry::MovingTriangles(MovingTriangleMesh {
                positions: [self.vectors().into(), self.vectors().into()],
                indices: self.faces().into(),
            }),
            _ => Geometry::Triangles(TriangleMesh {
                positions: self.vectors().into(),
                indices: self.faces().into(),
            }),
        }
    }

    /// Curves, of some of which there are no widths or normals.
    fn curves(&mut self) -> CurveSet {
        let kind = [CurveKind::Flat, CurveKind::Cylinder, CurveKind::Ribbon][usize::from(self.byte() % 3)];
        let mut count = || 0..self.byte() % 8;
        let (points, widths, normals) = (count(), count(), count());
        CurveSet {
            kind,
            points: points.map(|_| [(); 4].map(|()| self.vector())).collect(),
            widths: widths.map(|_| [(); 2].map(|()| self.number())).collect(),
            normals: normals.map(|_| [(); 2].map(|()| self.vector())).collect(),
            split_depth: u32::from(self.byte() % 4),
            to_parent: self.transform(),
        }
    }

    fn world(&mut self) -> World {
        let geometries = (0..self.byte() % 6).map(|_| self.geometry()).collect();
        let mut names = || (0..self.byte() % 8).map(|_| u32::from(self.byte() % 7)).collect::<Vec<u32>>();
        let (world, groups, filtered) = (names(), vec![names(), names()], names());
        let instances = (0..self.byte() % 8)
            .map(|_| Instance { group: u32::from(self.byte() % 3), to_world: self.placement() })
            .collect();
        World { geometries, world, groups, instances, filtered }
    }

    fn ray(&mut self) -> Ray {
        let ray = Ray::new(self.vector(), self.vector()).with_time(self.number());
        match self.byte() % 4 {
            0 => Ray { t_min: self.number(), t_max: self.number(), ..ray },
            _ => ray,
        }
    }
}

fn bits(hits: &[Option<Hit>]) -> Vec<Option<[u32; 6]>> {
    let bits = |hit: &Hit| {
        [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.geometry, hit.primitive, hit.instance]
    };
    hits.iter().map(|hit| hit.as_ref().map(bits)).collect()
}

/// Compares the queries for many with those for one, and returns what these give.
fn check(accel: &Accel, rays: &[Ray]) -> Vec<Option<Hit>> {
    let single: Vec<Option<Hit>> = rays.iter().map(|ray| accel.intersect(ray)).collect();
    let mut hits = vec![None; rays.len()];
    accel.intersect_batch(rays, &mut hits);
    assert_eq!(bits(&hits), bits(&single), "batch");
    accel.intersect_coherent(rays, &mut hits);
    // Packets hold rays against the boxes of triangles, out of which rounding may move a hit where it is not moderate.
    for ((ray, hit), alone) in rays.iter().zip(&hits).zip(&single) {
        assert!(bits(&[*hit]) == bits(&[*alone]) || !is_moderate(ray, accel), "coherent: {ray:?}");
    }
    for ray in rays {
        let filter = |hit: &Hit| hit.primitive % 2 == 1;
        let filtered = accel.intersect_filtered(ray, filter);
        assert_eq!(accel.occluded_filtered(ray, filter), filtered.is_some(), "filtered: {ray:?}");
    }
    let mut occluded = vec![false; rays.len()];
    accel.occluded_batch(rays, &mut occluded);
    for ((ray, hit), occluded) in rays.iter().zip(&single).zip(occluded) {
        assert_eq!([occluded, accel.occluded(ray)], [hit.is_some(); 2], "occluded: {ray:?}");
        if let Some(hit) = hit {
            assert!(hit.t > 0.0 && hit.t > ray.t_min.max(0.0) && hit.t < ray.t_max, "{hit:?} of {ray:?}");
            let _ = accel.surface_point(ray, hit);
        }
    }
    single
}

/// Whether `f32` can tell where a ray goes: in a world of moderate size, from a moderate distance, without limits, to either side of
/// which a parameter may fall that is known less well than the box about what is hit.
fn is_moderate(ray: &Ray, accel: &Accel) -> bool {
    let is_small = |v: Vec3| v.abs().max_component() <= 1e6;
    let is_unlimited = ray.t_min <= 0.0 && ray.t_max == f32::INFINITY;
    let d: [f32; 3] = ray.direction.into();
    let goes_somewhere = d.iter().all(|&x| x == 0.0 || (1e-6..=1e6).contains(&x.abs()));
    let bounds = accel.bounds();
    is_unlimited && goes_somewhere && is_small(ray.origin) && is_small(bounds.min) && is_small(bounds.max)
}

fuzz_target!(|bytes: &[u8]| {
    let mut input = Input(bytes);
    let world = input.world();
    let rays: Vec<Ray> = (0..input.byte()).map(|_| input.ray()).collect();
    let edits: Vec<Edit> = (0..input.byte() % 4).map(|_| input.edit()).collect();
    let build = |builder, tier| {
        Accel::build(world.clone(), &BuildOptions { builder, tier, ..BuildOptions::default() })
    };
    let edited = |mut accel: Accel| {
        for edit in &edits {
            // One after the other, as one that does not fit keeps all from being made.
            let _ = accel.refit(vec![edit.clone()]);
        }
        accel
    };
    compare(&rays, build);
    compare(&rays, |builder, tier| edited(build(builder, tier)));
});

/// Compares all structures that `build` makes with brute force.
fn compare(rays: &[Ray], build: impl Fn(Builder, Option<Tier>) -> Accel) {
    let oracle = build(Builder::BruteForce, None);
    let expected = check(&oracle, rays);
    for builder in [Builder::BinnedSah, Builder::Fast, Builder::Median] {
        let mut first: Option<Vec<Option<Hit>>> = None;
        for tier in Tier::ALL.into_iter().filter(|tier| tier.is_available()) {
            let accel = build(builder, Some(tier));
            assert_eq!(accel.stats().dropped, oracle.stats().dropped);
            let hits = check(&accel, rays);
            let first = first.get_or_insert_with(|| hits.clone());
            assert_eq!(bits(&hits), bits(first), "{builder:?} {tier:?}");
            for ((ray, hit), expected) in rays.iter().zip(&hits).zip(&expected) {
                let same = hit.is_some() == expected.is_some();
                assert!(same || !is_moderate(ray, &oracle), "{builder:?} {tier:?}: {ray:?}");
            }
        }
    }
}
