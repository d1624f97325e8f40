//! Check of baked constants: the scene in the file is baked again and compared, field by field and constant by constant.

use super::certificate::{
    self, ALL_BEARINGS, BEARINGS_FIELD, CORE_FIELD, Field, LANGUAGE_FIELD, ONE_BEARING, POSES_FIELD, PROGRAM,
    PROGRAM_FIELD, SCENE_FILE_FIELD,
};
use super::{BakeOptions, BakedFile, Core, Language, PoseSource, bake, blob, embedded};
use ballrace_base::bounded::open_regular;
use ballrace_base::sha256;
use ballrace_plant::error::{Error, Result, VerifyError};
use ballrace_scene::read::{load, read_str};
use serde::Serialize;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest size of a baked file, bytes.
const MAX_BYTES: u64 = 1 << 28;

/// Differences of a baked file from its scene baked again.
#[derive(Debug, Clone, Serialize)]
pub struct Verification {
    /// Program that the file names.
    pub program: String,
    /// Name of the scene.
    pub scene: String,
    /// SHA-256 of its text.
    pub scene_hash: String,
    /// CRC-32 at the end of the blob, by which a device names what it has; `None` for a source.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crc32: Option<String>,
    /// This program.
    pub this_program: &'static str,
    /// Number of compared fields of the certificate.
    pub fields: usize,
    /// Number of compared constants and functions.
    pub constants: usize,
    /// Checksum of each bearing, as the scene gives it.
    pub checksums: Vec<Checksum>,
    /// Differences; empty if the file matches its scene.
    pub differences: Vec<Difference>,
}

/// Checksum of one bearing.
#[derive(Debug, Clone, Serialize)]
pub struct Checksum {
    /// Name of the bearing.
    pub bearing: String,
    /// Checksum in hexadecimal digits.
    pub checksum: String,
}

/// Part of a baked file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BakedPart {
    /// Field of the certificate.
    Field,
    /// Constant or function.
    Constant,
    /// Comment outside certificate and scene.
    Comment,
}

impl BakedPart {
    /// Returns the name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Field => "field",
            Self::Constant => "constant",
            Self::Comment => "comment",
        }
    }
}

/// One difference.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The file.
    pub file: PathBuf,
    /// Part of the file.
    pub part: BakedPart,
    /// Name of the field or constant.
    pub name: String,
    /// Line number of the first difference, from 1; `None` for an absent constant and for a field.
    pub line: Option<usize>,
    /// Content of the file; `None` if the part is absent.
    pub found: Option<String>,
    /// Content expected from the scene; `None` if the scene has no such part.
    pub expected: Option<String>,
}

/// Bakes the scene of `file` again and returns the differences from the constants in `file`.
///
/// In C, `file` is the header or the source. The paths in its scene are relative to the folder of `file`. With `scene`, that scene is
/// baked in place of the text in the file.
///
/// # Errors
/// Returns an error if the file has no certificate or no scene, or if the scene cannot be read or baked.
pub fn verify(file: &Path, scene: Option<&Path>) -> Result<Verification> {
    let certificate = with_certificate(file);
    if certificate != *file && file.extension().is_some_and(|of| of == blob::EXTENSION) && !certificate.exists() {
        return blob_alone(file, certificate, scene);
    }
    let file = &certificate;
    let source = read(file)?;
    let block = |block: embedded::Block, what| {
        block.read(&source).ok_or_else(|| VerifyError::NoBlock { file: file.clone(), what })
    };
    let found = certificate::parsed(&block(embedded::CERTIFICATE, "certificate")?)
        .ok_or_else(|| VerifyError::NoBlock { file: file.clone(), what: "certificate" })?;
    let (text, path) = match scene {
        Some(path) => (load(path)?, path.to_owned()),
        None => (block(embedded::SCENE, "scene")?, scene_path(file, &found)?),
    };
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let options = BakeOptions { name: &name, ..options(file, &found)? };
    let expected = read_str(&text, &path)
        .map_err(Error::from)
        .and_then(|scene| bake(&scene, &text, &options))
        .map_err(|error| Error::setup(Error::in_file(file)(error)))?;
    let first = expected.files.first().map_or("", BakedFile::text);
    let fields = embedded::CERTIFICATE.read(first).and_then(|text| certificate::parsed(&text)).unwrap_or_default();
    let mut differences = field_differences(file, &found, &fields);
    let (mut constants, mut crc32) = (0, None);
    for baked in &expected.files {
        let path = baked.extension.map_or_else(|| file.clone(), |extension| file.with_extension(extension));
        if baked.extension == Some(blob::EXTENSION) {
            let bytes = read_bytes(&path)?;
            crc32 = blob::stated_crc32(&bytes);
            differences.extend(Difference::of_blobs(&path, &bytes, &baked.content));
            constants += 1;
            continue;
        }
        let text = if path == *file { source.clone() } else { read(&path)? };
        let (old, new) = (Items::of(&text, options.language), Items::of(baked.text(), options.language));
        differences.extend(old.differences(&new, &path));
        constants += new.0.len();
    }
    let [scene, scene_hash] =
        ["scene", "scene SHA-256"].map(|name| value(&fields, name).unwrap_or_default().to_owned());
    Ok(Verification {
        scene,
        scene_hash,
        crc32,
        program: value(&found, PROGRAM_FIELD).unwrap_or_default().to_owned(),
        this_program: PROGRAM,
        fields: fields.len(),
        constants,
        checksums: expected.bearings.iter().map(Checksum::of).collect(),
        differences,
    })
}

