//! The direction of dependencies between the crates of the workspace, read off `cargo metadata`.
//!
//! A crate that starts to use another one has to be given the right here first, where a reviewer sees it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};

/// Each crate, by its folder under `crates/`, and the crates of the workspace it may use; the lowest come first.
///
/// Tests, examples and benchmarks of a crate may use the crates listed above it as well, and `testkit`.
const MAY_USE: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("accel", &["math"]),
    ("image", &["math"]),
    ("testkit", &["image", "math"]),
    ("scene", &["image", "math"]),
    ("load", &["image", "math", "scene"]),
    ("render", &["accel", "image", "math", "scene"]),
    ("sahl", &["image", "load", "math", "render", "scene"]),
    ("cli", &["sahl"]),
];

/// The crate that only tests may use.
const TEST_ONLY: &str = "testkit";

fn workspace_root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn metadata() -> Metadata {
    MetadataCommand::new()
        .manifest_path(workspace_root().join("Cargo.toml"))
        .no_deps()
        .other_options(["--offline".to_owned()])
        .exec()
        .expect("cargo is there, since it runs this test")
}

/// The folder of a package under `crates/`; `None` for a package elsewhere.
fn folder(package: &Package) -> Option<&str> {
    let folder = package.manifest_path.parent()?;
    (folder.parent()?.file_name()? == "crates").then_some(folder.file_name()?)
}

/// A table that says, for each crate of `MAY_USE`, where it stands and what it may use.
fn rights() -> BTreeMap<&'static str, (usize, &'static [&'static str])> {
    MAY_USE.iter().enumerate().map(|(level, &(name, uses))| (name, (level, uses))).collect()
}

/// What is wrong with the use of `other` by `user`; `None` if it is allowed.
fn objection(user: &str, other: &str, kind: DependencyKind) -> Option<String> {
    let rights = rights();
    let Some(&(level, uses)) = rights.get(user) else {
        return Some(format!("`{user}` is not in the table of {}", file!()));
    };
    if uses.contains(&other) && other != TEST_ONLY {
        return None;
    }
    let allowed = if uses.is_empty() { "none".to_owned() } else { uses.join(", ") };
    if kind != DependencyKind::Development {
        return Some(format!("`{user}` must not depend on `{other}`; it may use: {allowed}"));
    }
    let below = rights.get(other).is_some_and(|&(other_level, _)| other_level < level);
    (other != TEST_ONLY && !below)
        .then(|| format!("tests of `{user}` must not depend on `{other}`, which is above it"))
}

#[test]
fn crates_use_only_what_the_table_allows() {
    let metadata = metadata();
    let names: BTreeMap<&str, &str> =
        metadata.packages.iter().filter_map(|p| Some((p.name.as_str(), folder(p)?))).collect();
    let mut objections = Vec::new();
    let mut seen = 0;
    for package in &metadata.packages {
        let Some(user) = folder(package) else { continue };
        for dependency in &package.dependencies {
            let Some(other) = names.get(dependency.name.as_str()) else { continue };
            seen += 1;
            objections.extend(objection(user, other, dependency.kind));
        }
    }
    assert!(objections.is_empty(), "\n{}", objections.join("\n"));
    assert!(
        seen >= 10,
        "only {seen} dependencies between crates were found: the reading of the metadata is wrong"
    );
}

#[test]
fn every_crate_is_in_the_table_and_the_table_has_no_other() {
    let folders = fs::read_dir(workspace_root().join("crates")).expect("this test lies in crates/");
    let present: BTreeSet<String> = folders
        .map(|entry| entry.expect("a folder that was just listed"))
        .filter(|entry| entry.path().join("Cargo.toml").exists())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    let listed: BTreeSet<String> = MAY_USE.iter().map(|&(name, _)| name.to_owned()).collect();
    assert_eq!(present, listed, "crates/ and the table of {} differ", file!());
}

#[test]
fn the_table_has_no_cycle() {
    let rights = rights();
    for (level, &(name, uses)) in MAY_USE.iter().enumerate() {
        for other in uses {
            let (other_level, _) = rights[other];
            assert!(other_level < level, "`{name}` may use `{other}`, which is not listed above it");
        }
    }
}

#[test]
fn every_crate_takes_the_lints_of_the_workspace() {
    for &(name, _) in MAY_USE {
        let manifest = workspace_root().join("crates").join(name).join("Cargo.toml");
        let text = fs::read_to_string(&manifest).expect("a crate has a manifest");
        let mut lines = text.lines().map(|line| line.trim().replace(' ', ""));
        let inherited =
            lines.any(|line| line == "[lints]") && lines.next().is_some_and(|line| line == "workspace=true");
        assert!(inherited, "crates/{name}/Cargo.toml lacks `[lints]` with `workspace = true`");
    }
}

#[test]
fn objections_are_raised() {
    use DependencyKind::{Build, Development, Normal};
    for (user, other, kind, allowed) in [
        ("render", "accel", Normal, true),
        ("accel", "scene", Normal, false),
        ("load", "render", Normal, false),
        ("load", "render", Build, false),
        ("render", "testkit", Normal, false),
        ("render", "testkit", Development, true),
        ("math", "testkit", Development, true),
        ("render", "load", Development, true),
        ("load", "render", Development, false),
        ("cli", "scene", Development, true),
        ("stranger", "math", Normal, false),
    ] {
        let objection = objection(user, other, kind);
        assert_eq!(objection.is_none(), allowed, "{user} -> {other} ({kind:?}): {objection:?}");
    }
}
