# Recipes for `just`; without it, type the command. What the checks are is said in .ci/run.

# List the recipes.
default:
    @just --list

# All checks that a change must pass, or only those named: format, clippy, doc, test.
check *steps:
    .ci/run {{steps}}

# Lay out the sources.
format:
    cargo fmt --all

# All tests.
test:
    .ci/run test

# The tests of one crate: `just test-crate render`.
test-crate crate *arguments:
    cargo test -p sahl-{{crate}} {{arguments}}

# Write the reference images of the tests named; they fail once, so that a second run is needed.
bless crate *filter:
    SAHL_BLESS=1 cargo test -p sahl-{{crate}} {{filter}} || true
    cargo test -p sahl-{{crate}} {{filter}}

# Accept new text snapshots, one by one (needs cargo-insta).
snapshots:
    cargo insta review

# The documentation of the workspace, in the browser.
doc:
    cargo doc --workspace --no-deps --open

# The release binary.
build:
    cargo build --release
