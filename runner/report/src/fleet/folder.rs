//! Files of a fleet: `outcomes/part-*.parquet`, `reports/*.html`, `trends.csv` and `index.html`.

use super::{Fleet, html};
use anyhow::Result;
use ballrace_twin::error::FleetError;
use ballrace_twin::fleet::{Evaluation, Key, Machine, Row, Trend, report_names, trends_csv};
use ballrace_twin::output::{AtomicFile, replace};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Longest time for which the files of a stored row may not answer; the row is then evaluated again.
const PATIENCE: Duration = Duration::from_secs(10);

/// Returns the report of an evaluation; `None` without an outcome. A report that cannot be rendered becomes the error of the row.
pub fn page_of(evaluation: &mut Evaluation) -> Option<String> {
    match crate::html(evaluation.outcome.as_ref()?) {
        Ok(page) => Some(page),
        Err(error) => {
            evaluation.row.error = Some(format!("the report cannot be written: {error:#}"));
            None
        }
    }
}

/// Folder of the results of a fleet.
pub struct Folder {
    path: PathBuf,
    /// Names of the reports in `reports`.
    reports: HashMap<Key, String>,
}

impl Folder {
    /// Opens the folder for the machines of a table; it is created where it does not exist.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be created.
    pub fn create(path: &Path, machines: &[Machine]) -> Result<Self, FleetError> {
        let reports = path.join("reports");
        std::fs::create_dir_all(&reports).map_err(|source| FleetError::Write { file: reports, source })?;
        let reports = machines.iter().map(Machine::key).zip(report_names(machines)).collect();
        Ok(Self { path: path.to_owned(), reports })
    }

    /// Returns the folder of the store.
    #[must_use]
    pub fn outcomes(&self) -> PathBuf {
        self.path.join("outcomes")
    }

    /// Returns the path of the overview.
    #[must_use]
    pub fn index(&self) -> PathBuf {
        self.path.join("index.html")
    }

    /// Returns the path of the table of trends.
    #[must_use]
    pub fn trends(&self) -> PathBuf {
        self.path.join("trends.csv")
    }

    /// Returns the link from the overview to the report of a row; `None` where the report does not exist.
    #[must_use]
    pub fn link(&self, key: &Key) -> Option<String> {
        let link = format!("reports/{}", self.reports.get(key)?);
        self.path.join(&link).is_file().then_some(link)
    }

    /// Returns true where `row` is up to date for `machine` and, with `needs_report`, has its report.
    #[must_use]
    pub fn is_done(&self, machine: &Machine, row: &Row, needs_report: bool) -> bool {
        let has_report = || !needs_report || row.error.is_some() || self.link(&row.key()).is_some();
        machine.fingerprint_within(PATIENCE).is_some_and(|inputs| row.inputs == inputs) && has_report()
    }

    /// Writes the report of an evaluation, see [`page_of`].
    ///
    /// # Errors
    /// As [`Folder::write_page`].
    pub fn write_report(&self, evaluation: &mut Evaluation) -> Result<(), FleetError> {
        let page = page_of(evaluation);
        self.write_page(&evaluation.row.key(), page.as_deref())
    }

    /// Writes the report of a row; without a page, the report of an earlier evaluation is removed.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written or removed.
    pub fn write_page(&self, key: &Key, page: Option<&str>) -> Result<(), FleetError> {
        let Some(name) = self.reports.get(key) else { return Ok(()) };
        let path = self.path.join("reports").join(name);
        let failed = |source| FleetError::Write { file: path.clone(), source };
        match page.map(|page| replace(&path, page.as_bytes())) {
            Some(written) => written.map(drop).map_err(failed),
            None => match std::fs::remove_file(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(failed(error)),
                _ => Ok(()),
            },
        }
    }

    /// Writes the table of trends and the overview.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written or the page cannot be rendered.
    pub fn write_overview(&self, name: &str, rows: &[Row], trends: &[Trend]) -> Result<()> {
        let mut table = Vec::new();
        trends_csv(&mut table, trends)?;
        AtomicFile::write(&self.trends(), &table)?;
        let fleet = Fleet { name, rows, trends, link: &|key| self.link(key) };
        Ok(AtomicFile::write(&self.index(), &html(&fleet)?)?)
    }
}
