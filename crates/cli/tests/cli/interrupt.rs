use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

use crate::{command, folder};

/// Starts a render of days, waits for its first sign of life, and sends it `signal`.
fn interrupted_by(signal: &str) {
    let folder = folder(&format!("interrupt-{signal}"));
    let arguments =
        ["render", "--resolution", "64x64", "--spp", "100000000", "-o", "a.exr", "--progress", "json"];
    let mut child = command(&folder, &arguments).stderr(Stdio::piped()).spawn().unwrap();
    let mut messages = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("\"progress\"") {
        line.clear();
        assert!(messages.read_line(&mut line).unwrap() > 0, "the render ended by itself");
    }
    let status =
        Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
    assert!(status.success());
    let mut rest = String::new();
    messages.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest}");
    assert!(rest.contains("\"interrupted\""), "{rest}");
    let image = sahl::image::read(&std::fs::read(folder.join("a.exr")).unwrap(), "a.exr").unwrap();
    assert_eq!((image.width, image.height), (64, 64));
}

#[test]
fn ctrl_c_writes_the_image_so_far() {
    interrupted_by("INT");
}

#[test]
fn termination_writes_the_image_so_far() {
    interrupted_by("TERM");
}
