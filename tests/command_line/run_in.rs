//! A rotor with so little damping that the transient of its twin is long: the monitor does not wait for its end.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Instant;

use serde_json::Value;

use crate::live::{connected, kinds, listening, port};
use crate::live_start::{PROMPT, ended, terminate, wait, wait_for_event};
use crate::support::{DEMO_SCENE, HEALTHY_RECORDING, Sandbox, list, number, short_recording, swap};

/// The demonstration with a damping under which the transient of the twin takes 10 s of the recording's time, and a limit.
fn lightly_damped(step: &str) -> String {
    let damping = "damping = [\"400 N s/m\", \"400 N s/m\", \"400 N s/m\", \"0.4 N m s/rad\", \"0.4 N m s/rad\"]";
    let scene = swap(DEMO_SCENE, damping, "damping = [4, 4, 4, 0.004, 0.004]");
    let scene = swap(&scene, "rate = \"12.8 kHz\"", "time = \"time_s\"");
    let limit = "\n[[limit]]\nindicator = \"peak-to-peak\"\nprobe = \"DE_X_um\"\nmax = \"0.1 um\"\n";
    format!("{scene}\n[integration]\nmethod = \"runge-kutta\"\nstep = \"{step}\"\n{limit}")
}

/// The demonstration's rows from a time on.
fn from(begin: f64, samples: usize) -> String {
    let row = |(i, row): (usize, &str)| {
        let rest = row.split_once(',').unwrap().1;
        format!("{:.9},{rest}\n", begin + i as f64 / 12_800.0)
    };
    HEALTHY_RECORDING.lines().skip(1).take(samples).enumerate().map(row).collect()
}

/// SIGTERM ends the program within a second or so, with a report.
fn ends_at_once(child: std::process::Child) -> Value {
    let since = Instant::now();
    terminate(child.id());
    let output = ended(child);
    let took = since.elapsed();
    println!("ended after {took:?}");
    assert!(took < PROMPT, "{took:?}");
    assert!(matches!(output.status.code(), Some(0 | 3)), "{output:?}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn begun(sandbox: &Sandbox, more: &[&str]) -> (std::process::Child, TcpStream) {
    let (child, port) = listening(sandbox, "tcp", &[&["--events", "events.jsonl"], more].concat());
    let mut stream = connected(port);
    stream.write_all((short_recording(0) + &from(0.0, 6_400)).as_bytes()).unwrap();
    (child, stream)
}

#[test]
fn limits_and_signals_do_not_wait_for_the_run_in() {
    let sandbox = Sandbox::with(&lightly_damped("4 us"), &short_recording(2048));
    let (child, stream) = begun(&sandbox, &[]);
    // The start takes ten times as long.
    wait_for_event(&sandbox, "events.jsonl", "limit-crossed");
    let outcome = ends_at_once(child);
    assert_eq!(list(&outcome, "events").len(), 1, "{outcome:#}");
    assert_eq!(number(&outcome, "/record/samples"), 6_400.0);
    let notes = outcome["notes"].to_string();
    assert!(notes.contains("Stopped before the twin was run in"), "{notes}");
    assert!(kinds(&sandbox, "events.jsonl").contains(&"limit-crossed".to_owned()));
    drop(stream);
}

/// The same after a gap, which restarts the twin.
#[test]
#[ignore = "slow: the twin settles five times before the gap; tests/run --all runs it"]
fn long_limits_and_signals_do_not_wait_for_the_run_in_after_a_gap() {
    let sandbox = Sandbox::with(&lightly_damped("20 us"), &short_recording(2048));
    let metrics = port();
    let (child, mut stream) = begun(&sandbox, &["--prometheus", &metrics.to_string()]);
    stream.write_all(from(0.5, 12_800).as_bytes()).unwrap();
    wait("the twin", || {
        let mut scrape = connected(metrics);
        scrape.write_all(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
        let mut page = String::new();
        scrape.read_to_string(&mut page).unwrap();
        page.contains("ballrace_bearing_FY_N{").then_some(())
    });
    let crossings = || kinds(&sandbox, "events.jsonl").iter().filter(|kind| kind.starts_with("limit-")).count();
    let before = crossings();
    // Still, then moving again: the crossing ends and begins again.
    let still = "0,0,0,0,0,0\n";
    let rest: String = (0..256).map(|i| format!("{:.9},{still}", 100.0 + f64::from(i) / 12_800.0)).collect();
    stream.write_all((rest + &from(100.02, 12_800)).as_bytes()).unwrap();
    let since = Instant::now();
    wait("a further limit event", || (crossings() > before).then_some(()));
    println!("reported {:?} after the gap", since.elapsed());
    let outcome = ends_at_once(child);
    let notes = outcome["notes"].to_string();
    assert!(notes.contains("Stopped before the twin was run in"), "{notes}");
    drop(stream);
}
