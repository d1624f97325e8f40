//! What an image of C contains: no reachable panic, only the models that it names, two static libraries of Rust.

use super::image::{Abi, Image, binutils, library};
use std::path::Path;

/// Exported symbols of a library.
fn exported(library: &Path) -> Vec<String> {
    let symbols = binutils("nm", &["--defined-only", "--extern-only"], library);
    let names = symbols.lines().filter_map(|line| line.split_whitespace().nth(2));
    names.filter(|name| name.starts_with("ballrace_")).map(str::to_owned).collect()
}

/// An image that contains these symbols.
fn with_symbols(abi: Abi, library: &Path, names: &[String]) -> Result<super::image::Linked, String> {
    let mut text = "void run(void);\n".to_owned();
    for (i, name) in names.iter().enumerate() {
        text += &format!("extern const char {name}[];\nextern const void *volatile kept_{i};\n");
        text += &format!("const void *volatile kept_{i} = {name};\n");
    }
    text += "void run(void)\n{\n";
    for i in 0..names.len() {
        text += &format!("    (void)kept_{i};\n");
    }
    text += "}\n";
    Image::new(abi).libraries(&[library.to_owned()]).text("names.c", &text).try_link("names")
}

/// The panic handler calls a symbol that nothing defines, and an image with every function links all the same.
#[test]
#[ignore = "needs gcc-arm-none-eabi and two targets; tests/run runs it"]
fn no_call_reaches_a_panic() {
    const CONTROL: &str = "ballrace_control_that_can_panic";
    for abi in [Abi::Hard, Abi::Soft] {
        let library = library(abi.target());
        let (control, names): (Vec<String>, Vec<String>) =
            exported(&library).into_iter().partition(|name| name == CONTROL);
        assert!(names.len() > 80, "{} symbols", names.len());
        if let Err(message) = with_symbols(abi, &library, &names) {
            panic!("{abi:?}: a call can panic\n{message}");
        }
        let message = with_symbols(abi, &library, &control).err().expect("the control can panic");
        assert!(message.contains("ballrace_a_panic_can_be_reached"), "{message}");
    }
}

/// Source of an image that evaluates one model, with its constants in flash.
fn with_model(model: &str) -> String {
    let kind = if model == "none" { "linear" } else { model };
    let constants = format!(
        "static const ballrace_element elements[8] = {{ {{ 1.0f, 0.0f, 0 }} }};\n\
         static const ballrace_{kind} bearing = {{ .head = {{ &ballrace_{kind}_model, elements, 8 }} }};\n"
    );
    let call = "ballrace_sample(&bearing.head, &last_valid, displacement, 0, wrench)";
    let (constants, call) = if model == "none" { (String::new(), "0") } else { (constants, call) };
    format!(
        "#include \"ballrace.h\"\n#include \"board.h\"\n{constants}\
         float displacement[5], wrench[5];\nballrace_last_valid last_valid;\n\
         void run(void) {{ print_number({call}); }}\n"
    )
}

/// Bytes of code and constants.
fn text_bytes(image: &super::image::Linked) -> u32 {
    let table = image.binutils("size", &[]);
    let line = table.lines().nth(1).expect("a line of sizes");
    line.split_whitespace().next().and_then(|text| text.parse().ok()).expect("a number")
}

/// Names of types in the symbols of generic functions.
const MODELS: [(&str, &str); 5] = [
    ("linear", "6linear6Linear"),
    ("lumped_radial", "_12LumpedRadial"),
    ("lumped_radial_axial", "_17LumpedRadialAxial"),
    ("angular", "7angular7Angular"),
    ("tabulated", "9tabulated10WithFields"),
];

fn image_of_model(model: &str) -> super::image::Linked {
    Image::new(Abi::Hard).text("one_model.c", &with_model(model)).link("one_model")
}

/// Bytes of flash of each model: an image with its force from constants, less the same image without.
pub fn flash() -> [(&'static str, u32); 5] {
    let empty = text_bytes(&image_of_model("none"));
    MODELS.map(|(model, _)| (model, text_bytes(&image_of_model(model)) - empty))
}

#[test]
#[ignore = "needs gcc-arm-none-eabi and the target thumbv7em-none-eabihf; tests/run runs it"]
fn an_image_contains_only_the_model_that_it_names() {
    for (model, own) in MODELS {
        let symbols = image_of_model(model).binutils("nm", &[]);
        assert!(symbols.contains(own), "{model}: own symbols\n{symbols}");
        let models = symbols.lines().filter_map(|line| line.split_whitespace().nth(2));
        let models: Vec<&str> =
            models.filter(|name| name.starts_with("ballrace_") && name.ends_with("_model")).collect();
        assert_eq!(models, [format!("ballrace_{model}_model")], "constants of models");
        // The compiler merges functions with the same code: the element loads of both lumped models.
        let own_code: Vec<&str> = symbols.lines().filter(|line| !line.contains("element_loads")).collect();
        for (other, symbol) in MODELS.into_iter().filter(|(other, _)| *other != model) {
            assert!(!own_code.iter().any(|line| line.contains(symbol)), "{model} contains {other}\n{symbols}");
        }
        assert!(!symbols.contains("libm"), "{model} contains functions of set-up");
    }
}

/// Another static library of Rust with a panic handler of its own, optimised at link time and not.
#[test]
#[ignore = "needs qemu-system-arm, gcc-arm-none-eabi and the target thumbv7em-none-eabihf; tests/run runs it"]
fn two_static_libraries_of_rust_do_not_collide() {
    let source = "#include \"board.h\"\n#include \"subjects.h\"\nuint32_t other_library_entry(uint32_t);\n\
                  void run(void)\n{\n    float wrench[5];\n    const float displacement[5] = { 1e-5f };\n    \
                  uint32_t status = subjects_init() | ballrace_force(subjects[3].bearing, displacement, 0, wrench);\n    \
                  print_number(status + other_library_entry(2));\n}\n";
    let own = library(Abi::Hard.target());
    for lto in ["fat", "off"] {
        let other = other_library(lto);
        for libraries in [[own.clone(), other.clone()], [other.clone(), own.clone()]] {
            let image = Image::new(Abi::Hard).sources(&["subjects.c"]).text("two_libraries.c", source);
            let image = image.libraries(&libraries).link("two_libraries");
            assert_eq!(image.run(), "4", "optimised at link time: {lto}");
        }
    }
}

fn other_library(lto: &str) -> std::path::PathBuf {
    let folder = super::super::root().join("target/c/other-library").join(lto);
    let built = super::super::cargo()
        .args(["build", "--release", "--quiet", "-p", "other_library", "--target", Abi::Hard.target(), "--target-dir"])
        .arg(&folder)
        .env("CARGO_PROFILE_RELEASE_LTO", lto)
        .status();
    assert!(built.expect("cargo runs").success(), "the other library builds");
    folder.join(Abi::Hard.target()).join("release/libother_library.a")
}
