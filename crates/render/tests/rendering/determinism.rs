//! The image is a function of the scene: threads, tiles and interruptions change nothing but how much of it there is.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::common::*;
use sahl_image::Image;
use sahl_math::Transform;
use sahl_render::{Aov, Film, Progress, RenderOptions, Status, render};
use sahl_scene::{Filter, Light, Origin, SceneDesc, Spectrum};

/// A floor, a glass ball, a lamp, a point light and a dim sky, in an image whose size no tile divides.
fn scene(samples: u32) -> SceneDesc {
    let mut scene = empty(1, samples);
    scene.film.resolution = [53, 37];
    scene.film.crop = Some([3, 50, 2, 35]);
    scene.filter = Filter::Mitchell { radius: [2.0; 2], b: 1.0 / 3.0, c: 1.0 / 3.0 };
    let grey_material = diffuse(&mut scene, 0.6);
    let glass_material = glass(&mut scene);
    let geometry = quad(&mut scene, square(3.0, 0.0));
    add(&mut scene, geometry, grey_material);
    add_placed(&mut scene, sphere(0.5), glass_material, Transform::translate(0.2, 0.1, 0.6).unwrap());
    let lamp = patch(&mut scene, square(0.4, 2.0));
    let lamp = add(&mut scene, lamp, grey_material);
    scene.shapes[lamp].reverse_orientation = true;
    emit(&mut scene, lamp, 5.0);
    let intensity = Spectrum::Blackbody(3000.0);
    let position = sahl_math::Vec3::new(1.0, 1.0, 2.0);
    scene.lights.push(Light::Point { intensity, scale: 1.0, power: None, position }, Origin::default());
    sky(&mut scene, grey(0.1));
    look_down(&mut scene, 1.9, 1.2);
    scene.camera.lens_radius = 0.02;
    scene.camera.focal_distance = 1.5;
    scene
}

fn bits(image: &Image) -> Vec<u32> {
    values(image).iter().map(|value| value.to_bits()).collect()
}

fn options(threads: usize, tile_size: u32) -> RenderOptions {
    RenderOptions { threads, tile_size, aovs: Aov::ALL.to_vec() }
}

#[test]
fn threads_and_tiles_do_not_change_a_bit() {
    let scene = built(&scene(19));
    let reference = render(&scene, &options(1, 16), &());
    assert!(reference.completed);
    assert_eq!(reference.film.samples(), [19, 19]);
    let layers = reference.film.layers();
    assert_eq!(layers.len(), 1 + Aov::ALL.len());
    for threads in [1, 2, 3, 7] {
        for tile_size in [8, 16, 64] {
            let other = render(&scene, &options(threads, tile_size), &());
            assert_eq!(other.status, reference.status, "{threads} threads, tiles of {tile_size}");
            for (a, b) in layers.iter().zip(other.film.layers()) {
                assert!(
                    bits(&a.image) == bits(&b.image),
                    "{:?}, {threads} threads, tiles of {tile_size}",
                    a.name
                );
            }
            assert!(bits(&reference.film.variance()) == bits(&other.film.variance()));
        }
    }
}

#[test]
fn a_sample_alone_is_the_one_of_the_image() {
    // In the image paths go side by side; alone there is only one.
    let mut description = scene(1);
    description.filter = Filter::Box { radius: [0.5; 2] };
    let scene = built(&description);
    let image = render(&scene, &options(1, 16), &()).film.develop();
    let pixels = (2..35).flat_map(|y| (3..50).map(move |x| [x, y]));
    let alone: Vec<u32> = pixels.flat_map(|pixel| scene.sample(pixel, 0).rgb).map(f32::to_bits).collect();
    assert!(bits(&image) == alone);
}

#[test]
fn features_do_not_change_the_image_and_seeds_do() {
    let description = scene(5);
    let plain = RenderOptions { threads: 1, ..RenderOptions::default() };
    let image = bits(&render(&built(&description), &plain, &()).film.develop());
    assert!(image == bits(&render(&built(&description), &options(1, 16), &()).film.develop()));
    let mut other = description.clone();
    other.sampler.seed = 2;
    assert!(image != bits(&render(&built(&other), &plain, &()).film.develop()));
    // More samples come after, not instead: a longer render passes through the shorter one's image.
    let mut longer = description;
    longer.sampler.kind = sahl_scene::SamplerKind::Independent;
    longer.sampler.samples = 4;
    let short = bits(&render(&built(&longer), &plain, &()).film.develop());
    longer.sampler.samples = 16;
    let keep = KeepImageAt { samples: 4, image: Mutex::new(Vec::new()) };
    render(&built(&longer), &plain, &keep);
    assert!(*keep.image.lock().unwrap() == short);
}

