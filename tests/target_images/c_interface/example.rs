//! The CMake project: the example for a bare Cortex-M4 runs, and the Zephyr module selects the library of the processor.

use std::process::Command;

fn has_cmake() -> bool {
    let found = Command::new("cmake").arg("--version").output().is_ok_and(|output| output.status.success());
    if !found {
        println!("omitted: no CMake here; type: sudo apt-get install -y --no-install-recommends cmake make");
    }
    found
}

/// Runs a command in a folder and returns what it prints.
fn run(folder: &std::path::Path, command: &mut Command) -> String {
    let output = command.current_dir(folder).output();
    let output = output.expect("the command starts");
    let text = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {text}");
    text.into_owned()
}

/// The example is built by the commands of the README, with warnings as errors.
#[test]
#[ignore = "needs cmake, qemu-system-arm, gcc-arm-none-eabi and the target thumbv7em-none-eabihf; tests/run runs it"]
fn the_example_on_bare_metal_runs() {
    if !has_cmake() {
        return;
    }
    let folder = super::folder();
    let documented = "cmake --preset thumbv7em-hard && cmake --build --preset thumbv7em-hard";
    let readme = std::fs::read_to_string(folder.join("README.md")).expect("the README");
    assert!(readme.contains(documented), "the README has the commands of this test");
    let warnings_are_errors = "-D CMAKE_COMPILE_WARNING_AS_ERROR=ON";
    let commands = documented.replacen("thumbv7em-hard", &format!("thumbv7em-hard {warnings_are_errors}"), 1);
    run(&folder, Command::new("sh").args(["-c", &commands]));
    let image = super::super::root().join("target/cmake/thumbv7em-hard/examples/bare_metal/bare_metal");
    // The emulator fails unless the example found the expected statistics.
    super::super::emulated(&image, super::super::COUNTING);
}

/// A project that includes the module as Zephyr does, with the functions of Zephyr that the module calls.
const ZEPHYR: &str = "cmake_minimum_required(VERSION 3.21)
project(application LANGUAGES NONE)
function(zephyr_include_directories)
endfunction()
function(zephyr_link_libraries library)
  get_target_property(file ${library} IMPORTED_LOCATION)
  message(STATUS \"linked: ${file}\")
endfunction()
set(CONFIG_BALLRACE y)
include(\"${MODULE}/CMakeLists.txt\")
";

#[test]
#[ignore = "needs cmake; tests/run runs it"]
fn the_zephyr_module_selects_the_library_of_the_processor() {
    if !has_cmake() {
        return;
    }
    let module = super::folder().join("zephyr");
    for (configuration, target) in [
        (&["CPU_CORTEX_M0PLUS"][..], "thumbv6m-none-eabi"),
        (&["CPU_CORTEX_M3"], "thumbv7m-none-eabi"),
        (&["CPU_CORTEX_M4"], "thumbv7em-none-eabi"),
        (&["CPU_CORTEX_M4", "FP_HARDABI"], "thumbv7em-none-eabihf"),
        (&["CPU_CORTEX_M7", "FP_HARDABI"], "thumbv7em-none-eabihf"),
        (&["CPU_CORTEX_M33", "FP_HARDABI"], "thumbv8m.main-none-eabihf"),
        (&["RISCV", "FP_HARDABI"], "riscv32imac-unknown-none-elf"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("CMakeLists.txt"), ZEPHYR).expect("a file");
        let values = configuration.iter().map(|name| format!("-DCONFIG_{name}=y"));
        let text = run(
            folder.path(),
            Command::new("cmake").arg(format!("-DMODULE={}", module.display())).args(values).args(["-B", "build", "."]),
        );
        let file = format!("/{target}/c-library/libballrace_c.a");
        assert!(text.lines().any(|line| line.contains("linked: ") && line.ends_with(&file)), "{target}: {text}");
    }
}

/// A cross build that does not name the target of Rust would link a library of the host.
#[test]
#[ignore = "needs cmake; tests/run runs it"]
fn a_cross_build_without_a_target_is_refused() {
    if !has_cmake() {
        return;
    }
    let kernel = super::folder();
    let source = format!("add_subdirectory(\"{}\" ballrace)", kernel.display());
    let packed = format!("find_package(ballrace REQUIRED PATHS \"{}/cmake\" NO_DEFAULT_PATH)", kernel.display());
    for (lines, key) in [(source, "BALLRACE_RUST_TARGET: empty"), (packed, "BALLRACE_TARGET: empty")] {
        let folder = tempfile::tempdir().expect("a folder");
        let text = format!("cmake_minimum_required(VERSION 3.21)\nproject(firmware LANGUAGES NONE)\n{lines}\n");
        std::fs::write(folder.path().join("CMakeLists.txt"), text).expect("a file");
        let mut command = Command::new("cmake");
        command.args(["-DCMAKE_SYSTEM_NAME=Generic", "-DCMAKE_SYSTEM_PROCESSOR=arm", "-B", "build", "."]);
        let output = command.current_dir(folder.path()).output().expect("cmake");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !output.status.success() && said.contains(key) && said.contains("in a cross build for Generic"),
            "{said}"
        );
    }
}
