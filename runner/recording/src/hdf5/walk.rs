//! Content of a file: vectors and single numbers with their paths.

use std::io;

use super::object::{Dataset, Object, Type};
use super::{Source, Vector, data, group, refuse};

/// Maximum nesting depth of groups.
const DEEPEST: usize = 16;
/// Largest number of objects that are visited.
const MAX_OBJECTS: usize = 1 << 16;
/// Longest path, bytes.
const LONGEST_PATH: usize = 1024;
/// Largest number of columns of a matrix that are listed.
const MAX_COLUMNS: u64 = 4096;
/// Largest number of vectors.
const MAX_VECTORS: usize = 1 << 16;
/// Largest number of datasets whose reason is kept.
const MAX_REFUSED: usize = 1 << 12;

/// A single number: an attribute, or a dataset of one element.
#[derive(Debug, Clone, Copy)]
pub(super) enum Scalar {
    Value(f64),
    /// Place in the list of datasets.
    Dataset(usize),
}

/// Content of a file.
#[derive(Default)]
pub(super) struct Content {
    pub(super) datasets: Vec<Dataset>,
    pub(super) vectors: Vec<(String, Vector)>,
    pub(super) scalars: Vec<(String, Scalar)>,
    /// Paths of datasets that are not read, with the reason.
    pub(super) refused: Vec<(String, String)>,
    objects: usize,
    is_matlab: bool,
}

/// Visits every object below the root group.
pub(super) fn content(source: &mut Source, root: u64, is_matlab: bool) -> io::Result<Content> {
    let mut content = Content { is_matlab, ..Content::default() };
    content.visit(source, root, String::new(), &mut Vec::new())?;
    Ok(content)
}

impl Content {
    fn visit(&mut self, source: &mut Source, address: u64, path: String, above: &mut Vec<u64>) -> io::Result<()> {
        self.objects += 1;
        if self.objects > MAX_OBJECTS {
            return Err(refuse(format!("more than {MAX_OBJECTS} objects")));
        }
        // A link may lead back to a group above.
        if above.contains(&address) {
            return Ok(());
        }
        if above.len() > DEEPEST || path.len() > LONGEST_PATH {
            return Err(refuse(format!("groups within each other: {}", path.chars().take(80).collect::<String>())));
        }
        let object = Object::read(source, address)?;
        if !self.is_matlab {
            let numbers = object.numbers.iter();
            self.scalars.extend(numbers.map(|(name, value)| (format!("{path}@{name}"), Scalar::Value(*value))));
        }
        if let Some(reason) = object.refusal() {
            self.refuse(path, reason);
            return Ok(());
        }
        let Some((kind, dataset)) = object.dataset() else {
            above.push(address);
            for (name, member) in group::members(source, &object)? {
                if !(self.is_matlab && path.is_empty() && name.starts_with('#')) {
                    self.member(source, member, &path, &name, above)?;
                }
            }
            above.pop();
            return Ok(());
        };
        match kind {
            Type::Number(_) if !object.numbers.iter().any(|(name, _)| name == "MATLAB_empty") => {
                self.numbers(dataset, &path)?;
            }
            Type::Compound(fields) => {
                for (name, offset, field) in fields {
                    let path = format!("{path}.{name}");
                    match field {
                        Ok(number) => self.numbers(Dataset { number, offset, ..dataset.clone() }, &path)?,
                        Err(reason) => self.refuse(path, reason),
                    }
                }
            }
            Type::Number(_) | Type::Reference => {}
        }
        Ok(())
    }

    fn refuse(&mut self, path: String, reason: String) {
        if self.refused.len() < MAX_REFUSED {
            self.refused.push((path, reason));
        }
    }

