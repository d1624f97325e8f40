//! Files from which a unit is built: the scene with its matrices, and what of it the unit contains.

use super::Content;
use ballrace_base::sha256;
use ballrace_plant::error::{Result, UnitError};
use ballrace_scene::edit::with_values;
use ballrace_scene::read::{load, read_str};
use ballrace_scene::{Scene, System};
use std::env::consts::{ARCH, OS};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, value};

/// Name of the scene.
const SCENE: &str = "scene.toml";
/// Name of the content.
const CONTENT: &str = "unit.toml";
/// Version of this library: with another one the same scene may give other bits.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Files of a unit.
pub struct Resources {
    /// Name and content of each.
    pub files: Vec<(String, Vec<u8>)>,
    /// SHA-256 of the files and of the version of this library.
    pub token: String,
}

impl Resources {
    /// Collects the files of a scene with this text.
    ///
    /// # Errors
    /// A matrix that cannot be read.
    pub fn of(scene: &Scene, text: &str, content: &Content) -> Result<Self> {
        let (mut renamed, mut matrices) = (vec![], vec![]);
        for (key, path) in scene.system.iter().flat_map(matrix_files) {
            let name = path.extension().map_or(key.to_owned(), |extension| format!("{key}.{}", extension.display()));
            let bytes = fs::read(path).map_err(|source| UnitError::Read { file: path.clone(), source })?;
            renamed.push((format!("system.{key}"), name.clone()));
            matrices.push((name, bytes));
        }
        let renamed: Vec<_> = renamed.iter().map(|(key, name)| (key.as_str(), name.as_str())).collect();
        let text = with_values(text.strip_prefix('\u{feff}').unwrap_or(text), &renamed).map_err(io::Error::other)?;
        let mut files = vec![(SCENE.to_owned(), text.into_bytes()), (CONTENT.to_owned(), write(content).into_bytes())];
        files.append(&mut matrices);
        let token = token(files.iter().map(|(_, bytes)| bytes.as_slice()))?;
        Ok(Self { files, token })
    }
}

/// Reads the resources of a unit.
///
/// # Errors
/// A file that cannot be read or is invalid, another `token` than that of the files and this version.
pub(super) fn open(folder: &Path, token: &str) -> Result<(Scene, Content)> {
    let (path, content_path) = (folder.join(SCENE), folder.join(CONTENT));
    let (text, content) = (load(&path)?, load(&content_path)?);
    let scene = read_str(&text, &path)?;
    let matrices = scene
        .system
        .iter()
        .flat_map(matrix_files)
        .map(|(_, file)| fs::read(file).map_err(|source| UnitError::Read { file: file.clone(), source }));
    let matrices = matrices.collect::<Result<Vec<_>, _>>()?;
    let texts = [text.as_bytes(), content.as_bytes()];
    let expected = self::token(texts.into_iter().chain(matrices.iter().map(Vec::as_slice)))?;
    if token != expected {
        return Err(UnitError::Token { found: token.to_owned(), expected, version: VERSION }.into());
    }
    let content = read(&content).ok_or(UnitError::Content { file: content_path })?;
    Ok((scene, content))
}

/// Returns the keys of `[system]` that name files, with the files.
fn matrix_files(system: &System) -> impl Iterator<Item = (&'static str, &PathBuf)> {
    let System { mass, damping, gyroscopic, stiffness, load, .. } = system;
    let given = [("mass", Some(mass)), ("damping", damping.as_ref()), ("gyroscopic", gyroscopic.as_ref())];
    let more = [("stiffness", Some(stiffness)), ("load", load.as_ref())];
    given.into_iter().chain(more).filter_map(|(key, file)| Some((key, file?)))
}

fn token<'a>(files: impl Iterator<Item = &'a [u8]>) -> io::Result<String> {
    let mut all = VERSION.as_bytes().to_vec();
    for file in files {
        all.extend((file.len() as u64).to_le_bytes());
        all.extend(file);
    }
    Ok(sha256::of(all.as_slice())?.0)
}

fn write(content: &Content) -> String {
    let mut document = DocumentMut::new();
    match content {
        Content::Rotor { rate } => document["rate"] = value(*rate),
        Content::Bearing { name } => document["bearing"] = value(name),
    }
    document.to_string()
}

fn read(text: &str) -> Option<Content> {
    let document: DocumentMut = text.parse().ok()?;
    if let Some(name) = document.get("bearing") {
        return Some(Content::Bearing { name: name.as_str()?.to_owned() });
    }
    let rate = document.get("rate")?.as_float().filter(|rate| *rate > 0.0 && rate.is_finite())?;
    Some(Content::Rotor { rate })
}

/// Returns the name of this system's folder of binaries in a unit, such as `x86_64-linux`.
#[must_use]
pub fn platform() -> String {
    let system = if OS == "macos" { "darwin" } else { OS };
    format!("{ARCH}-{system}")
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn a_content_is_read_as_it_was_written() {
        for content in [Content::Rotor { rate: 1.0 / 3.0 }, Content::Bearing { name: "a \"b\"\n".to_owned() }] {
            assert_eq!(read(&write(&content)).unwrap(), content);
        }
        for invalid in ["", "rate = 0.0", "rate = -1.0", "rate = nan", "rate = \"1 Hz\"", "bearing = 3", "?"] {
            assert_eq!(read(invalid), None, "{invalid}");
        }
    }
}
