use crate::{code, folder, sahl, scene, stdout};

/// Digits of what depends on how trees and buffers are laid out, as `#`.
fn without_sizes(text: &str) -> String {
    let hide = |line: &str| {
        let is_size = line.starts_with("tree") || line.starts_with("memory");
        let mut shown = String::new();
        for letter in line.chars() {
            match letter {
                '0'..='9' | '.' if is_size => {
                    if !shown.ends_with('#') {
                        shown.push('#');
                    }
                }
                _ => shown.push(letter),
            }
        }
        shown + "\n"
    };
    text.lines().map(hide).collect()
}

#[test]
fn the_built_in_scene_is_described() {
    let output = sahl(&folder("info"), &["info"]);
    assert_eq!(code(&output), 0);
    insta::assert_snapshot!("info_cornell_box", without_sizes(&stdout(&output)));
}

#[test]
fn a_lab_is_described() {
    let path = scene("labs/1-rays-and-triangles.pbrt");
    let output = sahl(&folder("info-lab"), &["info", path.to_str().unwrap()]);
    assert_eq!(code(&output), 0);
    let text = stdout(&output);
    // The first line holds the path of this checkout.
    let (_, rest) = text.split_once('\n').unwrap();
    insta::assert_snapshot!("info_lab", without_sizes(rest));
}

#[test]
fn json_holds_the_same() {
    let output = sahl(&folder("info-json"), &["info", "--json"]);
    assert_eq!(code(&output), 0);
    let value: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(value["primitives"]["triangles"], 32);
    assert_eq!(value["lights"]["emitting shape"], 1);
    assert_eq!(value["materials"]["diffuse"], 4);
    assert_eq!(value["warnings"], 0);
    assert!(value["tree"]["nodes"].as_u64().unwrap() > 0);
}
