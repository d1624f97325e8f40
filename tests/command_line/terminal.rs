//! `watch` in a pseudo-terminal: keys, signals, and a terminal that goes away.
#![cfg(unix)]

use crate::live::{connected, endless, kinds, port, rows};
use crate::live_start::{ended, terminate, wait_for_event};
use crate::support::{DEMO_SCENE, Desk, program, short_recording};
use pty_process::blocking::{Command, Pty, open};
use std::io::{Read, Write};
use std::process::Child;
use std::time::Duration;

/// Longest time from the end of the terminal to the end of the program.
const WITHIN: Duration = Duration::from_secs(1);

/// A monitor in a pseudo-terminal, followed until it shows a source, and its state and events.
fn watched(desk: &Desk, port: u16) -> (Pty, Child) {
    let (pty, terminal) = open().unwrap();
    pty.resize(pty_process::Size::new(24, 80)).unwrap();
    let source_at = format!("tcp:{port}");
    let args = ["watch", "scene.toml", "--source", &source_at, "--encoding", "frames"];
    let outputs = ["--state", "state", "--events", "events.jsonl", "--report", "report.html"];
    let command = Command::new(program()).args(args).args(outputs).env("TERM", "xterm").current_dir(desk.path(""));
    (pty, command.spawn(terminal).unwrap())
}

/// Reads what the program shows until it has shown `text`.
pub fn read_until(pty: &Pty, text: &str) {
    let (mut shown, mut buffer) = (Vec::new(), [0; 4096]);
    while !String::from_utf8_lossy(&shown).contains(text) {
        let read = { pty }.read(&mut buffer).unwrap();
        shown.extend_from_slice(&buffer[..read]);
    }
}

/// Shows a monitor that has read samples, and ends it by `end`.
fn ends(end: impl FnOnce(Pty, u32)) -> Desk {
    let (desk, port) = (Desk::with(DEMO_SCENE, &short_recording(12_800)), port());
    let (pty, child) = watched(&desk, port);
    read_until(&pty, "NO DATA");
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    let mut stream = connected(port);
    (0..9_600).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    wait_for_event(&desk, "events.jsonl", "source-silent");
    let id = child.id();
    end(pty, id);
    let output = ended(child, WITHIN);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert_eq!(kinds(&desk, "events.jsonl"), ["source-connected", "source-silent"]);
    assert!(desk.read("state/state.json").contains("resume"));
    assert!(desk.read("report.html").contains("</html>"));
    desk
}

#[test]
fn a_terminal_that_goes_away_ends_the_monitor() {
    ends(|pty, _| drop(pty));
}

#[test]
fn a_signal_ends_the_view() {
    ends(|pty, id| {
        terminate(id);
        // Its output at the end is read.
        std::thread::spawn(move || { &pty }.read_to_end(&mut vec![]));
    });
}

#[test]
fn a_key_ends_the_view() {
    ends(|pty, _| {
        { &pty }.write_all(b"q").unwrap();
        std::thread::spawn(move || { &pty }.read_to_end(&mut vec![]));
    });
}

/// The display of the demonstration, without a scene.
fn demonstration(columns: u16, rows: u16) -> (Pty, Child) {
    let (pty, terminal) = open().unwrap();
    pty.resize(pty_process::Size::new(rows, columns)).unwrap();
    let child = Command::new(program()).arg("watch").env("TERM", "xterm").spawn(terminal).unwrap();
    (pty, child)
}

/// The demonstration goes on after its recording of one second would have ended, and finds its fault.
#[test]
fn the_demonstration_has_no_end() {
    let (pty, mut child) = demonstration(120, 36);
    // Only changed cells are sent, so that a space between two words may be missing.
    for text in ["STARTING", "ALARM", "Spall"] {
        read_until(&pty, text);
    }
    assert!(child.try_wait().unwrap().is_none());
    drop(pty);
    let output = ended(child, WITHIN);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[test]
fn a_small_terminal_shows_the_least_size() {
    let (pty, child) = demonstration(40, 10);
    read_until(&pty, "22");
    drop(pty);
    ended(child, WITHIN);
}
