//! `ballrace sweep`: simulates a scene over ranges of its keys.

use super::{Format, check_distinct_paths, print_effects};
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_report as report;
use ballrace_twin::effect_significance::EffectSignificance;
use ballrace_twin::output::AtomicFile;
use ballrace_twin::scene::read::read_file;
use ballrace_twin::scene::units::{Dimension, parse};
use ballrace_twin::sweep::{self, Axis, Chain, Follow, Journal, Measure, OverflowedPoint, Plan, Row};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Arguments of `sweep`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// Key of the scene and its values: a range with a count, e.g. shaft.speed=500rpm..10000rpm:200, or with a step, e.g.
    /// 500rpm..10000rpm:50rpm, or a list, e.g. 7,9,11. May be given several times; the first key varies fastest.
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    over: Vec<String>,
    /// Base name of the results: NAME.csv, NAME.parquet, NAME-sections.csv, NAME.html; NAME.journal while the sweep runs.
    #[arg(short, long, value_name = "NAME")]
    output: PathBuf,
    /// Transient at each point that is simulated but not measured, e.g. "1 s" [default: from the rotor's damping, longer until neighbouring motions have contracted].
    #[arg(long, value_name = "T")]
    settle: Option<String>,
    /// Number of section periods measured at each point.
    #[arg(long, value_name = "N", default_value_t = 96, value_parser = clap::value_parser!(u32).range(16..=4096))]
    periods: u32,
    /// Event at which the Poincare section is taken.
    #[arg(long, value_enum, default_value_t = Section::BallPass)]
    section: Section,
    /// Start each point from the final state of its neighbour along the first key: upwards, downwards, or both.
    #[arg(long, value_enum, default_value_t = Follow::None)]
    follow: Follow,
    /// Compute the largest Lyapunov exponent as well, at twice the cost.
    #[arg(long)]
    lyapunov: bool,
    /// Compute this part of the points only, e.g. 3/16, into NAME.shard-3-of-16, for --merge.
    #[arg(long, value_name = "K/N", conflicts_with = "merge")]
    shard: Option<String>,
    /// Merge all shards of NAME.
    #[arg(long)]
    merge: bool,
    /// Number of points computed in parallel [default: number of processors].
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    #[command(flatten)]
    pub(super) limit: super::ErrorLimit,
}

/// Largest number of points that overflow in the text.
const MAX_PRINTED: usize = 8;

/// Values of `--section`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Section {
    /// Once per ball pass of the first bearing.
    BallPass,
    /// Once per shaft revolution.
    Shaft,
}

