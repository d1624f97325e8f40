//! `ballrace bake`: writes the bearings of a scene as constants for firmware, with a certificate.

use super::{Format, check_distinct_paths, print_effects};
use crate::error::UsageError;
use anyhow::{Result, bail};
use ballrace_twin::bake::{
    BakeOptions, Baked, BearingCertificate, Core, FixedPointPath, Language, UnmeasuredAxial, bake,
};
use ballrace_twin::effect_significance;
use ballrace_twin::error::Error;
use ballrace_twin::output::AtomicFile;
use ballrace_twin::output::quoted;
use ballrace_twin::printable::number;
use ballrace_twin::scene::read::{load, read_str};
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `bake`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// File to write; of C, header F.h and source F.c are written, of a blob F.blob and its certificate F.txt.
    #[arg(short, long, value_name = "F.rs")]
    output: PathBuf,
    /// Write this bearing only.
    #[arg(long, value_name = "NAME")]
    bearing: Option<String>,
    /// Language of the constants, or a binary blob [default: rust for F.rs, c for F.h and F.c, blob for F.blob].
    #[arg(long, value_enum)]
    language: Option<Language>,
    /// Processor core whose measured cost the certificate states.
    #[arg(long, value_enum, default_value_t = Core::CortexM4f)]
    core: Core,
    #[command(flatten)]
    pub(super) limit: super::ErrorLimit,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if the scene is invalid or the output cannot be written.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<()> {
    let text = load(&args.scene)?;
    let scene = read_str(&text, &args.scene)?;
    let language = language(args)?;
    let outputs = outputs(args, language)?;
    let named: Vec<_> = outputs.iter().map(|path| ("--output", path.as_path())).collect();
    check_distinct_paths(&named, &[&args.scene])?;
    let name = args.output.file_stem().unwrap_or_default().to_string_lossy();
    let options = BakeOptions { bearing: args.bearing.as_deref(), language, core: args.core, poses: None, name: &name };
    let baked = bake(&scene, &text, &options).map_err(|error| match error {
        Error::Motion(_) => anyhow::Error::new(error),
        error => UsageError::with_bearing_option(error).into(),
    })?;
    for (path, file) in outputs.iter().zip(&baked.files) {
        AtomicFile::write(path, &file.content)?;
    }
    let significance = effect_significance::of_scene(&scene)?;
    print(&baked.bearings, (args, &outputs), format)?;
    if format == Format::Text {
        print_effects(&mut super::standard_output(format), &significance, error)
    } else {
        Ok(())
    }
}

/// Returns the language of the constants: `--language`, else that of the name of the file.
fn language(args: &Args) -> Result<Language, UsageError> {
    let extension = args.output.extension().and_then(|extension| extension.to_str());
    let of_name = match extension {
        Some("rs") => Some(Language::Rust),
        Some("h" | "c") => Some(Language::C),
        Some("blob") => Some(Language::Blob),
        _ => None,
    };
    let output = args.output.display();
    match (args.language, of_name) {
        (Some(Language::Rust), Some(other @ (Language::C | Language::Blob))) => Err(UsageError(format!(
            "--output: invalid name for --language rust: {output}, expected a name that ends in .rs, or --language {}",
            other.name()
        ))),
        (Some(language), _) | (None, Some(language)) => Ok(language),
        (None, None) => Err(UsageError(format!(
            "--output: no language for this name: {output}, expected a name that ends in .rs, .h, .c or .blob, or --language"
        ))),
    }
}

/// Returns the paths of the files to write: for C, header and source; for a blob, its certificate and the blob.
fn outputs(args: &Args, language: Language) -> Result<Vec<PathBuf>> {
    let output = &args.output;
    let extensions = match language {
        Language::Rust => return Ok(vec![output.clone()]),
        Language::C => ["h", "c"],
        Language::Blob => ["txt", "blob"],
    };
    let invalid = |expected| {
        let (language, output) = (language.name(), output.display());
        UsageError(format!("--output: invalid name for --language {language}: {output}, expected {expected}"))
    };
    let extension = output.extension().and_then(|extension| extension.to_str());
    match language {
        Language::Blob if extension != Some("blob") => bail!(invalid("a name that ends in .blob")),
        Language::C if !matches!(extension, Some("h" | "c")) => bail!(invalid("a name that ends in .h")),
        _ => {}
    }
    // In C, the name is part of an include directive.
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    let is_included = language == Language::C;
    if is_included && !output.file_stem().and_then(|stem| stem.to_str()).is_some_and(|stem| stem.chars().all(is_plain))
    {
        bail!(invalid("letters, digits, '_', '-' and '.'"));
    }
    Ok(extensions.map(|extension| output.with_extension(extension)).into())
}

