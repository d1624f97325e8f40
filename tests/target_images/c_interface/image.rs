//! Images of C for the emulated Cortex-M4F, linked with the library.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Float ABI of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Abi {
    /// Floats in registers of the FPU.
    Hard,
    /// Floats in core registers; the FPU is not used.
    Soft,
}

const COMPILER: &str = "arm-none-eabi-gcc";
const MISSING: &str = "missing: the cross compiler; type: apt-get install -y --no-install-recommends gcc-arm-none-eabi";

impl Abi {
    /// Target of Rust.
    pub fn target(self) -> &'static str {
        match self {
            Self::Hard => "thumbv7em-none-eabihf",
            Self::Soft => "thumbv7em-none-eabi",
        }
    }

    /// Arguments of the C compiler.
    pub fn arguments(self) -> &'static [&'static str] {
        match self {
            Self::Hard => &["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
            Self::Soft => &["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=soft"],
        }
    }
}

/// Returns the static library for a target, with the panic handler that does not link where a panic can be reached. It is built for
/// both targets at once, each in a folder of its own.
pub fn library(target: &str) -> PathBuf {
    static BUILT: OnceLock<()> = OnceLock::new();
    BUILT.get_or_init(|| {
        std::thread::scope(|scope| drop([Abi::Hard, Abi::Soft].map(|abi| scope.spawn(move || build(abi.target())))));
    });
    folder(target).join(target).join("c-library/libballrace_c.a")
}

fn folder(target: &str) -> PathBuf {
    super::super::root().join("target/c").join(target)
}

fn build(target: &str) {
    let built = Command::new(env!("CARGO"))
        .args(["rustc", "--locked", "--quiet", "-p", "ballrace-c", "--profile", "c-library"])
        .args(["--no-default-features", "--features", "panic-never", "--target", target, "--crate-type", "staticlib"])
        .arg("--target-dir")
        .arg(folder(target))
        // Names of symbols contain the types of generic functions.
        .args(["--", "-C", "symbol-mangling-version=v0"])
        .current_dir(super::super::root())
        .env_remove("RUSTFLAGS")
        .status();
    assert!(
        built.expect("cargo runs").success(),
        "the library builds; missing target? type: rustup target add {target}"
    );
}

/// An image to be linked.
pub struct Image {
    abi: Abi,
    sources: Vec<String>,
    libraries: Vec<PathBuf>,
    folder: tempfile::TempDir,
}

/// A linked image.
pub struct Linked {
    /// Path of the image.
    pub path: PathBuf,
    _folder: tempfile::TempDir,
}

impl Image {
    /// Creates an image without sources, linked with the library.
    pub fn new(abi: Abi) -> Self {
        let libraries = vec![library(abi.target())];
        Self { abi, sources: vec!["board.c".to_owned()], libraries, folder: tempfile::tempdir().expect("a folder") }
    }

    /// Adds sources of `tests/target/c`.
    pub fn sources(mut self, names: &[&str]) -> Self {
        self.sources.extend(names.iter().map(|name| (*name).to_owned()));
        self
    }

    /// Adds a source with this text.
    pub fn text(mut self, name: &str, text: &str) -> Self {
        let path = self.folder.path().join(name);
        std::fs::write(&path, text).expect("a source is written");
        self.sources.push(path.to_str().expect("a path in UTF-8").to_owned());
        self
    }

    /// Links these libraries instead.
    pub fn libraries(mut self, libraries: &[PathBuf]) -> Self {
        self.libraries = libraries.to_vec();
        self
    }

    /// Links the image; what the linker wrote where it failed.
    pub fn try_link(self, name: &str) -> Result<Linked, String> {
        std::fs::write(self.folder.path().join("tables.h"), super::tables::header()).expect("the tables are written");
        let path = self.folder.path().join(name);
        let output = Command::new(COMPILER)
            .args(["-O2", "-std=c11", "-Wall", "-Wextra", "-Werror"])
            .args(self.abi.arguments())
            .args(["-nostdlib", "-ffreestanding", "-ffunction-sections", "-fdata-sections", "-z", "noexecstack"])
            .args(["-Wl,--gc-sections", "-T", "link.ld", "-I"])
            .arg(super::folder().join("include"))
            .arg("-I")
            .arg(self.folder.path())
            .args(["-I", "."])
            .args(&self.sources)
            .arg("-o")
            .arg(&path)
            .args(&self.libraries)
            .current_dir(super::super::root().join("tests/target/c"))
            .output()
            .expect(MISSING);
        if output.status.success() {
            Ok(Linked { path, _folder: self.folder })
        } else {
            Err(String::from_utf8_lossy(&output.stderr).into_owned())
        }
    }

    /// Links the image.
    pub fn link(self, name: &str) -> Linked {
        self.try_link(name).unwrap_or_else(|message| panic!("{name} does not link\n{message}"))
    }
}

impl Linked {
    /// Runs the image under instruction counting and returns its output.
    pub fn run(&self) -> String {
        super::super::emulated(&self.path, super::super::COUNTING)
    }

    /// Output of a tool of binutils.
    pub fn binutils(&self, tool: &str, arguments: &[&str]) -> String {
        binutils(tool, arguments, &self.path)
    }
}

/// Output of a tool of binutils for a file.
pub fn binutils(tool: &str, arguments: &[&str], file: &Path) -> String {
    let output = Command::new(format!("arm-none-eabi-{tool}")).args(arguments).arg(file).output().expect(MISSING);
    assert!(output.status.success(), "{tool} reads {}", file.display());
    String::from_utf8_lossy(&output.stdout).into_owned()
}