#[derive(Serialize)]
struct Summary {
    scene: String,
    points: usize,
    computed: usize,
    /// Points read from journals of earlier runs.
    taken_over: usize,
    written: Vec<String>,
    /// Points at which the motion overflows.
    overflowed: Vec<OverflowedPoint>,
    /// Significance of each effect at the point where its removal changes the result most.
    #[serde(rename = "effect_significance")]
    significance: Vec<EffectSignificance>,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if scene, options or files are invalid.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<()> {
    let scene = read_file(&args.scene)?;
    let text = std::fs::read_to_string(&args.scene).with_context(|| args.scene.display().to_string())?;
    let axes = args.over.iter().map(|text| Axis::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let settle = args.settle.as_ref().map(|text| parse_settling_time(text)).transpose()?;
    let measure = Measure {
        settle,
        periods: args.periods as usize,
        by_shaft: args.section == Section::Shaft,
        lyapunov: args.lyapunov,
    };
    let plan = Plan { text, path: args.scene.clone(), axes, follow: args.follow, measure }.checked()?;
    // An invalid end of a range is reported before the computation, which may take hours.
    for point in [0, plan.points() - 1] {
        plan.scene(&plan.values(point))?;
    }
    let [table, columns, section, page] =
        ["csv", "parquet", "sections", "html"].map(|ending| output_path(&args.output, ending));
    let outputs = [&table, &columns, &section, &page].map(|path| ("--output", path.as_path()));
    check_distinct_paths(&outputs, &[&args.scene])?;
    if let Some(shard) = &args.shard {
        return run_shard(args, &plan, shard, format);
    }
    let (chains, computed, journal) = if args.merge {
        (read_shards(&args.output, &plan)?, 0, None)
    } else {
        let path = output_path(&args.output, "journal");
        let numbers: Vec<usize> = (0..plan.chains()).collect();
        let (journal, computed) = run_chains(args, &plan, &numbers, &path)?;
        (journal.done, computed, Some(path))
    };
    let rows: Vec<&Row> = chains.values().flat_map(|chain: &Chain| &chain.rows).collect();
    let overflowed = plan.overflowed(&rows);
    if let Some(first) = overflowed.first().filter(|_| overflowed.len() == rows.len()) {
        remove_journal(journal.as_deref())?;
        bail!("no result: the motion overflows at every point of {}; {}: {}", rows.len(), first.values, first.reason);
    }
    write_file(&table, |out| sweep::csv(out, &plan.axes, &rows))?;
    write_file(&section, |out| sweep::sections(out, &rows))?;
    let mut bytes = Vec::new();
    sweep::parquet(&mut bytes, &plan.axes, &rows)?;
    write_file(&columns, |out| out.write_all(&bytes))?;
    let html = report::sweep::html(&scene.name, &plan.axes, &rows)?;
    write_file(&page, |out| out.write_all(html.as_bytes()))?;
    remove_journal(journal.as_deref())?;
    let written = [&table, &columns, &section, &page].map(|path| path.display().to_string()).to_vec();
    let summary = Summary {
        scene: scene.name,
        points: rows.len(),
        computed,
        taken_over: rows.len() - computed,
        written,
        overflowed,
        significance: plan.significance(&rows)?,
    };
    print(&summary, &plan.axes, &rows, format)?;
    if format == Format::Text {
        print_effects(&mut super::standard_output(format), &summary.significance, error)
    } else {
        Ok(())
    }
}

fn parse_settling_time(text: &str) -> Result<f64> {
    let invalid = || {
        UsageError(format!("--settle: invalid duration: {text:?}, expected {}", Dimension::Time.expected("0 or more")))
    };
    let value = text.parse::<f64>().or_else(|_| parse(text, Dimension::Time)).map_err(|_| invalid())?;
    if !(value >= 0.0 && value.is_finite()) {
        bail!(invalid());
    }
    Ok(value)
}

/// Returns the path of NAME with `ending`; an ending .csv, .parquet or .html of NAME is replaced.
fn output_path(output: &Path, ending: &str) -> PathBuf {
    let name = output.to_string_lossy();
    let stem = [".csv", ".parquet", ".html"].iter().find_map(|known| name.strip_suffix(known)).unwrap_or(&name);
    PathBuf::from(if ending == "sections" { format!("{stem}-sections.csv") } else { format!("{stem}.{ending}") })
}

fn write_file(path: &Path, fill: impl FnOnce(&mut AtomicFile) -> std::io::Result<()>) -> Result<()> {
    let mut file = AtomicFile::create(path)?;
    fill(&mut file).with_context(|| format!("{}: this file cannot be written", path.display()))?;
    Ok(file.finish()?)
}

/// Computes the chains that the journal at `path` does not contain; returns the journal and the number of new points.
fn run_chains(args: &Args, plan: &Plan, chains: &[usize], path: &Path) -> Result<(Journal, usize)> {
    let journal = Journal::open(path, plan.identity()?)?;
    let before: usize = journal.done.values().map(|chain| chain.rows.len()).sum();
    let jobs = args.jobs.or_else(|| std::thread::available_parallelism().ok().map(Into::into)).unwrap_or(1);
    let bar =
        if std::io::stderr().is_terminal() { ProgressBar::new(chains.len() as u64) } else { ProgressBar::hidden() };
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} points, {eta} left") {
        bar.set_style(style);
    }
    bar.set_position(journal.done.len() as u64);
    let run = plan.run(chains, journal, jobs, || bar.inc(1));
    bar.finish_and_clear();
    // A sweep that failed without a result leaves no journal behind.
    if run.is_err() && sweep::read(path, &plan.identity()?).is_ok_and(|done| done.is_empty()) {
        std::fs::remove_file(path).with_context(|| path.display().to_string())?;
    }
    let journal = run?;
    let after: usize = journal.done.values().map(|chain| chain.rows.len()).sum();
    Ok((journal, after - before))
}