/// Keeps the image of the pass after which each pixel has a number of samples.
struct KeepImageAt {
    samples: u32,
    image: Mutex<Vec<u32>>,
}

impl Progress for KeepImageAt {
    fn pass_done(&self, _: &Status, film: &Film) -> ControlFlow<()> {
        if film.samples() == [self.samples; 2] {
            *self.image.lock().unwrap() = bits(&film.develop());
        }
        ControlFlow::Continue(())
    }
}

/// Ends the render after a number of tiles.
struct StopAfter {
    tiles: AtomicU32,
}

impl Progress for StopAfter {
    fn tile_done(&self, status: &Status) -> ControlFlow<()> {
        assert!(status.samples_done > 0 && status.samples_done <= status.samples_total && status.rays > 0);
        match self.tiles.fetch_sub(1, Ordering::Relaxed) {
            1 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }
}

#[test]
fn an_interrupted_render_is_a_part_of_the_whole() {
    let independent = |samples| {
        let mut scene = scene(samples);
        scene.sampler.kind = sahl_scene::SamplerKind::Independent;
        built(&scene)
    };
    let once = render(&independent(1), &options(1, 8), &()).film.develop();
    let scene = independent(16);
    for threads in [1, 3] {
        // 6 × 5 tiles a pass: the first pass ends within.
        let stopped = render(&scene, &options(threads, 8), &StopAfter { tiles: AtomicU32::new(7) });
        assert!(!stopped.completed);
        assert_eq!(stopped.film.samples(), [0, 1]);
        let mut reached = 0;
        for (part, whole) in values(&stopped.film.develop()).chunks(3).zip(values(&once).chunks(3)) {
            if part != [0.0; 3] {
                assert_eq!(part, whole);
                reached += 1;
            }
        }
        let taken = stopped.status.samples_done;
        // A pixel may be black on its own account.
        assert!(reached <= taken && reached * 10 >= taken * 8, "{reached} of {taken}");
        assert!((7 * 24..=10 * 64).contains(&taken), "{taken}");
    }
    // One of the last pixels to be reached has fewer samples than the first.
    let stopped = render(&scene, &options(1, 8), &StopAfter { tiles: AtomicU32::new(70) });
    assert_eq!(stopped.film.samples(), [2, 4]);
    assert!(values(&stopped.film.develop()).iter().all(|value| value.is_finite()));
    assert_eq!(stopped.status.pass, 2);
}

/// Notes the samples a pixel after each pass, and ends the render at a limit.
struct Passes {
    seen: Mutex<Vec<u32>>,
    limit: u32,
}

impl Progress for Passes {
    fn pass_done(&self, status: &Status, film: &Film) -> ControlFlow<()> {
        let [low, high] = film.samples();
        assert_eq!(low, high);
        assert_eq!(status.samples_done, u64::from(low) * 47 * 33);
        self.seen.lock().unwrap().push(low);
        if low >= self.limit { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[test]
fn passes_double_up_to_sixteen_samples() {
    let scene = built(&scene(50));
    let progress = Passes { seen: Mutex::new(Vec::new()), limit: u32::MAX };
    assert!(render(&scene, &options(2, 16), &progress).completed);
    assert_eq!(*progress.seen.lock().unwrap(), [1, 2, 4, 8, 16, 32, 48, 50]);
    let progress = Passes { seen: Mutex::new(Vec::new()), limit: 8 };
    let stopped = render(&scene, &options(2, 16), &progress);
    assert!(!stopped.completed);
    assert_eq!(stopped.film.samples(), [8, 8]);
}

#[test]
fn samples_without_a_colour_are_dropped_and_named() {
    let mut description = empty(6, 3);
    sky(&mut description, grey(3e38));
    let Light::Infinite { scale, .. } = &mut description.lights[sahl_scene::Handle::new(0)] else {
        unreachable!()
    };
    *scale = 100.0;
    for (threads, tile_size) in [(1, 16), (3, 2)] {
        let rendered = render(&built(&description), &options(threads, tile_size), &());
        assert!(rendered.completed);
        assert_eq!((rendered.status.dropped, rendered.film.dropped()), (108, 108));
        assert!(values(&rendered.film.develop()).iter().all(|&value| value == 0.0));
        let first = rendered.film.dropped_samples();
        let places: Vec<_> = first.iter().map(|sample| (sample.pixel, sample.index)).collect();
        // The first pass takes sample 0 of each pixel, row by row.
        assert_eq!(places[..3], [([0, 0], 0), ([1, 0], 0), ([2, 0], 0)]);
        assert_eq!(places[7], ([1, 1], 0));
        assert!(first[0].color[0].is_infinite());
    }
}