/// Compares a blob whose certificate is missing with a scene.
fn blob_alone(file: &Path, certificate: PathBuf, scene: Option<&Path>) -> Result<Verification> {
    let bytes = read_bytes(file)?;
    let Some(path) = scene else {
        let found = blob::described(&bytes);
        return Err(VerifyError::NoCertificate { file: file.to_owned(), certificate, found }.into());
    };
    let names = blob::names(&bytes);
    let bearing = if let [one] = names.as_slice() { Some(one.as_str()) } else { None };
    let text = load(path)?;
    let core = Core::CortexM4f;
    let options = BakeOptions { bearing, language: Language::Blob, core, poses: None, name: "" };
    let expected = read_str(&text, path)
        .map_err(Error::from)
        .and_then(|scene| Ok((bake(&scene, &text, &options)?, scene.name)))
        .map_err(|error| Error::setup(Error::in_file(file)(error)));
    let (expected, scene) = expected?;
    let content = expected.files.last().map_or(&[][..], |baked| &baked.content);
    Ok(Verification {
        program: PROGRAM.to_owned(),
        scene,
        scene_hash: sha256::of(text.as_bytes()).map(|(hash, _)| hash).unwrap_or_default(),
        crc32: blob::stated_crc32(&bytes),
        this_program: PROGRAM,
        fields: 0,
        constants: 1,
        checksums: expected.bearings.iter().map(Checksum::of).collect(),
        differences: Difference::of_blobs(file, &bytes, content).into_iter().collect(),
    })
}

impl Difference {
    /// Returns where two blobs differ first.
    fn of_blobs(file: &Path, found: &[u8], expected: &[u8]) -> Option<Self> {
        let [name, found, expected] = blob::difference(found, expected)?;
        let (file, part) = (file.to_owned(), BakedPart::Constant);
        Some(Self { file, part, name, line: None, found: Some(found), expected: Some(expected) })
    }
}

/// Returns the file with the certificate: in C, the header; of a blob, the text.
fn with_certificate(file: &Path) -> PathBuf {
    match file.extension() {
        Some(extension) if extension == "c" => file.with_extension("h"),
        Some(extension) if extension == blob::EXTENSION => file.with_extension(blob::CERTIFICATE_EXTENSION),
        _ => file.to_owned(),
    }
}

impl Checksum {
    fn of(baked: &super::Baked) -> Self {
        Self { bearing: baked.bearing.clone(), checksum: format!("{:#018x}", baked.certificate.checksum) }
    }
}

fn read_bytes(file: &Path) -> Result<Vec<u8>, VerifyError> {
    let unreadable = |source| VerifyError::Read { file: file.to_owned(), source };
    let mut bytes = Vec::new();
    open_regular(file).and_then(|file| file.take(MAX_BYTES).read_to_end(&mut bytes)).map_err(unreadable)?;
    Ok(bytes)
}

fn read(file: &Path) -> Result<String, VerifyError> {
    String::from_utf8(read_bytes(file)?)
        .map_err(|_| VerifyError::NoBlock { file: file.to_owned(), what: "certificate" })
}

fn value<'a>(fields: &'a [Field], name: &str) -> Option<&'a str> {
    fields.iter().find(|field| field.name == name).map(|field| field.value.as_str())
}

/// Returns the value of a required field.
fn required<'a>(file: &Path, fields: &'a [Field], name: &'static str) -> Result<&'a str, VerifyError> {
    value(fields, name).ok_or_else(|| VerifyError::NoField { file: file.to_owned(), name })
}

