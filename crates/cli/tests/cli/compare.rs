use crate::{code, folder, render, sahl, stderr, stdout};

#[test]
fn equal_images_have_no_error() {
    let folder = folder("compare-equal");
    render(&folder, "a.exr", &[]);
    let output = sahl(&folder, &["compare", "a.exr", "a.exr", "--json", "--png", "difference.png"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let value: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(value["mse"], 0.0);
    assert_eq!(value["flip"], 0.0);
    assert!(value["psnr"].is_null() && value["z_test"].is_null());
    let picture = sahl::image::read(&std::fs::read(folder.join("difference.png")).unwrap(), "a.png").unwrap();
    assert_eq!((picture.width, picture.height), (4 * 24, 24));
}

#[test]
fn seeds_agree_and_a_darker_image_is_found() {
    let folder = folder("compare-seeds");
    let size = ["--resolution", "32x32", "--spp", "16", "--integrator", "ao"];
    for seed in ["1", "2", "3"] {
        let name = format!("{seed}.exr");
        let arguments = [&["render", "-o", &name, "--seed", seed, "--aov", "variance"][..], &size].concat();
        assert_eq!(code(&sahl(&folder, &arguments)), 0);
    }
    let darker = [&["render", "-o", "path.exr", "--seed", "4"][..], &size[..4]].concat();
    assert_eq!(code(&sahl(&folder, &darker)), 0);

    let alike = sahl(&folder, &["compare", "1.exr", "2.exr", "--ref", "3.exr", "--ref-var", "3.exr"]);
    assert_eq!(code(&alike), 0, "{}{}", stdout(&alike), stderr(&alike));
    assert!(stdout(&alike).contains("bias                   no"), "{}", stdout(&alike));
    let one = sahl(&folder, &["compare", "1.exr", "3.exr", "--var", "1.exr", "--ref-var", "3.exr"]);
    assert_eq!(code(&one), 0, "{}{}", stdout(&one), stderr(&one));

    let other = sahl(&folder, &["compare", "1.exr", "2.exr", "--ref", "path.exr"]);
    assert_eq!(code(&other), 1, "{}{}", stdout(&other), stderr(&other));
    assert!(stdout(&other).contains("YES"), "{}", stdout(&other));
}

#[test]
fn the_same_image_twice_is_no_second_seed() {
    let folder = folder("compare-identical");
    let size = ["--resolution", "32x32", "--spp", "2"];
    for name in ["a.exr", "b.exr", "other.exr"] {
        let seed = if name == "other.exr" { "5" } else { "1" };
        let arguments = [&["render", "-o", name, "--seed", seed][..], &size].concat();
        assert_eq!(code(&sahl(&folder, &arguments)), 0);
    }
    for second in ["a.exr", "b.exr"] {
        let output = sahl(&folder, &["compare", "a.exr", second, "--ref", "other.exr"]);
        assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
        assert!(stdout(&output).contains("unknown: images 1 and 2 are identical"), "{}", stdout(&output));
    }
}

#[test]
fn negative_pixels_come_with_a_reason() {
    let folder = folder("compare-negative");
    let values = [[0.5; 3], [-0.1, 0.2, 0.3]].concat();
    let image = sahl::image::Image::rgb_f32(2, 1, values).unwrap();
    let bytes = image.encode(sahl::image::Format::Pfm, &sahl::image::EncodeOptions::default()).unwrap();
    std::fs::write(folder.join("a.pfm"), bytes).unwrap();
    let output = sahl(&folder, &["compare", "a.pfm", "a.pfm"]);
    assert!(stdout(&output).contains("1 (filters such as `mitchell`"), "{}", stdout(&output));
}

#[test]
fn sizes_must_agree() {
    let folder = folder("compare-sizes");
    render(&folder, "a.exr", &[]);
    render(&folder, "b.exr", &["--crop", "0,8,0,8"]);
    let output = sahl(&folder, &["compare", "a.exr", "b.exr"]);
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    assert_eq!(stderr(&output).matches("can't be compared").count(), 1, "{}", stderr(&output));
}
