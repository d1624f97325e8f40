//! Ends of the help texts: examples, which a test runs, and exit codes.

/// Joins examples and the exit codes that a command has beside the common ones.
macro_rules! after_help {
    ($examples:literal) => {
        after_help!($examples, "")
    };
    ($examples:literal, $codes:literal) => {
        concat!(
            "Examples:\n",
            $examples,
            "\n\nExit codes:\n  0    done\n  1    the work could not be done\n  2    the command line or the scene is wrong\n",
            $codes,
            "  130  interrupted by a signal"
        )
    };
}

pub(super) const PROGRAM: &str = after_help!(
    "  ballrace replay
  ballrace check machine.toml
  ballrace replay machine.toml --recording today.csv --report today.html
  ballrace help replay > replay.txt",
    "  3    a limit of the scene was exceeded
  4    the recording is not plausible for the scene, or is no baseline
"
);
pub(super) const REPLAY: &str = after_help!(
    "  ballrace replay
  ballrace replay machine.toml --learn baseline.json
  ballrace replay machine.toml --recording today.csv --baseline baseline.json --format json > today.json",
    "  3    a limit of the scene was exceeded
  4    the recording is not plausible for the scene, or --learn refuses it
"
);
pub(super) const WATCH: &str = after_help!(
    "  ballrace watch
  ballrace watch machine.toml --source tcp:7000 --events events.jsonl",
    "  3    a limit of the scene was exceeded
  4    the samples are not plausible for the scene
"
);
pub(super) const FORCE: &str = after_help!(
    "  ballrace force machine.toml --bearing DE --displacements u.csv
  ballrace force machine.toml --bearing DE --displacements u.csv --model quasi-static --format csv > forces.csv"
);
pub(super) const BAKE: &str = after_help!(
    "  ballrace bake machine.toml -o bearings.rs
  ballrace bake machine.toml -o bearings.h"
);
pub(super) const VERIFY: &str = after_help!(
    "  ballrace verify bearings.rs
  ballrace verify bearings.h --scene machine.toml"
);
pub(super) const EQUILIBRIUM: &str = after_help!(
    "  ballrace equilibrium machine.toml
  ballrace equilibrium machine.toml --bearing DE --load 0,-500,100,0,0 --report load.html"
);
pub(super) const SIMULATE: &str = after_help!(
    "  ballrace simulate machine.toml --duration \"0.1 s\" --rate \"12.8 kHz\" -o motion.csv
  ballrace simulate machine.toml --duration \"0.1 s\" --settle \"0.1 s\" --as-recording -o readings.csv"
);
pub(super) const FMU: &str = after_help!(
    "  ballrace fmu machine.toml -o rotor.fmu
  ballrace fmu machine.toml --bearing DE -o bearing.fmu"
);
pub(super) const CAMPBELL: &str = after_help!(
    "  ballrace campbell machine.toml
  ballrace campbell machine.toml --speeds 0rpm..6000rpm:1000rpm --report campbell.html"
);
pub(super) const SWEEP: &str = after_help!(
    "  ballrace sweep machine.toml --over shaft.speed=2000rpm..3000rpm:2 --settle \"0.1 s\" --periods 16 -o sweep"
);
pub(super) const FIT: &str = after_help!(
    "  ballrace fit machine.toml --turns 2 --only clearance
  ballrace fit machine.toml --turns 2 --only unbalance -o balanced.toml --report fit.html"
);
pub(super) const BALANCE: &str = after_help!(
    "  ballrace balance machine.toml --run before.csv --trial \"trial.csv: 20 mm 60 g mm at 90 deg\" --grade G2.5
  ballrace balance machine.toml --run before.csv --report balance.html
  ballrace balance --vectors vectors.csv -o masses.csv
  ballrace balance --vectors vectors.csv --holes 16 --radius \"30 mm\" --stock \"2 g,4 g,8 g,16 g\""
);
pub(super) const FLEET: &str = after_help!(
    "  ballrace fleet machines.csv -o fleet
  ballrace fleet machines.csv -o fleet --jobs 1 --no-report",
    "  3    a limit of a scene was exceeded
"
);
pub(super) const TRADE: &str = after_help!("  ballrace trade machine.toml --error 0.1% --forces-only");
pub(super) const CHECK: &str = after_help!(
    "  ballrace check machine.toml
  ballrace check machine.toml --recording today.csv --svg machine.svg",
    "  4    the recording is not plausible for the scene
"
);
pub(super) const NEW: &str = after_help!(
    "  ballrace new --list
  ballrace new --bearing 6205 --bearing 6205 --recording today.csv --speed \"3000 rpm\" -o draft.toml"
);
pub(super) const SCENES: &str = after_help!(
    "  ballrace scenes
  ballrace scenes jones-1960 > jones.toml"
);
pub(super) const SCHEMA: &str = after_help!("  ballrace schema > scene.schema.json");
pub(super) const COMPLETIONS: &str = after_help!("  ballrace completions bash > ballrace");
pub(super) const MAN: &str = after_help!(
    "  ballrace man > ballrace.1
  ballrace man replay > ballrace-replay.1"
);
