//! Time of a million forces in Rust, against which `measure.py` holds the Python package.

use ballrace::{BearingKinematicState, Phase, Status};
use ballrace_twin::force::{BearingForce, MathBackend, Precision};
use ballrace_twin::scene::build::{pick, rotation_at};
use ballrace_twin::scene::read::read_file;
use std::path::Path;
use std::time::Instant;

/// Number of displacements.
const COUNT: usize = 1_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = read_file(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../runner/demo/healthy.toml"))?;
    let bearing = pick(&scene, Some("DE"))?;
    let force = BearingForce::try_new(&scene, bearing, bearing.model, (Precision::F64, MathBackend::Exact))?;
    // The same displacements and angles as those of measure.py.
    let displacements: Vec<[f64; 5]> = (0..COUNT)
        .map(|i| {
            let turn = 0.01 * i as f64;
            [1e-5 * turn.cos(), 1e-5 * turn.sin() - 1e-5, 0.0, 0.0, 0.0]
        })
        .collect();
    let start = rotation_at(&scene, bearing, 0.0)?;
    let at = |i: usize| BearingKinematicState { cage: Phase::from_radians(0.004 * i as f64), ..start };
    let (mut forces, mut status) = (vec![[0.0; 5]; COUNT], vec![Status::OK; COUNT]);
    let mut seconds = f64::INFINITY;
    for _ in 0..7 {
        let begin = Instant::now();
        force.evaluate(&displacements, &at, &mut forces, &mut status);
        seconds = seconds.min(begin.elapsed().as_secs_f64());
    }
    println!("{seconds:.6} {:.17e}", forces.iter().map(|force| force[1]).sum::<f64>());
    Ok(())
}
