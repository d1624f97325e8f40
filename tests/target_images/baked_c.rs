//! Constants of `ballrace bake --language c`, as `tests/target/c` has them: compiled for the target, with the checksums of the
//! certificate. `tests/command_line/bake_c.rs` compares their forces on the desktop.

use super::c_interface::image::{Abi, Image};

/// The image of the constants, with and without FPU, computes the checksums of the certificate.
#[test]
#[ignore = "needs qemu-system-arm, gcc-arm-none-eabi and two targets; tests/run runs it"]
fn the_target_computes_the_checksums_of_c() {
    let read =
        |name: &str| std::fs::read_to_string(super::root().join("tests/target/c").join(name)).expect("baked constants");
    let (header, constants) = (read("every_model.h"), read("every_model.c"));
    let names: Vec<&str> = header
        .lines()
        .filter_map(|line| line.strip_prefix("#define BEARING_")?.split_once("_CHECKSUM"))
        .map(|(name, _)| name)
        .collect();
    assert_eq!(names.len(), 7, "{names:?}");
    let equal: Vec<String> = names
        .iter()
        .map(|name| format!("(bearing_{}_checksum() == BEARING_{name}_CHECKSUM)", name.to_lowercase()))
        .collect();
    let source = constants.replace("#include \"every_model.h\"\n", &header)
        + "\n#include \"board.h\"\nvoid run(void)\n{\n    print_number((uint32_t)("
        + &equal.join("\n        + ")
        + "));\n}\n";
    for abi in [Abi::Hard, Abi::Soft] {
        let image = Image::new(abi).text("every_model.c", &source).link("baked");
        assert_eq!(image.run(), names.len().to_string(), "{abi:?}: number of equal checksums");
    }
}

/// The bearings of a blob in flash, used in place: the checksums that `every_model.h` states too; another model and another name are
/// refused.
#[test]
#[ignore = "needs qemu-system-arm, gcc-arm-none-eabi and two targets; tests/run runs it"]
fn the_target_takes_the_bearings_of_a_blob() {
    let header = std::fs::read_to_string(super::root().join("tests/target/c/every_model.h")).expect("baked constants");
    let stated = |name: &str| {
        let define = format!("#define BEARING_{}_CHECKSUM UINT64_C(0x", name.to_uppercase());
        let line = header.lines().find_map(|line| line.strip_prefix(&define)).expect("a checksum");
        line.trim_end_matches(')').to_owned()
    };
    let mut expected = "0;in parts\n".to_owned();
    for name in ["radial", "mixed", "lines", "angular", "springs", "friction", "balls"] {
        let stated = stated(name);
        expected += &format!("{name};0;{stated};{stated}\n");
    }
    let zero = "0".repeat(16);
    expected += &format!("balls;16384;{zero};{zero}\nball;8192;{zero};{zero}\n");
    for abi in [Abi::Hard, Abi::Soft] {
        assert_eq!(Image::new(abi).sources(&["blob.c"]).link("blob").run(), expected, "{abi:?}");
    }
}
