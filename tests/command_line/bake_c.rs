//! Constants of `ballrace bake --language c`, compiled by gcc: checksums of the certificate and forces of `ballrace force`. The tests
//! of the target compile the same constants from `tests/target/c`, where a test of `bake.rs` keeps them.

use crate::bake::EVERY_MODEL_OF_C;
use crate::documents::root;
use crate::support::program;
use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Output};

/// Flags of a strict compiler.
const STRICT: [&str; 5] = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"];
/// The target's core.
const CORE: [&str; 4] = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"];

const NAMES: [&str; 7] = ["radial", "mixed", "lines", "angular", "springs", "friction", "balls"];
const DISPLACEMENTS: [[f32; 5]; 3] =
    [[1e-6, 2e-6, 1e-5, 0.0, 0.0], [-3e-6, 4e-6, -8e-6, 1e-4, -5e-5], [2e-5, 0.0, -1e-5, 0.0, 2e-4]];
const SPEED: f32 = 314.0;

/// Runs `ballrace`.
fn ballrace(folder: &Path, args: &[&str]) -> String {
    text(&Command::new(program()).args(args).current_dir(folder).output().unwrap())
}

/// Returns the output of a command that has to succeed.
fn text(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Builds the library for this machine and returns its path.
fn library() -> String {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "-q", "--locked", "--release", "-p", "ballrace-c"]).current_dir(root());
    text(&cargo.output().unwrap());
    root().join("target/release/libballrace_c.a").to_str().unwrap().to_owned()
}

/// Runs a compiler with strict flags.
fn compiled(folder: &Path, compiler: &str, args: &[&str]) {
    let mut command = Command::new(compiler);
    command.args(STRICT).arg("-I").arg(root().join("kernel/c/include")).args(args).current_dir(folder);
    text(&command.output().unwrap_or_else(|error| panic!("{compiler}: {error}")));
}

/// A program that prints checksums, and forces as bits.
fn source() -> String {
    let mut main = "#include \"bearings.h\"\n#include <inttypes.h>\n#include <stdio.h>\n#include <string.h>\n\
        static void row(const ballrace_bearing *bearing, const float *u)\n{\n    ballrace_kinematic_state at = { 0 };\n    \
        float wrench[5];\n    int i;\n"
        .to_owned();
    write!(main, "    at.inner_speed = {SPEED:?}f;\n    ballrace_force_at(bearing, u, &at, wrench);\n").unwrap();
    main += "    for (i = 0; i < 5; i++) {\n        uint32_t bits;\n        memcpy(&bits, &wrench[i], sizeof bits);\n        \
        printf(\"0x%08\" PRIx32 \"%s\", bits, i < 4 ? \",\" : \"\\n\");\n    }\n}\n\nint main(void)\n{\n";
    for u in DISPLACEMENTS {
        let numbers = u.map(|x| format!("{x:?}f")).join(", ");
        write!(main, "    {{\n        static const float u[5] = {{ {numbers} }};\n").unwrap();
        for name in NAMES {
            writeln!(main, "        row(&bearing_{name}.head, u);").unwrap();
        }
        main += "    }\n";
    }
    for name in NAMES {
        let upper = name.to_uppercase();
        writeln!(
            main,
            "    printf(\"%016\" PRIx64 \" %d\\n\", bearing_{name}_checksum(), bearing_{name}_checksum() == BEARING_{upper}_CHECKSUM);"
        )
        .unwrap();
    }
    main + "    return 0;\n}\n"
}

/// Rows of `ballrace force` for one bearing.
fn forces(folder: &Path, name: &str) -> Vec<String> {
    let args = ["force", "scene.toml", "--displacements", "u.csv", "--precision", "f32", "--bits", "--format", "csv"];
    // Constants of the quasi-static model are its table.
    let model: &[&str] = if name == "balls" { &["--model", "tabulated"] } else { &[] };
    let printed = ballrace(folder, &[&args[..], &["--bearing", name], model].concat());
    printed.lines().skip(1).map(|line| line.rsplit_once(',').unwrap().0.to_owned()).collect()
}

