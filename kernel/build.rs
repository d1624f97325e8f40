//! Sets a cfg where the target has a square root in hardware: stable Rust shows no cfg for the FPU.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(vsqrt)");
    println!("cargo:rustc-check-cfg=cfg(fsqrt)");
    let target = std::env::var("TARGET").unwrap_or_default();
    // Cortex-M4F, M7F and M33F and up: single precision at least.
    if matches!(target.as_str(), "thumbv7em-none-eabihf" | "thumbv8m.main-none-eabihf") {
        println!("cargo:rustc-cfg=vsqrt");
    }
    // RISC-V with a single-precision FPU.
    if target == "riscv32imafc-unknown-none-elf" {
        println!("cargo:rustc-cfg=fsqrt");
    }
}
