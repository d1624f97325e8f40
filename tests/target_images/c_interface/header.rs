//! The header is that of the source, and every compiler of C and C++ takes it without a warning.

use std::process::Command;

const HEADER: &str = "include/ballrace.h";

/// Header that cbindgen makes from the source.
fn generated() -> String {
    let config = cbindgen::Config::from_file(super::folder().join("cbindgen.toml")).expect("a readable configuration");
    let bindings = cbindgen::Builder::new().with_crate(super::folder()).with_config(config).generate();
    let mut text = Vec::new();
    bindings.expect("cbindgen reads the source").write(&mut text);
    // The annotation that declares arrays ends a comment with an empty line; the term of Rust is no term of C.
    String::from_utf8(text).expect("text").replace("\n *\n */", "\n */").replace("* # Safety", "* Preconditions:")
}

/// `BALLRACE_WRITE=1` rewrites it.
#[test]
#[ignore = "runs cargo metadata; tests/run runs it"]
fn the_header_is_that_of_the_source() {
    let path = super::folder().join(HEADER);
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        return std::fs::write(path, generated()).expect("the header is written");
    }
    let committed = std::fs::read_to_string(path).expect(HEADER);
    assert!(committed == generated(), "{HEADER} differs from the source: BALLRACE_WRITE=1 rewrites it");
}

/// Constants as firmware has them; C++17 has no designated initialisers.
const SOURCE: &str = "#include \"ballrace.h\"\n\
    static const ballrace_element elements[3] = { { 1.0f, 0.0f, 0 }, { -0.5f, 0.9f, 1 }, { -0.5f, -0.9f, 2 } };\n\
    extern const ballrace_angular bearing;\n\
    const ballrace_angular bearing = { { &ballrace_angular_model, elements, 3 }, 1.0f, 1.0f, 1.0f, 1.0f, 0.0f, 0.0f, 1.0f };\n\
    int main(void) { return sizeof(ballrace_last_valid) == BALLRACE_LAST_VALID_SIZE ? 0 : 1; }\n";

#[test]
#[ignore = "needs gcc and gcc-arm-none-eabi; tests/run runs it"]
fn every_standard_takes_the_header_without_a_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    for (compiler, suffix, standard) in
        [("cc", "c", "c99"), ("cc", "c", "c11"), ("c++", "cpp", "c++17"), ("arm-none-eabi-gcc", "c", "c99")]
    {
        let source = folder.path().join(format!("header.{suffix}"));
        std::fs::write(&source, SOURCE).expect("a source");
        let built = Command::new(compiler)
            .args(["-Wall", "-Wextra", "-Werror", "-pedantic", "-c", "-o", "/dev/null"])
            .arg(format!("-std={standard}"))
            .arg("-I")
            .arg(super::folder().join("include"))
            .arg(&source)
            .status();
        assert!(
            built.expect("missing: a compiler; tests/run names the line to type").success(),
            "{compiler} {standard}"
        );
    }
}
