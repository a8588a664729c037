use crate::{code, folder, sahl, stderr, stdout};

fn json(folder: &std::path::Path, arguments: &[&str]) -> serde_json::Value {
    let output = sahl(folder, arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

#[test]
fn speed_is_told_for_one_thread_and_all() {
    let folder = folder("bench");
    let value = json(&folder, &["bench", "--resolution", "16x16", "--spp", "2", "--json"]);
    assert_eq!(value["runs"][0]["threads"], 1);
    assert_eq!(value["runs"][0]["samples"], 16 * 16 * 2);
    let output = sahl(&folder, &["bench", "--resolution", "16x16", "--spp", "2"]);
    assert!(stdout(&output).contains("samples/s"), "{}", stdout(&output));
}

#[test]
fn trees_are_compared_and_drawn() {
    let folder = folder("bench-bvh");
    let value = json(&folder, &["bench", "bvh", "--resolution", "20x10", "--json"]);
    for (tree, name) in [(0, "median"), (1, "sah")] {
        let tree = &value["trees"][tree];
        assert_eq!(tree["builder"], name);
        assert_eq!(tree["camera"]["rays"], 200);
        assert!(tree["nodes"].as_u64().unwrap() > 0 && tree["sah_cost"].as_f64().unwrap() > 0.0);
        assert!(tree["camera"]["steps_per_ray"].as_f64().unwrap() > 0.0);
        let bytes = std::fs::read(folder.join(format!("cornell-box-steps-{name}.png"))).unwrap();
        let image = sahl::image::read(&bytes, "a.png").unwrap();
        assert_eq!((image.width, image.height), (20, 10));
    }
    assert_eq!(value["trees"][0]["bounce"]["rays"], value["trees"][1]["bounce"]["rays"]);

    let output = sahl(&folder, &["bench", "bvh", "--resolution", "20x10", "-o", "map"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("camera rays: median takes"), "{}", stdout(&output));
    assert!(folder.join("map-median.png").exists() && folder.join("map-sah.png").exists());
}
