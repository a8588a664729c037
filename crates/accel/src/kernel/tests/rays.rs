//! Rays that are prepared together against the same rays prepared alone.

use sahl_math::{Ray, Vec3};

use super::super::isa::{Isa, Task};
use super::super::{PreparedEight, PreparedRay, WIDTH};
use super::{Random, agreed, bits};

/// Everything that is kept of a ray.
type RayBits = ([u32; 3 * WIDTH], usize, Option<usize>, u32);

fn ray_bits(ray: &PreparedRay) -> RayBits {
    let rows = [ray.numbers, ray.reciprocals, ray.turned].map(|row| row.0.map(bits));
    let numbers = std::array::from_fn(|i| rows.as_flattened()[i]);
    let longest = ray.shear().axes.last().map(|&axis| axis as usize);
    (numbers, ray.orientation().octant.index(), longest, ray.ray().time.to_bits())
}

#[derive(Clone, Copy)]
struct Prepare<'a>(&'a [Ray]);

impl Task for Prepare<'_> {
    type Output = Vec<(usize, RayBits)>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Self::Output {
        let mut eight = PreparedEight::NONE;
        eight.prepare(isa, self.0);
        let mut found = Vec::new();
        while let Some((place, ray)) = eight.next() {
            found.push((place, ray_bits(ray)));
        }
        assert!(eight.is_empty());
        found
    }
}

#[test]
fn eight_rays_are_prepared_as_each_alone() {
    let mut random = Random(31);
    let mut usable = 0;
    for round in 0..20_000 {
        // What breaks careless code, equally long axes and zeros, and rays as they usually are.
        let coordinate = [Random::nasty, Random::on_grid, Random::signed][round % 3];
        let ray = |random: &mut Random| Ray {
            origin: random.vector(coordinate),
            direction: random.vector(coordinate),
            t_min: if random.below(2) == 0 { 0.0 } else { random.nasty() },
            t_max: if random.below(2) == 0 { f32::INFINITY } else { random.nasty() },
            time: random.signed(),
        };
        let rays: Vec<Ray> = (0..round % (WIDTH + 3)).map(|_| ray(&mut random)).collect();
        let alone = |(place, ray)| PreparedRay::new(ray).map(|ray| (place, ray_bits(&ray)));
        let expected: Vec<_> = rays.iter().take(WIDTH).enumerate().filter_map(alone).collect();
        assert_eq!(agreed(&Prepare(&rays), ""), expected, "{rays:?}");
        usable += expected.len();
    }
    assert!(usable > 20_000, "{usable}");
}

#[test]
fn a_ray_is_what_it_was_prepared_from() {
    let ray = Ray {
        origin: Vec3::new(1.0, 2.0, 3.0),
        direction: Vec3::new(-0.5, 4.0, -2.0),
        t_min: 0.25,
        t_max: 7.0,
        time: 0.75,
    };
    let prepared = PreparedRay::new(&ray).expect("the ray can hit something");
    assert_eq!(prepared.ray(), ray);
    assert_eq!(prepared.limit(), 7.0_f32.next_down());
    assert_eq!(prepared.after(2.0).ray(), Ray { t_min: 2.0, ..ray });
    let behind = PreparedRay::new(&Ray { t_min: -1.0, ..ray }).expect("the ray can hit something");
    assert_eq!(behind.ray().t_min, 0.0, "what lies behind the origin never counts");
}
