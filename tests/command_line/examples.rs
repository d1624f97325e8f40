//! The help of each command: examples that run as they stand, exit codes, and only options that the command has.

use crate::support::{DEMO_SCENE, DIAGNOSED, Sandbox, program, put_trial, short_recording};
use std::process::{Command, Stdio};

/// Commands of the program without `help`, by the list of its help.
fn commands() -> Vec<String> {
    let help = Sandbox::empty().done(&["--help"]).out;
    let list = help.split_once("Commands:").unwrap().1.split_once("Options:").unwrap().0.to_owned();
    let names = list.lines().filter_map(|line| line.split_whitespace().next().map(str::to_owned));
    names.filter(|name| name != "help").collect()
}

fn examples(help: &str) -> Vec<String> {
    let (_, after) = help.split_once("Examples:\n").unwrap_or_else(|| panic!("no examples: {help}"));
    let lines = after.lines().take_while(|line| !line.is_empty());
    lines.map(|line| line.trim().to_owned()).collect()
}

#[test]
fn examples_of_every_help_run() {
    let sandbox = Sandbox::empty();
    // Long enough to be diagnosed.
    let recording = short_recording(DIAGNOSED);
    for (name, content) in [
        ("machine.toml", DEMO_SCENE),
        ("healthy.csv", &recording),
        ("today.csv", &recording),
        ("u.csv", "u,v,w,thu,thv\n0,-15e-6,0,0,0\n"),
        ("vectors.csv", include_str!("../../docs/src/vectors.csv")),
        ("machines.csv", "machine,scene\npump,machine.toml\n"),
    ] {
        sandbox.put(name, content);
    }
    put_trial(&sandbox);
    let mut of_all = examples(&sandbox.done(&["--help"]).out);
    for name in commands() {
        let help = sandbox.done(&[&name, "--help"]).out;
        let own = examples(&help);
        let is_own = |line: &String| line.starts_with(&format!("ballrace {name}"));
        assert!(!own.is_empty() && own.iter().all(is_own), "{name}: {own:?}");
        assert!(help.contains("Exit codes:\n  0    done\n"), "{name}: {help}");
        // A monitor needs a terminal and does not end.
        let again = own.into_iter().filter(|line| !line.starts_with("ballrace watch") && !of_all.contains(line));
        of_all.extend(again.collect::<Vec<_>>());
    }
    let folder = program().parent().unwrap();
    let path = std::env::join_paths(
        std::iter::once(folder.to_owned()).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    );
    // `verify` reads what `bake` has written, `--baseline` what `--learn` has: the order of the help.
    for line in of_all {
        let mut shell = Command::new("sh");
        shell
            .args(["-c", &line])
            .current_dir(sandbox.path(""))
            .env("PATH", path.as_ref().unwrap())
            .stdin(Stdio::null());
        let output = shell.output().unwrap();
        assert!(output.status.success(), "{line}: {output:?}");
    }
}

/// The help has the exit codes of the guide.
#[test]
fn exit_codes_are_in_the_help() {
    let help = Sandbox::empty().done(&["replay", "--help"]).out;
    for code in ["  1    ", "  2    ", "  3    a limit", "  4    the recording is not plausible", "  130  "] {
        assert!(help.contains(code), "{code:?}: {help}");
    }
}

/// An option that does nothing in a command is not offered by it.
#[test]
fn the_error_of_force_is_offered_only_where_it_counts() {
    let sandbox = Sandbox::empty();
    for name in commands() {
        let counts = ["check", "verify", "fit", "fmu", "balance", "new", "scenes", "schema", "completions", "man"]
            .iter()
            .all(|other| *other != name);
        let help = sandbox.done(&[&name, "--help"]).out;
        assert_eq!(help.contains("--error <E>"), counts, "{name}: {help}");
        if !counts {
            let run = sandbox.run(&[&name, "--error", "1%"]);
            assert!(run.code == Some(2) && run.err.contains("unexpected argument '--error'"), "{name}: {run:?}");
        }
    }
}

/// `replay --help` lists the options of live operation apart from those of a recording.
#[test]
fn options_of_live_operation_stand_apart() {
    let help = Sandbox::empty().done(&["replay", "--help"]).out;
    let (own, live) = help.split_once("\nLive operation, only with --paced:\n").unwrap();
    for option in ["--learn", "--baseline", "--paced", "--error", "--format"] {
        assert!(own.contains(&format!("{option} <")) || own.contains(&format!("{option}\n")), "{option}: {own}");
    }
    for option in ["--source", "--events", "--http", "--realtime", "--core", "--state", "--for"] {
        assert!(live.contains(option) && !own.contains(&format!("      {option} ")), "{option}: {help}");
    }
}
