//! The smallest useful image: how much of the flash is the kernel, and what the feature `defmt` adds.

use std::path::Path;
use std::process::Command;

/// Bytes of code and constants.
fn text_bytes(image: &Path) -> usize {
    let table = binutils("size", image);
    let line = table.lines().nth(1).expect("a line of sizes");
    line.split_whitespace().next().and_then(|text| text.parse().ok()).expect("a number")
}

fn binutils(tool: &str, image: &Path) -> String {
    let output = Command::new(format!("arm-none-eabi-{tool}")).arg(image).output();
    let output = output.expect("missing: binutils; type: apt-get install -y --no-install-recommends gcc-arm-none-eabi");
    assert!(output.status.success(), "{tool} reads {}", image.display());
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn kernel_bytes(images: &Path) -> usize {
    text_bytes(&images.join("smallest")) - text_bytes(&images.join("empty"))
}

#[test]
#[ignore = "needs gcc-arm-none-eabi and the target thumbv7em-none-eabihf; tests/run runs it"]
fn eight_radial_elements_take_less_than_2_kib_of_flash() {
    let bytes = kernel_bytes(&super::images());
    println!("kernel code of the smallest image: {bytes} bytes");
    assert!((100..2048).contains(&bytes), "{bytes} bytes");
}

#[test]
#[ignore = "needs gcc-arm-none-eabi and the target thumbv7em-none-eabihf; tests/run runs it"]
fn defmt_costs_nothing_when_off_or_unused() {
    let (without, with) = (&super::images(), &super::images_with_defmt());
    assert_eq!(kernel_bytes(without), kernel_bytes(with), "unused, it adds nothing to the kernel");
    let names_defmt = |folder: &Path, image| binutils("nm", &folder.join(image)).contains("defmt");
    assert!(!names_defmt(without, "smallest") && !names_defmt(without, "firmware"), "off, nothing of it is there");
    assert!(names_defmt(with, "firmware"), "the check would see it");
}
