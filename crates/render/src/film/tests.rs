use super::*;
use crate::Spectrum;
use crate::spectrum::Wavelengths;

fn description() -> sahl_scene::Film {
    sahl_scene::Film { resolution: [7, 5], ..Default::default() }
}

fn at(pixel: [u32; 2], index: u32) -> SampleId {
    SampleId { pass: 0, pixel, index }
}

/// Adds a sample of the pixel's own colour, (column, row, 1), to every pixel.
fn fill(film: &mut Film) {
    for tile in film.tiles_mut() {
        for (place, pixel) in tile.pixels() {
            let color = Spectrum::from_rgb([pixel[0] as f32, pixel[1] as f32, 1.0]);
            tile.add(place, color, &Wavelengths::Rgb, 1.0, at(pixel, 0));
        }
    }
}

fn values(image: &Image) -> &[f32] {
    match &image.pixels {
        sahl_image::Pixels::F32(values) => values,
        sahl_image::Pixels::U8(_) => panic!("films develop to floats"),
    }
}

#[test]
fn tiles_cover_every_pixel_once() {
    for tile_size in [0, 1, 2, 3, 4, 5, 7, 64] {
        let mut film = Film::new(&description(), &[], tile_size);
        fill(&mut film);
        assert_eq!(film.samples(), [1, 1]);
        let image = film.develop();
        assert_eq!((image.width, image.height), (7, 5));
        for (i, rgb) in values(&image).chunks(3).enumerate() {
            assert_eq!(rgb, [(i % 7) as f32, (i / 7) as f32, 1.0]);
        }
    }
}

#[test]
fn a_crop_holds_its_part_of_the_image() {
    let mut film = Film::new(&sahl_scene::Film { crop: Some([2, 6, 1, 3]), ..description() }, &[], 3);
    fill(&mut film);
    assert_eq!((film.size(), film.crop(), film.resolution()), ([4, 2], [2, 6, 1, 3], [7, 5]));
    assert_eq!(values(&film.develop())[..6], [2.0, 1.0, 1.0, 3.0, 1.0, 1.0]);
    for (crop, expected) in [([9, 20, 0, 9], [6, 7, 0, 5]), ([3, 1, 2, 2], [3, 4, 2, 3])] {
        let film = Film::new(&sahl_scene::Film { crop: Some(crop), ..description() }, &[], 3);
        assert_eq!(film.crop(), expected);
    }
}

#[test]
fn what_is_no_colour_is_counted_and_left_out() {
    let mut film = Film::new(&description(), &[], 2);
    fill(&mut film);
    for tile in film.tiles_mut() {
        for (place, pixel) in tile.pixels() {
            for (index, bad) in [f32::NAN, f32::INFINITY, -1.0].into_iter().enumerate() {
                let color = Spectrum::from_rgb([1.0, 1.0, bad]);
                tile.add(place, color, &Wavelengths::Rgb, 1.0, at(pixel, index as u32 + 1));
            }
        }
    }
    assert_eq!(film.dropped(), 3 * 35);
    assert_eq!(film.samples(), [1, 1]);
    assert!(values(&film.develop()).iter().all(|x| x.is_finite()));
    let first = film.dropped_samples();
    assert_eq!(first.len(), tile::REMEMBERED);
    let places: Vec<_> = first.iter().map(|sample| (sample.pixel, sample.index)).collect();
    assert_eq!(places[..4], [([0, 0], 1), ([0, 0], 2), ([0, 0], 3), ([1, 0], 1)]);
}

#[test]
fn pixels_without_samples_are_black() {
    let film = Film::new(&description(), &[Aov::Albedo, Aov::Depth], 4);
    assert!(values(&film.develop()).iter().all(|&x| x == 0.0));
    assert!(values(&film.variance()).iter().all(|&x| x == f32::INFINITY));
    for layer in film.layers() {
        assert!(values(&layer.image).iter().all(|&x| x == 0.0), "{:?}", layer.name);
    }
    assert_eq!(film.samples(), [0, 0]);
}
