use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::{code, command, folder, render, sahl, stderr};

/// Runs in a folder of its own, and checks the exit code and that the message holds `text`.
fn fails(arguments: &[&str], expected: i32, text: &str) {
    static RUNS: AtomicUsize = AtomicUsize::new(0);
    let run = RUNS.fetch_add(1, Ordering::Relaxed);
    let output = sahl(&folder(&format!("failures-{run}")), arguments);
    let message = stderr(&output);
    assert_eq!(code(&output), expected, "{arguments:?}: {message}");
    assert!(message.contains(text), "{arguments:?}: expected `{text}` in: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?}: messages belong on the standard error");
}

#[test]
fn senseless_requests_are_usage_errors() {
    fails(&["rende"], 2, "render");
    fails(&["render", "--sp", "4"], 2, "--spp");
    fails(&["render", "--spp", "0"], 2, "--spp");
    fails(&["render", "--resolution", "64"], 2, "640x480");
    fails(&["render", "--resolution", "64x64", "--crop", "70,80,0,10"], 2, "holds no pixel");
    fails(&["render", "--crop", "0,8,0,8", "--cropwindow", "0,1,0,1"], 2, "--cropwindow");
    fails(&["render", "--camera", "1"], 2, "one camera");
    fails(&["render", "--integrator", "ao", "--max-depth", "3"], 2, "no meaning");
    fails(&["render", "--integrator", "ao", "--clamp-indirect", "3"], 2, "alone");
    fails(&["render", "--integrator", "whitted", "--smooth-terminator"], 2, "alone");
    fails(&["render", "--clamp-indirect", "0"], 2, "above zero");
    fails(&["render", "-D", "ssp=4"], 2, "did you mean `spp`?");
    fails(&["render", "-Dspp=four"], 2, "`four` is no spp");
    fails(&["render", "-Dspp=4", "--spp", "4"], 2, "given twice");
    fails(&["render", "--pixel", "600,3"], 2, "no pixel");
    fails(&["render", "--pixel", "6,3", "-o", "a.exr"], 2, "--pixel");
    fails(&["render", "a.obj", "b.pbrt"], 2, "a.obj");
    fails(&["compare", "a.exr"], 2, "none is the reference");
    fails(&["compare", "a.exr", "b.exr", "--ref-var", "v.exr"], 2, "--var");
}

#[test]
fn what_does_not_exist_yet_is_said() {
    for option in [
        &["--noise", "0.01"][..],
        &["--checkpoint", "a.ckpt"],
        &["--resume", "a.ckpt"],
        &["--tev", "localhost:14158"],
        &["--display-server", "localhost:14158"],
    ] {
        let mut arguments = vec!["render", "-o", "a.png"];
        arguments.extend(option);
        fails(&arguments, 2, "is not available yet");
    }
}

#[test]
fn a_file_of_the_scene_is_not_replaced_by_its_image() {
    let folder = folder("failures-inputs");
    let texture = render(&folder, "floor.png", &[]);
    let scene = r#"
        WorldBegin
        LightSource "infinite"
        Texture "floor" "spectrum" "imagemap" "string filename" "floor.png"
        Material "diffuse" "texture reflectance" "floor"
        Shape "sphere""#;
    fs::write(folder.join("scene.pbrt"), scene).unwrap();
    let rest = ["--resolution", "8x8", "--spp", "1"];
    for name in ["floor.png", "./floor.png"] {
        let output = sahl(&folder, &[&["render", "scene.pbrt", "-o", name], &rest[..]].concat());
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{message}");
        assert!(message.contains("is a file that the scene is read from"), "{message}");
    }
    assert_eq!(fs::read(folder.join("floor.png")).unwrap(), texture);
    // Another file by that name, once and again, is called what it was named.
    for _ in 0..2 {
        let output = sahl(&folder, &[&["render", "scene.pbrt", "-o", "other.png"], &rest[..]].concat());
        assert!(stderr(&output).starts_with("other.png: "), "{}", stderr(&output));
    }
}

