use crate::{code, folder, sahl, stdout};

fn help(arguments: &[&str]) -> String {
    let output = sahl(&folder("help"), arguments);
    assert_eq!(code(&output), 0);
    stdout(&output)
}

#[test]
fn help_is_as_documented() {
    insta::assert_snapshot!("sahl", help(&["--help"]));
    insta::assert_snapshot!("render", help(&["render", "--help"]));
    insta::assert_snapshot!("info", help(&["info", "--help"]));
    insta::assert_snapshot!("compare", help(&["compare", "--help"]));
    insta::assert_snapshot!("bench", help(&["bench", "--help"]));
    insta::assert_snapshot!("bench_bvh", help(&["bench", "bvh", "--help"]));
}
