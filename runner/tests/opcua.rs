//! The monitor as an OPC UA server, read by the client of asyncua. `tests/run opcua` installs it.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use serde_json::Value;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};

const SCENE: &str = include_str!("../demo/healthy.toml");
const RECORDING: &str = include_str!("../../tests/recordings/healthy.csv");

/// A process that is killed at the end of a test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Rows of `seconds` of the demonstration's motion, whose second is a whole number of revolutions.
fn rows(seconds: usize) -> String {
    let (_, one) = RECORDING.split_once('\n').unwrap();
    one.repeat(seconds)
}

#[test]
fn a_client_reads_and_subscribes_and_cannot_write() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let mut command = Command::new(env!("CARGO_BIN_EXE_ballrace"));
    command.args(["replay", "scene.toml", "--paced", "--source", "-", "--format", "json", "--no-report"]);
    command.args(["--events", "events.jsonl", "--opcua", &format!("127.0.0.1:{port}")]);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).current_dir(folder.path());
    let mut monitor = Process(command.spawn().unwrap());
    let mut input = monitor.0.stdin.take().unwrap();
    let mut text = String::new();
    writeln!(text, "{}", RECORDING.lines().next().unwrap()).unwrap();
    input.write_all((text + &rows(3)).as_bytes()).unwrap();

    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut python = Command::new(root.join("../target/python/bin/python"));
    python.arg(root.join("tests/opcua.py")).arg(port.to_string()).stdout(Stdio::piped());
    let mut client = Process(python.spawn().unwrap_or_else(|e| panic!("python: {e}; type: tests/run opcua")));
    let mut out = BufReader::new(client.0.stdout.take().unwrap());
    let mut line = String::new();
    out.read_line(&mut line).unwrap();
    assert_eq!(line, "subscribed\n");
    input.write_all(rows(4).as_bytes()).unwrap();
    let mut answer = String::new();
    out.read_to_string(&mut answer).unwrap();
    let seen: Value = serde_json::from_str(&answer).unwrap_or_else(|e| panic!("{e}: {answer}"));
    let seconds: Vec<f64> = seen["seconds"].as_array().unwrap().iter().map(|s| s.as_f64().unwrap()).collect();
    assert!(seconds.windows(2).all(|pair| pair[1] > pair[0]), "{seen}");
    assert_eq!(seen["written"], "BadUserAccessDenied", "{seen}");
    for name in ["speed_rpm", "DE_X_um_residual_rms_um", "DE_FX_N", "event"] {
        assert!(seen["names"].as_array().unwrap().iter().any(|one| one == name), "{name}: {seen}");
    }
    drop(input);
    let mut outcome = String::new();
    monitor.0.stdout.take().unwrap().read_to_string(&mut outcome).unwrap();
    let outcome: Value = serde_json::from_str(&outcome).unwrap();
    // The value of a second is about that of the recording.
    let rms = outcome["probes"][0]["measured"]["rms_um"].as_f64().unwrap();
    assert!((seen["rms"].as_f64().unwrap() / rms - 1.0).abs() < 0.05, "{seen} {rms}");
    let now = humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string();
    assert_eq!(seen["at"].as_str().unwrap()[..10], now[..10]);
    let events = std::fs::read_to_string(folder.path().join("events.jsonl")).unwrap();
    let event = seen["event"].as_str().unwrap();
    assert!(event.is_empty() || events.lines().any(|line| line == event), "{event}");
}

#[test]
fn an_address_in_use_is_an_error() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let output = Command::new(env!("CARGO_BIN_EXE_ballrace"))
        .args(["replay", "--paced", "--no-report", "--opcua", &address])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && text.contains(&format!("--opcua: cannot listen on {address}")), "{text}");
}