fn print(baked: &[Baked], (args, outputs): (&Args, &[PathBuf]), format: Format) -> Result<()> {
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(baked)?)?,
        Format::Csv => {
            writeln!(
                out,
                "bearing,module,nodes,bytes,model,poses,largest_load_N,largest_error_N,instructions,cycles,stack,flash,checksum"
            )?;
            for Baked { bearing, module, nodes, bytes, certificate, .. } in baked {
                let BearingCertificate { model, poses, largest_load, error, cost, checksum, .. } = certificate;
                let cost = cost.map_or(",,,".to_owned(), |cost| {
                    let figures = [Some(cost.instructions), cost.cycles, cost.stack, cost.flash];
                    figures.map(|figure| figure.map_or(String::new(), |figure| format!("{figure:.0}"))).join(",")
                });
                writeln!(
                    out,
                    "{},{},{nodes},{bytes},{},{poses},{largest_load:.3e},{error:.1e},{cost},{checksum:#018x}",
                    quoted(bearing),
                    quoted(module),
                    quoted(model)
                )?;
            }
        }
        Format::Text => {
            for bearing in baked {
                print_bearing(&mut out, bearing, args.core)?;
            }
            let outputs: Vec<String> = outputs.iter().map(|path| path.display().to_string()).collect();
            writeln!(out, "Written: {}", outputs.join(", "))?;
        }
    }
    Ok(out.flush()?)
}

fn print_bearing(out: &mut impl Write, baked: &Baked, core: Core) -> Result<()> {
    let Baked { bearing, module, nodes, bytes, certificate, unmeasured_axial, fixed_point } = baked;
    let BearingCertificate { poses, poses_from, reference, largest_load, error, cost, checksum, .. } = certificate;
    writeln!(out, "Bearing {bearing}: module {module}, table of {nodes} nodes, {bytes} bytes of flash")?;
    writeln!(
        out,
        "  largest error {error:.1e} N of {largest_load:.3e} N at {poses} poses ({}), against {reference}",
        poses_from.name()
    )?;
    match cost {
        Some(cost) => {
            let about = if cost.counted { "" } else { "~" };
            let least = cost.least_instructions.map_or(String::new(), |least| format!("{least:.0} to "));
            write!(out, "  {about}{least}{:.0} instructions", cost.instructions)?;
            for (figure, unit) in [(cost.cycles, "modelled cycles"), (cost.stack, "bytes of stack")] {
                if let Some(figure) = figure {
                    write!(out, ", {about}{figure:.0} {unit}")?;
                }
            }
            writeln!(out, " on {}", core.name())?;
        }
        None => writeln!(out, "  cost not counted on {} with these effects", core.name())?,
    }
    writeln!(out, "  checksum {checksum:#018x}")?;
    if let Some(path) = fixed_point {
        writeln!(
            out,
            "  the number of instructions depends on the input on this core. bearing::fixed_point takes a constant one: {} (firmware guide, \
             \"Without a floating-point unit\")",
            fixed_point_text(path)
        )?;
    }
    if let Some(UnmeasuredAxial { w_um, force_n, force_without_n }) = unmeasured_axial {
        writeln!(
            out,
            "  no probe of the scene measures w: with u and v alone the force at rest is {force_without_n:.1} N in place of {force_n:.1} N. Add \
             w = {w_um:.2} um to the offset, or use the observer (firmware guide, \"From scene to interrupt\")"
        )?;
    }
    Ok(())
}

/// Returns the parameters of a path with a constant number of instructions.
fn fixed_point_text(path: &FixedPointPath) -> String {
    match path {
        FixedPointPath::Lumped { stiffness, exponent, radial_play, has_axial } => {
            let axial = if *has_axial { ", and its axial elements by `Axial`" } else { "" };
            let (n, play) = (number(*exponent), number(1e6 * radial_play));
            format!("stiffness {stiffness:.6e} N/m^{n}, radial play {play} um{axial}")
        }
        FixedPointPath::Tabulated { least_range, node_bytes } => format!(
            "`Tabulated` from these constants, {node_bytes} bytes of memory for the nodes of one speed, a range of {} mm or more",
            number(1e3 * least_range)
        ),
    }
}
