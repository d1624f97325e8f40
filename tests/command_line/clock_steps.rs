//! The clock of the computer is set forward and back while a monitor runs.

use crate::frames_source::{RATE, Rig, connected, plateau, port, signal};
use crate::support::{Sandbox, number};
use serde_json::Value;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The library that gives a program a clock of its own.
pub fn clock_library() -> Option<PathBuf> {
    let folders = std::fs::read_dir("/usr/lib").ok()?.map_while(Result::ok);
    folders.map(|folder| folder.path().join("faketime/libfaketime.so.1")).find(|path| path.exists())
}

/// The JSON that a live page answers.
pub fn get(port: u16, path: &str) -> Value {
    let mut stream = connected(port);
    write!(stream, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    assert!(head.starts_with("HTTP/1.1 200"), "{head}");
    serde_json::from_str(body).unwrap()
}

/// Gives a program the clock of the file `clock` on the sandbox, such as `+1h`.
pub fn set_clock(command: &mut Command, sandbox: &Sandbox, library: &Path) {
    command.env("LD_PRELOAD", library).env("FAKETIME_TIMESTAMP_FILE", sandbox.path("clock"));
    // The monotonic clock and the times of files stay those of the computer.
    command.envs(
        ["FAKETIME_NO_CACHE", "FAKETIME_DONT_FAKE_MONOTONIC", "DONT_FAKE_MONOTONIC", "NO_FAKE_STAT"]
            .map(|name| (name, "1")),
    );
}

/// An hour forward and three hours back: no second and no event is lost or written twice, their times follow the samples, and page
/// and indicators go on. The time of day of an event is that of the clock when it was written.
#[test]
fn a_clock_that_is_set_loses_nothing() {
    const FILES: [&str; 8] =
        ["--state", "state", "--events", "events.jsonl", "--indicators", "trend", "--indicators-file-length", "2 s"];
    let Some(library) = clock_library() else {
        println!("omitted: no library for another clock here; type: sudo apt-get install faketime");
        return;
    };
    let page = port();
    let address = format!("127.0.0.1:{page}");
    let rig = Rig::new(&[&FILES[..], &["--http", &address]].concat());
    rig.sandbox.put("clock", "+0");
    let mut command = rig.command();
    set_clock(&mut command, &rig.sandbox, &library);
    let child = command.spawn().unwrap();
    let mut steps = [(4, "+1h"), (8, "-2h")].into_iter().peekable();
    rig.feed(u64::MAX, |rig| {
        if let Some((_, offset)) = steps.next_if(|(second, _)| rig.acknowledged() >= second * RATE) {
            let history = get(page, "/history?hours=1");
            assert_eq!(history.as_array().map(Vec::len), Some(5), "{history}");
            rig.sandbox.put("clock", offset);
        }
        rig.acknowledged() >= 12 * RATE
    });
    let history = get(page, "/history?hours=1");
    assert_eq!(history.as_array().map(Vec::len), Some(5), "{history}");
    signal(&child, "TERM");
    let output = child.wait_with_output().unwrap();
    assert!(matches!(output.status.code(), Some(0 | 3)), "{output:?}");
    let outcome: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(number(&outcome, "/timing/outputs/seconds_not_written"), 0.0);
    assert_eq!(number(&outcome, "/timing/outputs/events_not_written"), 0.0);
    let times: Vec<f64> = rig.seconds("trend").into_iter().map(|(time, _)| time).collect();
    assert!(times.len() >= 12);
    assert_eq!(times, (1..=times.len()).map(|i| i as f64).collect::<Vec<_>>());
    // Each plateau is in the log once.
    let starts = rig.limit_events("events.jsonl").into_iter();
    let starts = starts.filter(|(kind, probe, _)| kind == "limit-crossed" && probe == "NDE_X_um");
    let starts: Vec<f64> = starts.map(|(_, _, start)| start).collect();
    let expected = (0..).map(|number| plateau(number).start as f64 / RATE as f64);
    // A block has 16 turns, 0.32 s.
    let is_once = starts.iter().zip(expected).all(|(start, at)| (at - 0.34..at + 0.01).contains(start));
    assert!(starts.len() >= 2 && is_once, "{starts:?}");
    let events: Vec<Value> =
        rig.sandbox.read("events.jsonl").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let kinds: Vec<&str> = events.iter().map(|event| event["kind"].as_str().unwrap()).collect();
    // On a busy machine the source waits for acknowledgements, and is silent meanwhile.
    assert!(!kinds.contains(&"samples-skipped"), "{kinds:?}");
    let of_day = |event: &Value| humantime::parse_rfc3339(event["at"].as_str().unwrap()).unwrap();
    let hours = |a: &Value, b: &Value| match of_day(b).duration_since(of_day(a)) {
        Ok(later) => later.as_secs_f64() / 3600.0,
        Err(earlier) => -earlier.duration().as_secs_f64() / 3600.0,
    };
    let steps: Vec<f64> =
        events.windows(2).map(|pair| hours(&pair[0], &pair[1]).round()).filter(|h| *h != 0.0).collect();
    assert_eq!(steps, [1.0, -3.0]);
}
