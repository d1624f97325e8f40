//! Sets a cfg where the target has a square root in hardware, and where it has no product of 64 bits: stable Rust shows no cfg for them.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(vsqrt)");
    println!("cargo:rustc-check-cfg=cfg(fsqrt)");
    println!("cargo:rustc-check-cfg=cfg(short_products)");
    let target = std::env::var("TARGET").unwrap_or_default();
    // Cortex-M4F, M7F and M33F and up: single precision at least.
    if matches!(target.as_str(), "thumbv7em-none-eabihf" | "thumbv8m.main-none-eabihf") {
        println!("cargo:rustc-cfg=vsqrt");
    }
    // Cortex-M0, M0+ and M1, Cortex-M23: a product of 64 bits is a call.
    if matches!(target.as_str(), "thumbv6m-none-eabi" | "thumbv8m.base-none-eabi") {
        println!("cargo:rustc-cfg=short_products");
    }
    // RISC-V with a single-precision FPU.
    if target == "riscv32imafc-unknown-none-elf" {
        println!("cargo:rustc-cfg=fsqrt");
    }
}