/// Bits of zero have no sign here: a force of no element is 0 or -0.
fn unsigned(bits: &str) -> String {
    bits.replace("0x80000000", "0x00000000")
}

#[test]
#[ignore = "needs gcc and gcc-arm-none-eabi; tests/run runs it"]
fn the_constants_of_c_give_the_checksums_and_the_forces() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let put = |name: &str, text: &str| std::fs::write(at.join(name), text).unwrap();
    put("scene.toml", EVERY_MODEL_OF_C);
    let rows: String =
        DISPLACEMENTS.iter().map(|u| format!("{},{SPEED:?}\n", u.map(|x| format!("{x:?}")).join(","))).collect();
    put("u.csv", &format!("u,v,w,thu,thv,inner_speed\n{rows}"));
    put("main.c", &source());
    ballrace(at, &["bake", "scene.toml", "--language", "c", "-o", "bearings.h"]);
    assert!(ballrace(at, &["verify", "bearings.h"]).contains("equal to its scene"));
    assert!(ballrace(at, &["verify", "bearings.c"]).contains("equal to its scene"));

    let compile = |compiler: &str, flags: &[&str], inputs: &[&str], output: &str| {
        compiled(at, compiler, &[flags, inputs, &["-o", output]].concat());
    };
    for optimisation in ["-O0", "-O2", "-Os"] {
        compile("arm-none-eabi-gcc", &[&CORE[..], &[optimisation, "-c"]].concat(), &["bearings.c"], "bearings.o");
    }
    compile("gcc", &["-O2"], &["main.c", "bearings.c", &library(), "-lm", "-lpthread", "-ldl"], "main");

    let printed = text(&Command::new(at.join("main")).output().unwrap());
    let (found, checksums): (Vec<&str>, Vec<&str>) = printed.lines().partition(|line| line.starts_with("0x"));
    assert_eq!(checksums.len(), NAMES.len());
    for (name, line) in NAMES.iter().zip(checksums) {
        assert!(line.ends_with(" 1"), "{name}: checksum {line} is not that of the certificate");
    }
    for (i, name) in NAMES.iter().enumerate() {
        // Radial and axial elements of different laws are powers in C.
        if *name == "mixed" {
            continue;
        }
        for (j, expected) in forces(at, name).iter().enumerate() {
            assert_eq!(unsigned(found[NAMES.len() * j + i]), unsigned(expected), "{name}, displacement {j}");
        }
    }
}

/// Calls the functions of the firmware guide with a displacement of the shaft, and with none.
const GUIDE_MAIN: &str = "int main(void)
{
    struct drive_end end;
    float wrench[5];
    uint32_t status;
    if (!set_up(&end)) {
        return 1;
    }
    status = sample(&end, 100, 8e-6f, 0.0f, 314.0f, wrench);
    return bits_of(wrench[0]) >> 31 == 1 && status == BALLRACE_OK ? 0 : 2;
}
";

#[test]
#[ignore = "needs gcc and gcc-arm-none-eabi; tests/run runs it"]
fn the_functions_of_the_firmware_guide_compile_and_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = root().join("tests/recordings/healthy.toml");
    let scene = scene.to_str().unwrap();
    ballrace(at, &["bake", scene, "--language", "c", "-o", "bearings.h"]);
    let guide = std::fs::read_to_string(root().join("docs/src/firmware.md")).unwrap();
    let blocks: Vec<&str> =
        guide.split("```c\n").skip(1).map(|rest| rest.split("```").next().unwrap_or_default()).collect();
    assert!(blocks.len() >= 2, "{} blocks of C", blocks.len());
    std::fs::write(at.join("main.c"), blocks.concat() + GUIDE_MAIN).unwrap();
    compiled(at, "arm-none-eabi-gcc", &[&CORE[..], &["-O2", "-c", "main.c", "-o", "main.o"]].concat());
    compiled(at, "gcc", &["main.c", "bearings.c", &library(), "-lm", "-lpthread", "-ldl", "-o", "main"]);
    text(&Command::new(at.join("main")).output().unwrap());
}