fn remove_journal(journal: Option<&Path>) -> Result<()> {
    match journal {
        Some(journal) => std::fs::remove_file(journal).with_context(|| journal.display().to_string()),
        None => Ok(()),
    }
}

fn shard_path(output: &Path, k: usize, n: usize) -> PathBuf {
    output_path(output, &format!("shard-{k}-of-{n}"))
}

/// Computes every `n`-th chain, starting with chain `k - 1`, for `shard` = `k/n`.
fn run_shard(args: &Args, plan: &Plan, shard: &str, format: Format) -> Result<()> {
    let parsed = shard.split_once('/').and_then(|(k, n)| Some((k.parse::<usize>().ok()?, n.parse::<usize>().ok()?)));
    let Some((k, n)) = parsed.filter(|(k, n)| (1..=*n).contains(k)) else {
        bail!(UsageError(format!("--shard: invalid part: {shard:?}, expected K/N with K from 1 to N, such as 3/16")));
    };
    let chains: Vec<usize> = (0..plan.chains()).filter(|number| number % n == k - 1).collect();
    let path = shard_path(&args.output, k, n);
    let (journal, computed) = run_chains(args, plan, &chains, &path)?;
    let points: usize = journal.done.values().map(|chain| chain.rows.len()).sum();
    let summary = Summary {
        scene: args.scene.display().to_string(),
        points,
        computed,
        taken_over: points - computed,
        written: vec![path.display().to_string()],
        overflowed: plan.overflowed(&journal.done.values().flat_map(|chain| &chain.rows).collect::<Vec<_>>()),
        significance: vec![],
    };
    print(&summary, &plan.axes, &[], format)
}

/// Reads the chains of all shards of NAME.
///
/// # Errors
/// Returns an error if a shard cannot be read or a chain is missing.
fn read_shards(output: &Path, plan: &Plan) -> Result<BTreeMap<usize, Chain>> {
    let start = output_path(output, "shard-");
    let folder = start.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let prefix = start.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let mut chains = BTreeMap::new();
    let entries = std::fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    for entry in entries {
        let path = entry?.path();
        if path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(&prefix)) {
            chains.extend(sweep::read(&path, &plan.identity()?)?);
        }
    }
    let missing = (0..plan.chains()).filter(|number| !chains.contains_key(number)).count();
    if missing > 0 {
        let total = plan.chains();
        bail!("{}: missing {missing} of {total} parts in the files {prefix}K-of-N", folder.display());
    }
    Ok(chains)
}

fn print(summary: &Summary, axes: &[Axis], rows: &[&Row], format: Format) -> Result<()> {
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(summary)?)?,
        Format::Csv => sweep::csv(&mut out, axes, rows)?,
        Format::Text => {
            let Summary { scene, points, computed, taken_over, .. } = summary;
            writeln!(out, "{scene}: {points} points, {computed} computed, {taken_over} from an earlier run")?;
            for path in &summary.written {
                writeln!(out, "Written: {path}")?;
            }
            print_overflowed(&mut out, &summary.overflowed, *points)?;
        }
    }
    Ok(out.flush()?)
}

/// Prints the points at which the motion overflows, at most [`MAX_PRINTED`].
fn print_overflowed(out: &mut impl Write, overflowed: &[OverflowedPoint], points: usize) -> Result<()> {
    if overflowed.is_empty() {
        return Ok(());
    }
    writeln!(out, "WARNING: the motion overflows at {} of {points} points, which have no results:", overflowed.len())?;
    for OverflowedPoint { point, direction, values, reason } in overflowed.iter().take(MAX_PRINTED) {
        let direction = if direction == "rest" { String::new() } else { format!(", {direction}") };
        writeln!(out, "  point {point} ({values}{direction}): {reason}")?;
    }
    if overflowed.len() > MAX_PRINTED {
        writeln!(out, "  and {} more; the column overflow of the table has them", overflowed.len() - MAX_PRINTED)?;
    }
    Ok(())
}
