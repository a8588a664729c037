use proptest::prelude::*;

use crate::{Diagnostic, Diagnostics, Sources, Span};

fn sources(text: &[u8]) -> Sources {
    let mut sources = Sources::default();
    sources.add("scenes/box.pbrt", text);
    sources
}

/// A span in the first file of any sources.
fn span(start: usize, end: usize) -> Span {
    let file = Sources::default().add("", Vec::new());
    Span { file, start: start as u32, end: end as u32 }
}

fn render(sources: &Sources, diagnostics: impl IntoIterator<Item = Diagnostic>) -> String {
    let mut all = Diagnostics::default();
    all.extend(diagnostics);
    all.render_text(sources, false)
}

#[test]
fn a_message_shows_its_line() {
    let sources = sources(b"WorldBegin\nShape \"shpere\" \"float radius\" 2\n");
    let diagnostic = Diagnostic::error("unknown-shape", span(17, 25), "unknown shape `shpere`")
        .with_note("known shapes are `disk` and `sphere`")
        .with_help("did you mean `sphere`?");
    insta::assert_snapshot!(render(&sources, [diagnostic]), @r#"
    error[unknown-shape]: unknown shape `shpere`
     --> scenes/box.pbrt:2:7
      |
    2 | Shape "shpere" "float radius" 2
      |       ^^^^^^^^
      |
      = note: known shapes are `disk` and `sphere`
      = help: did you mean `sphere`?
    "#);
}

#[test]
fn several_messages_are_apart() {
    let sources = sources(b"a\nb c\n");
    let first = Diagnostic::warning("first", span(2, 3), "the letter `b`");
    let second = Diagnostic::error("second", None, "nothing to point at").with_note("but a note");
    let third = Diagnostic::warning("third", span(6, 6), "the end of the file");
    insta::assert_snapshot!(render(&sources, [first, second, third]), @r"
    warning[first]: the letter `b`
     --> scenes/box.pbrt:2:1
      |
    2 | b c
      | ^

    error[second]: nothing to point at
     |
     = note: but a note

    warning[third]: the end of the file
     --> scenes/box.pbrt:3:1
      |
    3 |
      | ^
    ");
}

#[test]
fn a_span_over_lines_shows_the_first() {
    let sources = sources(b"Shape \"disk\"\r\n  \"float radius\" 2\r\nx\r\n");
    let diagnostic = Diagnostic::warning("no-area", span(0, 30), "a shape without area");
    insta::assert_snapshot!(render(&sources, [diagnostic]), @r#"
    warning[no-area]: a shape without area
     --> scenes/box.pbrt:1:1
      |
    1 | Shape "disk"
      | ^^^^^^^^^^^^
    "#);
}

#[test]
fn a_file_without_text_is_named() {
    let mut sources = sources(b"");
    let file = sources.add("mesh.ply", b"ply\nend_header\n".as_slice());
    let at_start = Diagnostic::error("empty", span(0, 0), "an empty file");
    let beyond = Span { file, start: 4000, end: 4004 };
    let beyond = Diagnostic::error("bad-index", beyond, "byte 4000: vertex 7 of 3");
    let whole = Diagnostic::warning("bad-mesh", Span::of_file(file), "2 faces are left out");
    insta::assert_snapshot!(render(&sources, [at_start, beyond, whole]), @r"
    error[empty]: an empty file
    --> scenes/box.pbrt

    error[bad-index]: byte 4000: vertex 7 of 3
    --> mesh.ply

    warning[bad-mesh]: 2 faces are left out
    --> mesh.ply
    ");
}

#[test]
fn of_a_long_line_a_window_is_shown() {
    let mut text = b"Shape \"trianglemesh\" \"point3 P\" [ ".to_vec();
    for i in 0..500_000 {
        text.extend(format!("{i} ").into_bytes());
    }
    let start = text.len();
    text.extend(b"oops ");
    text.extend(b"0 ".repeat(500_000));
    let sources = sources(&text);
    let diagnostic = Diagnostic::error("syntax", span(start, start + 4), "expected a number");
    insta::assert_snapshot!(render(&sources, [diagnostic]), @r"
    error[syntax]: expected a number
     --> scenes/box.pbrt:1:3388925
      |
    1 | ...991 499992 499993 499994 499995 499996 499997 499998 499999 oops 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0...
      |                                                                ^^^^
    ");
    let whole = Diagnostic::error("syntax", span(0, text.len()), "all of it");
    insta::assert_snapshot!(render(&sources, [whole]), @r#"
    error[syntax]: all of it
     --> scenes/box.pbrt:1:1
      |
    1 | Shape "trianglemesh" "point3 P" [ 0 1 2 3 4 5 6 7 8 9 10 11 ...
      | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
    "#);
}

#[test]
fn binary_text_and_escapes_are_made_visible() {
    let sources = sources(b"\x1b[31m\x00\xff\xfe \xc2\x9b2J \xe2\x80\xae abc\ttab\n");
    let diagnostic = Diagnostic::error("syntax", span(5, 8), "found `\x1b[2J\u{9b}\u{202e}`");
    let text = render(&sources, [diagnostic]);
    insta::assert_snapshot!(text, @r"
    error[syntax]: found `␛[2J��`
     --> scenes/box.pbrt:1:6
      |
    1 | ␛[31m␀�� �2J � abc tab
      |      ^^^
    ");
    assert!(text.chars().all(|c| c == '\n' || !c.is_control()));
}

#[test]
fn a_message_of_megabytes_is_cut() {
    let long = "ab".repeat(1_000_000);
    let text = render(&Sources::default(), [Diagnostic::error("long", None, long)]);
    assert!(text.len() < 2000, "{}", text.len());
    assert!(text.contains("ab ... ab"));
}

#[test]
fn colour_adds_escapes_and_nothing_else() {
    let sources = sources(b"Shape \"shpere\"\n");
    let mut all = Diagnostics::default();
    all.push(Diagnostic::error("unknown-shape", span(6, 14), "unknown shape"));
    let coloured = all.render_text(&sources, true);
    assert!(coloured.contains("\x1b["));
    let mut plain = String::new();
    let mut rest = coloured.as_str();
    assert!(!coloured.contains(":::"));
    while let Some((before, after)) = rest.split_once("\x1b[") {
        plain.push_str(before);
        rest = after.split_once('m').unwrap().1;
    }
    assert_eq!(plain + rest, all.render_text(&sources, false));
}

#[test]
fn json_has_one_object_a_line() {
    let sources = sources("Shape \"ü\" x\n \"y\"\n".as_bytes());
    let mut all = Diagnostics::default();
    all.push(Diagnostic::error("one", span(11, 17), "the `x`").with_note("a \"quoted\" note"));
    all.push(Diagnostic::warning("two", None, "nowhere").with_help("nothing"));
    all.push(Diagnostic::warning("three", span(900, 901), "beyond"));
    insta::assert_snapshot!(all.render_json(&sources), @r#"
    {"code":"one","column":11,"endColumn":5,"endLine":2,"file":"scenes/box.pbrt","help":null,"line":1,"message":"the `x`","notes":["a \"quoted\" note"],"severity":"error"}
    {"code":"two","column":null,"endColumn":null,"endLine":null,"file":null,"help":"nothing","line":null,"message":"nowhere","notes":[],"severity":"warning"}
    {"code":"three","column":null,"endColumn":null,"endLine":null,"file":"scenes/box.pbrt","help":null,"line":null,"message":"beyond","notes":[],"severity":"warning"}
    "#);
}

#[test]
fn spans_of_other_sources_do_no_harm() {
    let diagnostic = Diagnostic::error("lost", span(1, 2), "a message");
    insta::assert_snapshot!(render(&Sources::default(), [diagnostic]), @"error[lost]: a message");
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(5),
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_bytes_and_any_span_can_be_rendered(
        text in proptest::collection::vec(prop_oneof![any::<u8>(), Just(b'\n'), Just(b'\r'), Just(0xCC)], 0..400),
        start in 0usize..420,
        length in 0usize..420,
    ) {
        let sources = sources(&text);
        let diagnostic = Diagnostic::error("any", span(start, start + length), "a message");
        let rendered = render(&sources, [diagnostic.clone()]);
        prop_assert!(rendered.chars().all(|c| c == '\n' || !c.is_control()), "{rendered:?}");
        prop_assert!(rendered.len() < 4000);
        let mut all = Diagnostics::default();
        all.push(diagnostic);
        prop_assert_eq!(all.render_json(&sources).lines().count(), 1);
    }
}