/// Returns the path of the scene: beside the file, whether or not it exists.
fn scene_path(file: &Path, fields: &[Field]) -> Result<PathBuf, VerifyError> {
    Ok(file.with_file_name(required(file, fields, SCENE_FILE_FIELD)?))
}

/// Returns the options by which the file was baked.
fn options<'a>(file: &Path, fields: &'a [Field]) -> Result<BakeOptions<'a>, VerifyError> {
    let bearing = match required(file, fields, BEARINGS_FIELD)? {
        ALL_BEARINGS => None,
        other => Some(other.strip_prefix(ONE_BEARING).ok_or_else(|| VerifyError::Field {
            file: file.to_owned(),
            name: BEARINGS_FIELD,
            found: other.to_owned(),
            expected: format!("{ALL_BEARINGS} or {ONE_BEARING}with the name of a bearing"),
        })?),
    };
    Ok(BakeOptions {
        bearing,
        language: chosen(file, fields, LANGUAGE_FIELD, &Language::ALL)?,
        core: chosen(file, fields, CORE_FIELD, &Core::ALL)?,
        poses: Some(chosen(file, fields, POSES_FIELD, &PoseSource::ALL)?),
        name: "",
    })
}

/// Returns the value of a field with one of several names.
fn chosen<T: Copy>(file: &Path, fields: &[Field], name: &'static str, all: &[(&str, T)]) -> Result<T, VerifyError> {
    let found = required(file, fields, name)?;
    let one = all.iter().find(|(name, _)| *name == found);
    one.map(|(_, one)| *one).ok_or_else(|| VerifyError::Field {
        file: file.to_owned(),
        name,
        found: found.to_owned(),
        expected: all.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" or "),
    })
}

fn field_differences(file: &Path, found: &[Field], expected: &[Field]) -> Vec<Difference> {
    let difference = |name: &str, found: Option<&str>, expected: Option<&str>| Difference {
        file: file.to_owned(),
        part: BakedPart::Field,
        name: name.to_owned(),
        line: None,
        found: found.map(str::to_owned),
        expected: expected.map(str::to_owned),
    };
    let changed = expected.iter().filter_map(|field| {
        let found = value(found, &field.name);
        (found != Some(&field.value)).then(|| difference(&field.name, found, Some(&field.value)))
    });
    let added = found.iter().filter(|field| value(expected, &field.name).is_none());
    changed.chain(added.map(|field| difference(&field.name, Some(&field.value), None))).collect()
}

/// A token of a source, with its line number.
struct Token<'a> {
    text: &'a str,
    line: usize,
}

/// One constant, function or the comments of a source.
struct Item<'a> {
    part: BakedPart,
    name: String,
    tokens: Vec<Token<'a>>,
}

/// Items of a source in their order, without white space and commas before a closing bracket.
struct Items<'a>(Vec<Item<'a>>);

/// Name of the tokens before the first constant of a module.
const PREAMBLE: &str = "preamble";
/// Name of the comments.
const COMMENTS: &str = "comments";

impl<'a> Items<'a> {
    fn of(source: &'a str, language: Language) -> Self {
        let mut items = Self(vec![]);
        let (mut module, mut name) = (String::new(), PREAMBLE.to_owned());
        let mut blocks = [(embedded::CERTIFICATE, false), (embedded::SCENE, false)];
        for (i, line) in source.lines().enumerate() {
            let is_in_block = blocks.iter_mut().any(|(block, inside)| block.contains(line, inside));
            if is_in_block {
                continue;
            }
            let (code, comment) = line.split_at(line.find("//").unwrap_or(line.len()));
            match declared(code, language) {
                Some(Declaration::Module(declared)) => {
                    declared.clone_into(&mut module);
                    name = format!("{module}::{PREAMBLE}");
                }
                Some(Declaration::Constant(declared)) if module.is_empty() => declared.clone_into(&mut name),
                Some(Declaration::Constant(declared)) => name = format!("{module}::{declared}"),
                None => {}
            }
            items.add(BakedPart::Constant, &name, tokens(code, i + 1));
            items.add(BakedPart::Comment, COMMENTS, tokens(comment, i + 1));
        }
        items
    }

