//! Constants of the equations of motion of a flexible rotor, or of a rigid rotor on elastic supports.

use super::matrix_text;
use ballrace_plant::Plant;
use ballrace_plant::error::Result;
use ballrace_scene::Scene;
use std::fmt::Write;

/// Returns true for a scene whose rotor has more coordinates than those of a rigid rotor on fixed bearings.
pub(crate) fn has_further_coordinates(scene: &Scene) -> bool {
    let flexible = scene.rotor.as_ref().is_some_and(|rotor| rotor.flexible.is_some());
    flexible || scene.rotor.is_some() && scene.bearings.iter().any(|bearing| bearing.support.is_some())
}

/// Writes the module `rotor` if the rotor is flexible or on elastic supports.
///
/// # Errors
/// Returns the errors of [`Plant::try_new`].
pub fn module(out: &mut String, scene: &Scene) -> Result<()> {
    if !has_further_coordinates(scene) {
        return Ok(());
    }
    let plant = Plant::try_new(scene)?;
    let scales = plant.scales()?;
    let (n, count) = (plant.layout.order, plant.bearings.len());
    writeln!(out, "\n/// The rotor without its bearings: `M q'' + (B + w G) q' + K q`.\npub mod rotor {{")?;
    writeln!(out, "    use ballrace::Exact;")?;
    writeln!(out, "    use ballrace::rotor::{{Attachment, InvalidMatrix, LinearSystem, SystemMatrices}};\n")?;
    let coordinates = plant.layout.names(&plant.bearings).join(", ");
    writeln!(out, "    /// Number of coordinates: {coordinates}.\n    pub const COORDINATES: usize = {n};")?;
    let matrices = [
        ("MASS", "the mass matrix M", &scales.mass),
        ("DAMPING", "the damping matrix B", &scales.damping),
        ("GYROSCOPIC", "the gyroscopic matrix G, to be multiplied by the speed", &scales.gyroscopic),
        ("STIFFNESS", "the stiffness matrix K without the bearings", &scales.stiffness),
    ];
    for (name, what, matrix) in matrices {
        let columns: Vec<Vec<f64>> = matrix.column_iter().map(|c| c.iter().copied().collect()).collect();
        writeln!(out, "    /// Columns of {what}, SI units.\n    #[rustfmt::skip]")?;
        writeln!(out, "    pub static {name}: [[f64; {n}]; {n}] = {};", matrix_text(&columns))?;
    }
    writeln!(out, "    /// Weight and constant load on each coordinate, N or N m.\n    #[rustfmt::skip]")?;
    writeln!(out, "    pub static LOAD: [f64; {n}] = {:?};", scales.load)?;
    writeln!(
        out,
        "    /// Unbalance on each coordinate, kg m: factors of the cosine and of the sine of the shaft angle."
    )?;
    writeln!(
        out,
        "    #[rustfmt::skip]\n    pub static UNBALANCE: [[f64; 2]; {n}] = {};",
        matrix_text(&scales.unbalance)
    )?;
    let names: Vec<&str> = plant.bearings.iter().map(|bearing| bearing.name.as_str()).collect();
    writeln!(
        out,
        "    /// Rows `u v w thu thv` of each bearing's displacement per unit of each coordinate: {}.",
        names.join(", ")
    )?;
    let attachments: Vec<String> =
        (0..count).filter_map(|i| plant.layout.attached(i)).map(|rows| matrix_text(rows)).collect();
    writeln!(out, "    #[rustfmt::skip]")?;
    writeln!(out, "    pub static ATTACHMENTS: [[[f64; {n}]; 5]; {count}] = [{}];\n", attachments.join(", "))?;
    writeln!(
        out,
        "    /// Returns the matrices.\n    #[must_use]\n    pub fn matrices() -> SystemMatrices<{n}> {{\n        SystemMatrices {{\n            \
         mass: MASS.into(),\n            damping: DAMPING.into(),\n            gyroscopic: GYROSCOPIC.into(),\n            \
         stiffness: STIFFNESS.into(),\n            load: LOAD,\n            unbalance: UNBALANCE,\n        }}\n    }}\n"
    )?;
    writeln!(
        out,
        "    /// Returns the rotor, with set-up arithmetic in `f64`.\n    ///\n    /// # Errors\n    /// None with these matrices.\n    \
         pub fn rotor() -> Result<LinearSystem<f32, Exact, {n}>, InvalidMatrix> {{\n        LinearSystem::try_new(&matrices())\n    }}\n"
    )?;
    writeln!(
        out,
        "    /// Returns the attachment of each bearing.\n    #[must_use]\n    pub fn attachments() -> [Attachment<f32, {n}>; {count}] {{\n        \
         ATTACHMENTS.each_ref().map(Attachment::new)\n    }}\n}}"
    )?;
    Ok(())
}
