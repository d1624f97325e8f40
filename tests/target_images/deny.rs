//! Instructions that give other bits on another machine are in no image: neither fused nor estimated.

use std::process::Command;

/// Mnemonics of fused multiply-adds and of estimates.
const ARM: [&str; 6] = ["vfma", "vfms", "vfnma", "vfnms", "vrecp", "vrsqrt"];
const X86: [&str; 6] = ["vfmadd", "vfmsub", "vfnmadd", "vfnmsub", "rsqrt", "rcpps"];

/// Those of `forbidden` that stand in the code of `image`, outside libm's own `fma`: that one is correctly rounded with the
/// machine's instruction and without it.
fn found(objdump: &str, image: &std::path::Path, forbidden: &[&'static str]) -> Vec<&'static str> {
    let output = Command::new(objdump).args(["-d", "--no-show-raw-insn"]).arg(image).output();
    let output = output.unwrap_or_else(|error| panic!("missing: {objdump} ({error})"));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.lines().count() > 100, "a disassembly of {}", image.display());
    let functions =
        text.split("\n\n").filter(|function| !function.lines().next().is_some_and(|name| name.contains("libm")));
    let mnemonics: Vec<&str> =
        functions.flat_map(str::lines).filter_map(|line| line.split('\t').nth(1)).map(str::trim).collect();
    let has =
        |name: &&str| mnemonics.iter().any(|m| m.trim_start_matches('v').starts_with(name.trim_start_matches('v')));
    forbidden.iter().copied().filter(has).collect()
}

#[test]
#[ignore = "needs gcc-arm-none-eabi and the target thumbv7em-none-eabihf; tests/run runs it"]
fn no_fused_and_no_estimated_operations() {
    let none: Vec<&str> = Vec::new();
    for image in ["firmware", "counts", "smallest"] {
        assert_eq!(found("arm-none-eabi-objdump", &super::images().join(image), &ARM), none, "{image}");
    }
    assert_eq!(found("objdump", &super::bits::with_avx2(), &X86), none, "with AVX2 and FMA allowed");
}

/// The C reference is compiled with contraction allowed, and the check detects its fused operations.
#[test]
#[ignore = "needs gcc-arm-none-eabi; tests/run runs it"]
fn the_check_detects_a_fused_operation() {
    let folder = tempfile::tempdir().expect("a folder");
    let image = super::counts::yardstick::compiled_into(folder.path());
    assert_eq!(found("arm-none-eabi-objdump", &image, &ARM)[..1], ["vfma"]);
}
