//! Outputs that cannot be written, or should not be.

use std::fs;
use std::process::Stdio;

use crate::support::{DEMO_SCENE, SHORT, Sandbox, short_recording};

/// The options that name a file to write, each with its command.
const OUTPUTS: [(&[&str], &str); 4] = [
    (&["replay", "scene.toml"], "--report"),
    (&["replay", "scene.toml"], "--forces"),
    (&["simulate", "scene.toml", "--duration", "0.1 s", "--rate", "1 kHz"], "--output"),
    (&["fmu", "scene.toml"], "--output"),
];

#[test]
fn folder_that_is_missing() {
    for (command, option) in OUTPUTS {
        let args = [command, &[option, "nowhere/out.file"]].concat();
        Sandbox::rig().refused(&args, 1, &["nowhere/out.file: this file cannot be written"]);
    }
}

#[test]
fn path_of_a_folder() {
    for (command, option) in OUTPUTS {
        let sandbox = Sandbox::rig();
        fs::create_dir(sandbox.path("results")).unwrap();
        let args = [command, &[option, "results"]].concat();
        sandbox.refused(&args, 1, &["results: a folder, expected the name of a file to write"]);
    }
}

#[test]
fn file_that_is_read() {
    for (command, option) in OUTPUTS {
        let args = [command, &[option, "./scene.toml"]].concat();
        let sandbox = Sandbox::rig();
        sandbox.refused(&args, 2, &[option, "this command already reads or writes this file: ./scene.toml"]);
        assert_eq!(sandbox.read("scene.toml"), DEMO_SCENE);
    }
    for option in ["--report", "--forces"] {
        let sandbox = Sandbox::rig();
        sandbox.refused(
            &["replay", "scene.toml", option, "healthy.csv"],
            2,
            &[option, "this file: healthy.csv, expected another file"],
        );
        assert_eq!(sandbox.read("healthy.csv"), short_recording(SHORT));
    }
}

#[test]
fn two_outputs_in_one_file() {
    let args = ["replay", "scene.toml", "--report", "out", "--forces", "./out"];
    Sandbox::rig().refused(&args, 2, &["--forces: this command already reads or writes this file: ./out"]);
}

#[test]
fn file_from_before_stays_when_the_work_fails() {
    let sandbox = Sandbox::with(DEMO_SCENE, &(short_recording(600) + "0.1,0,0,0,oops,0,0\n"));
    for name in ["scene-report.html", "forces.csv"] {
        sandbox.put(name, "from before");
    }
    sandbox.refused(&["replay", "scene.toml", "--forces", "forces.csv"], 1, &["healthy.csv:602: column NDE_Y_um: "]);
    for name in ["scene-report.html", "forces.csv"] {
        assert_eq!(sandbox.read(name), "from before");
    }
}

#[test]
fn file_from_before_is_replaced() {
    let sandbox = Sandbox::rig();
    sandbox.put("report.html", "from before");
    sandbox.done(&["replay", "scene.toml", "--report", "report.html"]);
    assert!(sandbox.read("report.html").starts_with("<!DOCTYPE html>"));
}

/// `ballrace ... | head` where `head` has closed its input.
#[test]
fn closed_standard_output_is_no_error() {
    let sandbox = Sandbox::rig();
    sandbox.put("u.csv", format!("u,v,w,thu,thv\n{}", "0,0,6e-5,0,0\n".repeat(5000)));
    for args in [
        &["replay", "scene.toml"][..],
        &["replay", "scene.toml", "--format", "json"],
        &["force", "scene.toml", "--bearing", "DE", "--displacements", "u.csv", "--format", "csv"],
    ] {
        let mut child = sandbox.command(args).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{args:?}");
        assert_eq!(output.status.code(), Some(0), "{args:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn full_disk_behind_standard_output() {
    let sandbox = Sandbox::rig();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let child = sandbox.command(&["replay", "scene.toml"]).stdout(Stdio::from(full)).spawn().unwrap();
    let output = child.wait_with_output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert!(err.starts_with("ballrace: ") && err.lines().count() == 1, "{err}");
    assert_eq!(output.status.code(), Some(1));
}

/// A link is followed: its target is replaced, the link stays.
#[cfg(unix)]
#[test]
fn output_follows_a_symbolic_link() {
    let sandbox = Sandbox::rig();
    sandbox.put("real.html", "old");
    std::os::unix::fs::symlink(sandbox.path("real.html"), sandbox.path("link.html")).unwrap();
    sandbox.done(&["replay", "scene.toml", "--report", "link.html"]);
    assert!(sandbox.path("link.html").is_symlink());
    assert!(sandbox.read("real.html").contains("<html"));
}

/// A link to a file that does not exist yet: the file is created, the link stays.
#[cfg(unix)]
#[test]
fn a_link_to_a_new_file_stays_a_link() {
    let sandbox = Sandbox::rig();
    fs::create_dir(sandbox.path("reports")).unwrap();
    std::os::unix::fs::symlink("reports/new.html", sandbox.path("link.html")).unwrap();
    sandbox.done(&["replay", "scene.toml", "--report", "link.html"]);
    assert!(sandbox.path("link.html").is_symlink());
    assert!(sandbox.read("reports/new.html").contains("<html"));
}

/// Output goes through a named pipe, which is not replaced by a file.
#[cfg(unix)]
#[test]
fn output_to_a_named_pipe_keeps_the_pipe() {
    let sandbox = Sandbox::rig();
    let made = std::process::Command::new("mkfifo").arg(sandbox.path("pipe")).status();
    if !made.is_ok_and(|status| status.success()) {
        return println!("skipped: no mkfifo here");
    }
    let path = sandbox.path("pipe");
    let reader = std::thread::spawn(move || std::fs::read_to_string(path).unwrap());
    sandbox.done(&["replay", "scene.toml", "--forces", "pipe"]);
    assert!(reader.join().unwrap().starts_with("time_s,DE_FX"));
    assert!(!sandbox.path("pipe").is_file());
}
