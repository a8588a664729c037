use std::fs;
use std::io::Write;
use std::process::Stdio;

use crate::{code, command, folder, render, sahl, scene, stderr, stdout};

#[test]
fn without_a_scene_the_cornell_box_is_rendered() {
    let folder = folder("cornell");
    let output = sahl(&folder, &["render", "--spp", "4", "--resolution", "48x48"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let image = sahl::image::read(&fs::read(folder.join("cornell-box.png")).unwrap(), "a.png").unwrap();
    assert_eq!((image.width, image.height), (48, 48));
    // The red wall is on the left, the green one on the right, and the lamp at the top is white.
    let [left, right] = [image.pixel(5, 24), image.pixel(42, 24)];
    assert!(left[0] > 2.0 * left[1], "{left:?}");
    assert!(right[1] > 1.5 * right[0], "{right:?}");
    assert!(image.pixel(24, 5)[1] > 0.9, "{:?}", image.pixel(24, 5));
    assert!(stderr(&output).contains("cornell-box.png"), "the summary: {}", stderr(&output));
    assert!(stdout(&output).is_empty());
}

#[test]
fn every_format_is_written() {
    let folder = folder("formats");
    for (name, start) in [
        ("a.png", &b"\x89PNG"[..]),
        ("a.exr", b"\x76\x2f\x31\x01"),
        ("a.ppm", b"P6"),
        ("a.hdr", b"#?"),
        ("a.pfm", b"PF"),
    ] {
        let bytes = render(&folder, name, &[]);
        assert!(bytes.starts_with(start), "{name}");
        let image = sahl::image::read(&bytes, name).unwrap();
        assert_eq!((image.width, image.height), (24, 24), "{name}");
    }
}

#[test]
fn threads_and_tiles_do_not_change_a_bit() {
    let folder = folder("determinism");
    let render = |threads: &str, tile: &str| {
        let more =
            ["--resolution", "40x28", "-t", threads, "--tile-size", tile, "--aov", "albedo,normal,depth"];
        let mut arguments = vec!["render", "--spp", "4", "-o", "a.exr"];
        arguments.extend(more);
        let output = sahl(&folder, &arguments);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        fs::read(folder.join("a.exr")).unwrap()
    };
    let first = render("1", "16");
    for (threads, tile) in [("2", "16"), ("3", "16"), ("7", "16"), ("1", "8"), ("2", "64"), ("7", "8")] {
        assert!(render(threads, tile) == first, "{threads} threads, tiles of {tile}");
    }
}

#[test]
fn aliases_mean_the_same() {
    let folder = folder("aliases");
    let plain = render(&folder, "a.exr", &["--seed", "3", "-t", "1", "--crop", "6,18,0,12"]);
    let pbrt = ["render", "--outfile", "b.exr", "--nthreads", "1", "--cropwindow", "0.25,0.75,0,0.5"];
    let pbrt = [&pbrt[..], &["-Dspp=2", "-D", "seed=3", "-Dwidth=24", "-Dheight=24"]].concat();
    let output = sahl(&folder, &pbrt);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(fs::read(folder.join("b.exr")).unwrap() == plain);
    assert!(render(&folder, "c.exr", &["--seed", "4", "--pixelbounds", "6,18,0,12"]) != plain);
}

#[test]
fn a_crop_that_reaches_outside_is_cut_with_a_warning() {
    let folder = folder("crop-outside");
    let arguments = ["render", "--resolution", "24x24", "--spp", "1", "-o", "a.exr", "--crop", "8,40,0,24"];
    let output = sahl(&folder, &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let message = "the crop 8,40,0,24 reaches beyond the 24x24 image: 8,24,0,24 is rendered";
    assert!(stderr(&output).contains(message), "{}", stderr(&output));
    let image = sahl::image::read(&fs::read(folder.join("a.exr")).unwrap(), "a.exr").unwrap();
    assert_eq!((image.width, image.height), (16, 24));
    let strict = sahl(&folder, &[&arguments[..], &["--strict"]].concat());
    assert_eq!(code(&strict), 3, "{}", stderr(&strict));
}

#[test]
fn layers_have_the_names_that_compositors_know() {
    let folder = folder("layers");
    let more = ["--aov", "albedo,normal,geometric-normal,depth,position,uv,variance"];
    let bytes = render(&folder, "a.exr", &more);
    let picture = sahl::image::read_layers(&bytes, "a.exr").unwrap();
    let names: Vec<_> = picture
        .layers
        .iter()
        .flat_map(|layer| {
            let prefix = layer.name.as_ref().map_or(String::new(), |name| format!("{name}."));
            layer.channel_names.iter().map(move |channel| format!("{prefix}{channel}"))
        })
        .collect();
    for name in ["R", "G", "B", "Albedo.R", "Ns.X", "N.X", "Z", "P.X", "u", "v", "Variance.R"] {
        assert!(names.iter().any(|known| known == name), "{name} of {names:?}");
    }
}

#[test]
fn a_pixel_is_replayed() {
    let folder = folder("pixel");
    let bytes = render(&folder, "a.exr", &[]);
    let image = sahl::image::read(&bytes, "a.exr").unwrap();
    let output = sahl(&folder, &["render", "--resolution", "24x24", "--spp", "2", "--pixel", "9,15"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split('\t').collect()).collect();
    assert_eq!(rows.len(), 4);
    assert_eq!(rows[0], ["sample", "red", "green", "blue"]);
    let mean: Vec<f32> = rows[3][1..].iter().map(|value| value.parse().unwrap()).collect();
    for channel in 0..3 {
        let value = image.pixel(9, 15)[channel];
        assert!((mean[channel] - value).abs() <= 1e-3 * value, "{mean:?}, {:?}", image.pixel(9, 15));
    }
}

#[test]
fn time_ends_a_render_with_an_image() {
    let folder = folder("time");
    let arguments = ["render", "--resolution", "32x32", "--spp", "1000000", "--time", "0.2", "-o", "a.exr"];
    let output = sahl(&folder, &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("time over"), "{}", stderr(&output));
    assert!(sahl::image::read(&fs::read(folder.join("a.exr")).unwrap(), "a.exr").is_ok());
}

#[test]
fn progress_is_json_on_request() {
    let folder = folder("json");
    let arguments = ["render", "--resolution", "24x24", "--spp", "2", "-o", "a.png", "--progress", "json"];
    let output = sahl(&folder, &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let events: Vec<serde_json::Value> =
        stderr(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let names: Vec<_> = events.iter().map(|event| event["event"].as_str().unwrap()).collect();
    assert_eq!((names.first(), names.last()), (Some(&"start"), Some(&"done")));
    assert!(names.contains(&"progress"), "{names:?}");
    let done = events.last().unwrap();
    assert_eq!(done["samples"], 24 * 24 * 2);
    assert_eq!(done["end"], "complete");
    assert_eq!(done["dropped"], 0);
}

#[test]
fn standard_input_and_several_files_are_scenes() {
    let folder = folder("inputs");
    let options =
        "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8 \"string filename\" \"x.exr\"\n";
    let world = "WorldBegin\nLightSource \"infinite\" \"rgb L\" [ 0.25 0.5 1 ]\n";
    fs::write(folder.join("options.pbrt"), options).unwrap();
    fs::write(folder.join("world.pbrt"), world).unwrap();
    let output = sahl(&folder, &["render", "options.pbrt", "world.pbrt", "--spp", "1", "--color", "rgb"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let several = fs::read(folder.join("x.exr")).unwrap();
    let image = sahl::image::read(&several, "x.exr").unwrap();
    assert_eq!(image.pixel(3, 3)[..3], [0.25, 0.5, 1.0]);

    fs::remove_file(folder.join("x.exr")).unwrap();
    let mut child = command(&folder, &["render", "-", "--spp", "1", "--color", "rgb"])
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(format!("{options}{world}").as_bytes()).unwrap();
    assert!(child.wait().unwrap().success());
    assert!(fs::read(folder.join("x.exr")).unwrap() == several);
}

#[test]
fn exposure_and_curve_change_pictures() {
    let folder = folder("picture");
    let plain = render(&folder, "a.png", &[]);
    assert!(render(&folder, "b.png", &["--exposure", "0", "--tonemap", "srgb"]) == plain);
    assert!(render(&folder, "c.png", &["--exposure", "-1"]) != plain);
    assert!(render(&folder, "d.png", &["--tonemap", "filmic"]) != plain);
}

#[test]
fn the_gallery_and_the_built_in_scene_are_one() {
    let folder = folder("gallery");
    let path = scene("gallery/cornell-box.pbrt");
    let built_in = render(&folder, "a.exr", &[]);
    assert!(render(&folder, "b.exr", &[path.to_str().unwrap()]) == built_in);
    for builder in ["median", "fast", "sah", "high"] {
        let other = render(&folder, "c.exr", &["--accel", builder]);
        assert!(other == built_in, "trees do not change the image: {builder}");
    }
}