    fn add(&mut self, part: BakedPart, name: &str, tokens: impl Iterator<Item = Token<'a>>) {
        for token in tokens {
            // Most tokens belong to the last item: a search from the end is fast.
            let index = self.0.iter().rposition(|item| item.part == part && item.name == name);
            let index = index.unwrap_or_else(|| {
                self.0.push(Item { part, name: name.to_owned(), tokens: vec![] });
                self.0.len() - 1
            });
            let Some(item) = self.0.get_mut(index) else { continue };
            let is_closing = matches!(token.text, ")" | "]" | "}");
            if is_closing && item.tokens.last().is_some_and(|last| last.text == ",") {
                item.tokens.pop();
            }
            item.tokens.push(token);
        }
    }

    fn find(&self, part: BakedPart, name: &str) -> Option<&Item<'a>> {
        self.0.iter().find(|item| item.part == part && item.name == name)
    }

    fn differences(&self, expected: &Items<'_>, file: &Path) -> Vec<Difference> {
        let changed = expected.0.iter().filter_map(|item| match self.find(item.part, &item.name) {
            Some(found) => found.difference(item, file),
            None => Some(Difference { expected: Some(item.text()), ..item.named(file) }),
        });
        let added = self.0.iter().filter(|item| expected.find(item.part, &item.name).is_none());
        let added = added.map(|item| Difference { line: item.line(), found: Some(item.text()), ..item.named(file) });
        changed.chain(added).collect()
    }
}

/// Number of tokens shown of an item that only one of the two sources has.
const SHOWN_TOKENS: usize = 8;

impl Item<'_> {
    /// Returns a difference of the item without content.
    fn named(&self, file: &Path) -> Difference {
        let (file, name) = (file.to_owned(), self.name.clone());
        Difference { file, part: self.part, name, line: None, found: None, expected: None }
    }

    /// Returns the beginning of the item.
    fn text(&self) -> String {
        self.tokens.iter().map(|token| token.text).take(SHOWN_TOKENS).collect::<Vec<_>>().join(" ")
    }

    fn line(&self) -> Option<usize> {
        self.tokens.first().map(|token| token.line)
    }

    /// Returns the first difference.
    fn difference(&self, expected: &Item<'_>, file: &Path) -> Option<Difference> {
        let pairs = self.tokens.iter().zip(&expected.tokens);
        let same = pairs.take_while(|(found, expected)| found.text == expected.text).count();
        let (found, wanted) = (self.tokens.get(same), expected.tokens.get(same));
        if found.is_none() && wanted.is_none() {
            return None;
        }
        let text = |token: Option<&Token<'_>>| Some(token.map_or("end", |token| token.text).to_owned());
        let line = found.or(self.tokens.last()).map(|token| token.line);
        Some(Difference { line, found: text(found), expected: text(wanted), ..self.named(file) })
    }
}

/// Start of an item.
enum Declaration<'a> {
    Module(&'a str),
    Constant(&'a str),
}

/// Returns the item that begins on a line.
fn declared(line: &str, language: Language) -> Option<Declaration<'_>> {
    match language {
        Language::Rust => {
            let line = line.trim_start();
            let line = line.strip_prefix("pub ").unwrap_or(line);
            let (keyword, rest) = line.split_once(' ')?;
            let name = rest.split(|c: char| !is_of_word(c)).next()?;
            match keyword {
                "mod" => Some(Declaration::Module(name)),
                "const" | "static" | "fn" | "type" => Some(Declaration::Constant(name)),
                _ => None,
            }
        }
        // The certificate of a blob declares nothing.
        Language::Blob => None,
        Language::C => {
            if let Some(rest) = line.strip_prefix("#define ") {
                return rest.split_whitespace().next().map(Declaration::Constant);
            }
            let is_declaration =
                ["const ", "extern const ", "static const ", "uint64_t "].iter().any(|start| line.starts_with(start));
            let head = line.split(['[', '=', '(', ';']).next()?;
            head.split_whitespace().next_back().filter(|_| is_declaration).map(Declaration::Constant)
        }
    }
}

const fn is_of_word(c: char) -> bool {
    matches!(c, '_' | '.' | '+' | '-' | 'a'..='z' | 'A'..='Z' | '0'..='9')
}

/// Returns the tokens of a line: words, numbers and single other characters.
fn tokens(text: &str, line: usize) -> impl Iterator<Item = Token<'_>> {
    let mut rest = text.trim_start();
    std::iter::from_fn(move || {
        let first = rest.chars().next()?;
        let length = if is_of_word(first) {
            rest.find(|c: char| !is_of_word(c)).unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        let (token, after) = rest.split_at(length);
        rest = after.trim_start();
        Some(Token { text: token, line })
    })
}