#[test]
fn outputs_are_checked_before_the_scene_is_read() {
    // The scene does not exist: were it read first, it would be told.
    fails(&["render", "missing.pbrt", "-o", "a.gif"], 2, "does not tell an image format");
    fails(&["render", "missing.pbrt", "-o", "a"], 2, "does not tell an image format");
    fails(&["render", "missing.pbrt", "-o", "a.jpg"], 2, "can only be read");
    fails(&["render", "missing.pbrt", "-o", "a.png", "--aov", "depth"], 2, "needs layers");
    fails(&["render", "missing.pbrt", "-o", "a.exr", "--exposure", "1"], 2, "do not apply");
    fails(&["render", "missing.pbrt", "-o", "no/such/folder/a.png"], 4, "no/such/folder/a.png");
    fails(&["compare", "a.exr", "b.exr", "--png", "a.exr"], 2, ".png");
}

#[test]
fn files_that_are_missing_are_no_scene_errors() {
    fails(&["render", "missing.pbrt", "-o", "a.png"], 4, "missing.pbrt");
    fails(&["render", "missing.pbrt", "other.pbrt", "-o", "a.png"], 4, "missing.pbrt");
    fails(&["info", "missing.pbrt"], 4, "missing.pbrt");
    fails(&["render", ".", "-o", "a.png"], 4, "directory");
    fails(&["compare", "a.exr", "b.exr"], 4, "a.exr");
}

#[test]
fn broken_scenes_are_scene_errors_with_a_place() {
    let folder = folder("broken");
    fs::write(folder.join("broken.pbrt"), "WorldBegin\nShape \"spere\" \"float radius\" [ 1 \n").unwrap();
    for arguments in
        [&["render", "broken.pbrt", "-o", "a.png"][..], &["info", "broken.pbrt"], &["bench", "broken.pbrt"]]
    {
        let output = sahl(&folder, arguments);
        assert_eq!(code(&output), 3, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains("broken.pbrt:2"), "{arguments:?}: {}", stderr(&output));
    }
    assert!(!folder.join("a.png").exists());
    let output = sahl(&folder, &["render", "broken.pbrt", "-o", "a.png", "--diagnostics", "json"]);
    assert_eq!(code(&output), 3);
    for line in stderr(&output).lines() {
        let value: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(value["event"] == "diagnostic" || value["event"] == "error", "{line}");
    }
}

#[test]
fn strict_makes_errors_of_warnings() {
    let folder = folder("strict");
    let text = "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n\n\
                Accelerator \"kdtree\"\nWorldBegin\nLightSource \"infinite\"\nShape \"sphere\"\n";
    fs::write(folder.join("tree.pbrt"), text).unwrap();
    let arguments = ["render", "tree.pbrt", "--spp", "1", "-o", "a.png"];
    let output = sahl(&folder, &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("warning"), "{}", stderr(&output));
    let quiet = sahl(&folder, &[&arguments[..], &["--quiet"]].concat());
    assert_eq!((code(&quiet), stderr(&quiet)), (0, String::new()));
    let strict = sahl(&folder, &[&arguments[..], &["--strict", "--quiet"]].concat());
    assert_eq!(code(&strict), 3);
    assert!(stderr(&strict).contains("tree.pbrt:3"), "quiet hides no error: {}", stderr(&strict));
}

#[test]
fn colour_is_for_those_who_want_it() {
    let folder = folder("colour");
    let arguments = ["render", "missing.pbrt"];
    let run = |variables: &[(&str, &str)]| {
        let output = command(&folder, &arguments).envs(variables.iter().copied()).output().unwrap();
        stderr(&output).contains('\x1b')
    };
    assert!(!run(&[]), "not a terminal");
    assert!(run(&[("CLICOLOR_FORCE", "1")]));
    assert!(!run(&[("CLICOLOR_FORCE", "0")]));
    assert!(!run(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]));
}

#[test]
fn nothing_is_left_beside_the_image() {
    let folder = folder("beside");
    render(&folder, "a.png", &[]);
    let names: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["a.png"]);
}
