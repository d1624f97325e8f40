//! `watch` in a pseudo-terminal: keys, signals, and a terminal that goes away.
#![cfg(unix)]

use crate::live::{connected, endless, kinds, port, rows};
use crate::live_start::{ended, terminate, wait_for_event};
use crate::support::{DEMO_SCENE, Sandbox, program, short_recording};
use pty_process::blocking::{Command, Pty, open};
use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::process::Child;
use std::time::{Duration, Instant};

/// Longest time in which a text appears.
const PATIENCE: Duration = Duration::from_secs(120);

/// A pseudo-terminal and what is shown in it.
pub struct Screen {
    pty: Pty,
    parser: vt100::Parser,
}

impl Screen {
    /// Starts `command` in a terminal of `columns` and `rows`.
    pub fn start(columns: u16, rows: u16, command: Command) -> (Self, Child) {
        let (pty, terminal) = open().unwrap();
        pty.resize(pty_process::Size::new(rows, columns)).unwrap();
        let child = command.env("TERM", "xterm-256color").spawn(terminal).unwrap();
        // A terminal of any size is looked at in part.
        let [rows, columns] = [rows.min(200), columns.min(500)].map(|size| NonZeroU16::new(size).unwrap());
        let parser = vt100::Parser::new(rows, columns, 0);
        (Self { pty, parser }, child)
    }

    /// Reads what the program shows until `text` is on the screen.
    pub fn wait_for(&mut self, text: &str) {
        let (since, mut buffer) = (Instant::now(), [0; 4096]);
        while !self.parser.screen().contents().contains(text) {
            let shown = || self.parser.screen().contents();
            assert!(since.elapsed() < PATIENCE, "no {text} within {PATIENCE:?}:\n{}", shown());
            let read = { &self.pty }.read(&mut buffer).unwrap_or_else(|error| panic!("{error}:\n{}", shown()));
            self.parser.process(&buffer[..read]);
        }
    }

    /// Presses a key, and reads on so that the program can write its last.
    pub fn press(mut self, key: &[u8]) {
        self.pty.write_all(key).unwrap();
        self.ignore();
    }

    /// Reads what is still shown.
    pub fn ignore(mut self) {
        std::thread::spawn(move || self.pty.read_to_end(&mut vec![]));
    }
}

/// A monitor in a pseudo-terminal, followed until it shows a source, and its state and events.
fn watched(sandbox: &Sandbox, port: u16) -> (Screen, Child) {
    let source_at = format!("tcp:{port}");
    let args = ["watch", "scene.toml", "--source", &source_at, "--encoding", "frames"];
    let outputs = ["--state", "state", "--events", "events.jsonl", "--report", "report.html"];
    Screen::start(80, 24, Command::new(program()).args(args).args(outputs).current_dir(sandbox.path("")))
}

/// Shows a monitor that has read samples, and ends it by `end`.
fn ends(end: impl FnOnce(Screen, u32)) -> Sandbox {
    let (sandbox, port) = (Sandbox::with(DEMO_SCENE, &short_recording(12_800)), port());
    let (mut screen, child) = watched(&sandbox, port);
    screen.wait_for("NO DATA");
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    let mut stream = connected(port);
    (0..9_600).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    wait_for_event(&sandbox, "events.jsonl", "source-silent");
    let id = child.id();
    end(screen, id);
    let output = ended(child);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert_eq!(kinds(&sandbox, "events.jsonl"), ["source-connected", "source-silent"]);
    assert!(sandbox.read("state/state.json").contains("resume"));
    assert!(sandbox.read("report.html").contains("</html>"));
    sandbox
}

#[test]
fn a_terminal_that_goes_away_ends_the_monitor() {
    ends(|screen, _| drop(screen));
}

#[test]
fn a_signal_ends_the_view() {
    ends(|screen, id| {
        terminate(id);
        screen.ignore();
    });
}

#[test]
fn a_key_ends_the_view() {
    ends(|screen, _| screen.press(b"q"));
}

/// The display of the demonstration, without a scene.
fn demonstration(columns: u16, rows: u16) -> (Screen, Child) {
    Screen::start(columns, rows, Command::new(program()).arg("watch"))
}

/// The demonstration goes on after its recording of one second would have ended, and finds its fault.
#[test]
fn the_demonstration_has_no_end() {
    let (mut screen, mut child) = demonstration(120, 36);
    for text in ["twin started", "ALARM", "Spall on the outer race"] {
        screen.wait_for(text);
    }
    assert!(child.try_wait().unwrap().is_none());
    drop(screen);
    let output = ended(child);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

/// The memory of the display does not grow with the size that a terminal states.
#[test]
fn the_largest_terminal_is_drawn_in_part() {
    let (mut screen, child) = demonstration(u16::MAX, u16::MAX);
    // In the title from then on, whatever the state is.
    screen.wait_for("twin started");
    drop(screen);
    let output = ended(child);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[test]
fn a_small_terminal_shows_the_least_size() {
    let (mut screen, child) = demonstration(40, 10);
    screen.wait_for("60 x 22");
    drop(screen);
    ended(child);
}