    /// Visits a member of a group. In a file of MATLAB references are the elements of a cell array or a structure array.
    fn member(
        &mut self,
        source: &mut Source,
        address: u64,
        path: &str,
        name: &str,
        above: &mut Vec<u64>,
    ) -> io::Result<()> {
        let joined = match (self.is_matlab, path.is_empty()) {
            (false, _) => format!("{path}/{name}"),
            (true, true) => name.to_owned(),
            (true, false) => format!("{path}.{name}"),
        };
        if !self.is_matlab {
            return self.visit(source, address, joined, above);
        }
        self.matlab(source, address, joined, Some((path, name)), above)
    }

    /// Visits an object of a file of MATLAB; `parent` is the path of its structure with its name there.
    fn matlab(
        &mut self,
        source: &mut Source,
        address: u64,
        path: String,
        parent: Option<(&str, &str)>,
        above: &mut Vec<u64>,
    ) -> io::Result<()> {
        let object = Object::read(source, address)?;
        let Some((Type::Reference, dataset)) = object.dataset() else {
            return self.visit(source, address, path, above);
        };
        if above.len() > DEEPEST {
            return Ok(());
        }
        let is_cell = object.texts.iter().any(|(name, text)| name == "MATLAB_class" && text == "cell");
        let count = dataset.lengths.iter().fold(1_u64, |count, length| count.saturating_mul(*length));
        if count > MAX_OBJECTS as u64 {
            return Err(refuse(format!("{count} references in `{path}`")));
        }
        let flat = Dataset { lengths: vec![count], ..dataset };
        let bytes = data::all(source, &flat)?;
        above.push(address);
        for (index, bytes) in bytes.chunks_exact(8).enumerate() {
            let element = super::little(bytes).u64()?;
            let own = match parent {
                Some((parent, name)) if !is_cell && !parent.is_empty() => format!("{parent}({}).{name}", index + 1),
                _ => format!("{path}{{{}}}", index + 1),
            };
            self.objects += 1;
            if !above.contains(&element) && element != 0 {
                self.matlab(source, element, own, None, above)?;
            }
        }
        above.pop();
        Ok(())
    }

    /// Lists a dataset: a number, a vector, or the columns of a matrix, or its rows where those are longer.
    fn numbers(&mut self, dataset: Dataset, path: &str) -> io::Result<()> {
        let long = dataset.lengths.iter().enumerate().filter(|(_, length)| **length > 1).map(|(place, _)| place);
        let long: Vec<usize> = long.collect();
        if dataset.lengths.contains(&0) {
            return Ok(());
        }
        let (place, last) = (self.datasets.len(), dataset.lengths.len().saturating_sub(1));
        match *long {
            [] => self.scalars.push((path.to_owned(), Scalar::Dataset(place))),
            [along] => self.vectors.push((path.to_owned(), Vector { dataset: place, along, cut: None })),
            [first, second] => {
                let (rows, columns) = (dataset.length(first), dataset.length(second));
                // The matrices of MATLAB are stored with their dimensions exchanged.
                let along = if rows > columns || (rows == columns && !self.is_matlab) { first } else { second };
                let across = if along == first { second } else { first };
                for index in 0..dataset.length(across).min(MAX_COLUMNS) {
                    let is_column = (along == first) != self.is_matlab;
                    let name = match (self.is_matlab, is_column) {
                        (true, true) => format!("{path}(:,{})", index + 1),
                        (true, false) => format!("{path}({},:)", index + 1),
                        (false, true) => format!("{path}[:,{index}]"),
                        (false, false) => format!("{path}[{index},:]"),
                    };
                    self.vectors.push((name, Vector { dataset: place, along, cut: Some((across, index)) }));
                }
            }
            _ => {
                self.refuse(path.to_owned(), format!("an array of {} dimensions", long.len()));
                return Ok(());
            }
        }
        if self.vectors.len() > MAX_VECTORS || last > 32 {
            return Err(refuse(format!("more than {MAX_VECTORS} vectors")));
        }
        self.datasets.push(dataset);
        Ok(())
    }
}
