//! No panic can be reached: the handler calls a symbol that nothing defines, and the image links all the same.

/// Links one image of the package `links`; what the linker said where it failed.
fn link(profile: &str, image: &str) -> Result<(), String> {
    let target = super::root().join("target/images");
    let output = super::cargo()
        .args(["build", "--profile", profile, "-p", "links", "--bin", image, "--target-dir"])
        .arg(target)
        .output()
        .expect("cargo runs");
    output.status.success().then_some(()).ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Every hot-path function of the kernel, in both precisions and both math backends.
#[test]
#[ignore = "needs the target thumbv7em-none-eabihf; tests/run runs it"]
fn no_panic_can_be_reached() {
    for profile in ["release", "release-small"] {
        if let Err(message) = link(profile, "panic_free") {
            panic!("{profile}: a hot-path function can panic\n{message}");
        }
    }
}

#[test]
#[ignore = "needs the target thumbv7em-none-eabihf; tests/run runs it"]
fn a_function_that_can_panic_does_not_link() {
    for profile in ["release", "release-small"] {
        let message = link(profile, "panicking").expect_err("index_panicking can panic");
        assert!(message.contains("panicking branch"), "{message}");
    }
}
