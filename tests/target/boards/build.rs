//! Memory and start-up of the board that the target's image runs on; that of the Cortex-M4F is in `.cargo/config.toml`.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(board_an505)");
    // Not optimised, the image is too large for the micro:bit, whose emulator has no timer to count by either.
    let is = |variable: &str, value: &str| std::env::var(variable).is_ok_and(|found| found == value);
    let smallest = if is("PROFILE", "release") && !is("CARGO_PKG_NAME", "counts") { "microbit" } else { "an386" };
    let (board, scripts): (_, &[&str]) = match std::env::var("TARGET").unwrap_or_default().as_str() {
        "thumbv7em-none-eabi" => ("an386", &["link.x"]),
        "thumbv6m-none-eabi" => (smallest, &["link.x"]),
        "thumbv8m.main-none-eabihf" => ("an505", &["link.x"]),
        "riscv32imac-unknown-none-elf" | "riscv32imafc-unknown-none-elf" => ("virt", &["memory.x", "link.x"]),
        _ => return,
    };
    if board == "an505" {
        println!("cargo:rustc-cfg=board_an505");
    }
    let folder = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo:rustc-link-search={folder}/../boards/{board}");
    for script in scripts {
        println!("cargo:rustc-link-arg=-T{script}");
    }
}
