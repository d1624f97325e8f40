//! Constants as a binary file, which firmware checks and uses in place: the layout is that of [`ballrace::blob`].

use super::{BakedFile, Comments, Language, Part, embedded, linearised};
use ballrace::blob::{BEARING_HEADER, HEADER, LONGEST_NAME, MAGIC, TRAILER, VERSION};
use ballrace::log::crc32;
use ballrace_models::build;
use ballrace_models::model::Constants;
use ballrace_plant::error::{BakeError, Result};
use ballrace_scene::Scene;

/// Extension of a blob.
pub const EXTENSION: &str = "blob";
/// Extension of its certificate.
pub const CERTIFICATE_EXTENSION: &str = "txt";

/// Returns the certificate and the blob.
///
/// # Errors
/// Returns an error if a name is too long or a constant cannot be computed.
pub fn files(scene: &Scene, parts: &[Part<'_>], comments: &Comments<'_>) -> Result<Vec<BakedFile>> {
    let certificate = format!(
        "// Made by `ballrace bake` from the scene \"{}\": certificate of the blob beside it. Do not edit: bake the scene again.\n{}\n\
         // Text of the scene.\n{}",
        embedded::escaped(&scene.name),
        embedded::CERTIFICATE.write(&comments.certificate),
        embedded::SCENE.write(comments.scene)
    );
    Ok(vec![
        BakedFile { extension: Some(CERTIFICATE_EXTENSION), content: certificate.into_bytes() },
        BakedFile { extension: Some(EXTENSION), content: of(scene, parts)? },
    ])
}

fn of(scene: &Scene, parts: &[Part<'_>]) -> Result<Vec<u8>> {
    let bearings = parts.iter().map(|part| bearing(scene, part)).collect::<Result<Vec<_>>>()?.concat();
    let mut blob = Vec::with_capacity(HEADER + bearings.len() + TRAILER);
    blob.extend(MAGIC);
    blob.extend(VERSION.to_le_bytes());
    blob.extend((parts.len() as u16).to_le_bytes());
    blob.extend(((HEADER + bearings.len() + TRAILER) as u32).to_le_bytes());
    blob.extend([0; 4]);
    blob.extend(bearings);
    blob.extend([0; 4]);
    blob.extend(crc32(&blob).to_le_bytes());
    Ok(blob)
}

fn bearing(scene: &Scene, part: &Part<'_>) -> Result<Vec<u8>> {
    let (selected, certificate) = (part.selected, &part.certificate);
    let of = selected.firmware.in_c(selected.of);
    if of.name.len() > LONGEST_NAME {
        return Err(BakeError::NotInC {
            file: scene.path.clone(),
            language: Language::Blob.name(),
            place: format!("bearing {}", of.name),
            found: format!("a name of {} bytes", of.name.len()),
            expected: "at most 24",
        }
        .into());
    }
    let elements = if of.model.has_elements() { build::places::<f32>(&of) } else { vec![] };
    let springs = linearised(scene, &of)?;
    let offset = build::offset_as_mounted(scene, selected.of)?;
    let constants = Constants { scene, of: &of, table: part.table.as_ref(), offset, springs: springs.as_ref() };
    let own = selected.firmware.c_struct(&constants)?;
    let (table, words) = (own.array.as_ref().map_or(&[][..], |array| &array.numbers), own.words());
    let kinematics = if elements.is_empty() { None } else { Some(build::kinematics(scene, &of)?) };
    let ratios = kinematics.map_or([0.0; 3], |k| [k.cage_ratio, k.ball_ratio(), k.outer_ratio]);
    let range = &certificate.range;
    let displacements = [offset.to_array().map(|x| x as f32), range.centre.to_array(), range.amplitude.to_array()];

    let mut bytes = vec![0; 4];
    let counts = [elements.len(), table.len(), words.len()].map(|count| count as u32);
    bytes.extend([own.code].into_iter().chain(counts).flat_map(u32::to_le_bytes));
    bytes.extend((of.station as f32).to_le_bytes());
    bytes.extend(of.name.bytes().chain(std::iter::repeat(0)).take(LONGEST_NAME));
    bytes.extend(ratios.into_iter().flat_map(f64::to_le_bytes));
    bytes.extend(certificate.checksum.to_le_bytes());
    let speeds = [range.inner_speed, range.outer_speed];
    bytes.extend(displacements.as_flattened().iter().chain(speeds.as_flattened()).flat_map(|x| x.to_le_bytes()));
    bytes.resize(BEARING_HEADER, 0);
    for element in &elements {
        let (cos, sin) = element.direction();
        bytes.extend([cos, sin].into_iter().flat_map(f32::to_le_bytes).chain(element.azimuth().0.to_le_bytes()));
    }
    bytes.extend(table.iter().flat_map(|x| x.to_le_bytes()).chain(words.into_iter().flat_map(u32::to_le_bytes)));
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    let length = (bytes.len() as u32).to_le_bytes();
    bytes.splice(..length.len(), length);
    Ok(bytes)
}

/// Returns where two blobs differ first: the name of the place, and what both have there.
pub fn difference(found: &[u8], expected: &[u8]) -> Option<[String; 3]> {
    const SHOWN: usize = 8;
    let difference = found.iter().zip(expected).position(|(a, b)| a != b);
    let first = difference.or((found.len() != expected.len()).then(|| found.len().min(expected.len())))?;
    let shown = |bytes: &[u8]| {
        let bytes = bytes.iter().skip(first).take(SHOWN);
        let text: Vec<String> = bytes.map(|byte| format!("{byte:02x}")).collect();
        if text.is_empty() { "end".to_owned() } else { text.join(" ") }
    };
    Some([format!("byte {first}{}", place(first, expected)), shown(found), shown(expected)])
}

/// Returns the number of four bytes at an offset; 0 beyond the end.
fn integer(blob: &[u8], offset: usize) -> u32 {
    let word = blob.get(offset..).and_then(<[u8]>::first_chunk);
    word.map_or(0, |word| u32::from_le_bytes(*word))
}

/// Returns begin, length and name of each bearing of a blob.
fn bearings(blob: &[u8]) -> Vec<(usize, usize, String)> {
    let mut all = vec![];
    let mut begin = HEADER;
    while begin + BEARING_HEADER <= blob.len() {
        let length = (integer(blob, begin) as usize).max(BEARING_HEADER);
        let name = blob.get(begin + 24..begin + 24 + LONGEST_NAME).unwrap_or_default();
        let name = String::from_utf8_lossy(name).trim_end_matches('\0').to_owned();
        all.push((begin, length, name));
        begin += length;
    }
    all
}

/// Returns the names of the bearings of a blob.
pub fn names(blob: &[u8]) -> Vec<String> {
    if !blob.starts_with(&MAGIC) {
        return vec![];
    }
    bearings(blob).into_iter().map(|(.., name)| name).collect()
}

/// Returns the CRC-32 at the end of a blob.
pub fn stated_crc32(blob: &[u8]) -> Option<String> {
    let stated = blob.len().checked_sub(4).filter(|_| blob.starts_with(&MAGIC))?;
    Some(format!("{:#010x}", integer(blob, stated)))
}

/// Returns the content of a blob in words.
pub fn described(blob: &[u8]) -> String {
    let names = names(blob).join(", ");
    let Some(stated) = stated_crc32(blob).filter(|_| !names.is_empty()) else {
        return "not a blob of ballrace".to_owned();
    };
    let found = format!("{:#010x}", crc32(&blob[..blob.len() - 4]));
    let state = if found == stated { String::new() } else { format!(", damaged: its bytes have {found}") };
    format!("bearings {names}, CRC-32 {stated}{state}")
}

/// Returns the part of a blob that contains a byte.
fn place(byte: usize, blob: &[u8]) -> String {
    let within = |(begin, length, _): &(usize, usize, String)| (*begin..begin + length).contains(&byte);
    if let Some((begin, _, name)) = bearings(blob).into_iter().find(within) {
        let elements = BEARING_HEADER + 16 * integer(blob, begin + 8) as usize;
        let part = match byte - begin {
            offset if offset < BEARING_HEADER => "header",
            offset if offset < elements => "elements",
            offset if offset < elements + 4 * integer(blob, begin + 12) as usize => "table",
            _ => "constants",
        };
        return format!(", {part} of bearing {name}");
    }
    if byte < HEADER { ", header".to_owned() } else { ", CRC-32".to_owned() }
}
