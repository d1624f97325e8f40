//! The monitor before its twin runs, and where it cannot run: limits, signals, standstill, gaps, implausible rates.

use crate::frames_source::signal;
use crate::live::{
    acknowledged, connected, endless, frame, kinds, listening, monitor, outcome, port, rows, sandbox, source,
};
use crate::support::{DEMO_SCENE, Sandbox, list, number, short_recording, swap};
use serde_json::Value;
use std::io::Write;
use std::process::{Child, Command, Output};
use std::time::{Duration, Instant};

/// Longest time that a test waits for a condition.
const PATIENCE: Duration = Duration::from_secs(300);

/// Time within which a monitor ends that does not compute on: a busy machine takes seconds.
pub const PROMPT: Duration = Duration::from_secs(15);

/// Repeats `get` until it returns something.
pub fn wait<T>(what: &str, mut get: impl FnMut() -> Option<T>) -> T {
    let since = Instant::now();
    loop {
        if let Some(found) = get() {
            return found;
        }
        assert!(since.elapsed() < PATIENCE, "{what}: not within {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Waits for an event of this kind in a log.
pub fn wait_for_event(sandbox: &Sandbox, log: &str, kind: &str) {
    let quoted = format!("\"kind\":\"{kind}\"");
    wait(kind, || std::fs::read_to_string(sandbox.path(log)).ok().filter(|text| text.contains(&quoted)).map(|_| ()));
}

/// Sends SIGTERM to a process.
pub fn terminate(id: u32) {
    assert!(Command::new("kill").args(["-TERM", &id.to_string()]).status().unwrap().success());
}

/// Waits for the end of a process, whose output is read meanwhile; kills it where it does not end.
pub fn ended(child: Child) -> Output {
    let (done, over) = std::sync::mpsc::channel::<()>();
    let id = child.id().to_string();
    let watchdog = std::thread::spawn(move || {
        let late = over.recv_timeout(PATIENCE) == Err(std::sync::mpsc::RecvTimeoutError::Timeout);
        if late {
            let _ = Command::new("kill").args(["-KILL", &id]).status();
        }
        late
    });
    let output = child.wait_with_output().unwrap();
    drop(done);
    assert!(!watchdog.join().unwrap(), "the program did not end within {PATIENCE:?}: {output:?}");
    output
}

/// The demonstration with a limit on peak-to-peak displacement.
fn limited(max: &str) -> Sandbox {
    let limit = format!("\n[[limit]]\nindicator = \"peak-to-peak\"\nprobe = \"DE_X_um\"\nmax = \"{max}\"\n");
    Sandbox::with(&(DEMO_SCENE.to_owned() + &limit), &short_recording(12_800))
}

/// The demonstration's rows with DE_X_um displaced in a range of samples.
fn displaced(range: std::ops::Range<u32>) -> impl Fn(u32) -> Vec<u8> {
    let rows = rows(12_800);
    move |sequence| {
        let mut row = rows[sequence as usize % rows.len()].clone();
        if range.contains(&sequence) {
            row[0] += 5.0;
        }
        frame(sequence, &row)
    }
}

#[test]
fn a_limit_is_reported_while_the_twin_is_started() {
    let sandbox = limited("0.1 um");
    let (child, port) =
        listening(&sandbox, "tcp", &["--encoding", "frames", "--state", "state", "--events", "events.jsonl"]);
    let frame_of = displaced(0..0);
    let mut stream = connected(port);
    let told = acknowledged(&stream);
    let since = Instant::now();
    (0..16_000).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    wait_for_event(&sandbox, "events.jsonl", "limit-crossed");
    let reported = since.elapsed();
    // A second is acknowledged when the twin has passed through it.
    told.recv_timeout(PATIENCE).unwrap();
    let started = since.elapsed();
    assert!(2 * reported < started, "reported after {reported:?}, twin started after {started:?}");
    terminate(child.id());
    outcome(child);
}

#[test]
fn a_signal_while_the_twin_is_started_loses_no_event() {
    let sandbox = limited("3 um");
    let (child, port) = listening(&sandbox, "tcp", &["--encoding", "frames", "--events", "events.jsonl"]);
    let frame_of = displaced(20_000..20_002);
    let mut stream = connected(port);
    (0..40_000).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    drop(stream);
    wait_for_event(&sandbox, "events.jsonl", "source-gone");
    let since = Instant::now();
    terminate(child.id());
    let outcome = outcome(child);
    println!("ended after {:?}", since.elapsed());
    assert_eq!(number(&outcome, "/record/samples"), 40_000.0);
    assert_eq!(number(&outcome, "/record/compared"), 40_000.0);
    let events = list(&outcome, "events");
    assert_eq!(events.len(), 1, "{events:#?}");
    let kinds = kinds(&sandbox, "events.jsonl");
    assert_eq!(kinds.iter().filter(|kind| kind.starts_with("limit-")).count(), 2, "{kinds:?}");
}

/// A twin slower than real time is far behind its source: the monitor ends long before the system would kill it.
#[test]
fn a_signal_ends_a_monitor_that_is_behind() {
    let limit = "\n[[limit]]\nindicator = \"peak-to-peak\"\nprobe = \"DE_X_um\"\nmax = \"3 um\"\n";
    let step = swap(DEMO_SCENE, "[recording]", "[integration]\nstep = \"0.5 us\"\n\n[recording]");
    let sandbox = Sandbox::with(&(step + limit), "");
    let (child, port) = listening(&sandbox, "tcp", &["--encoding", "frames", "--events", "events.jsonl"]);
    let count = 20 * 12_800;
    let frame_of = displaced(count - 20_000..count - 19_998);
    let mut stream = connected(port);
    (0..count).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    drop(stream);
    wait_for_event(&sandbox, "events.jsonl", "source-gone");
    let since = Instant::now();
    terminate(child.id());
    // It goes on for 20 s by the clock. To spare the processor it stands still for most of them.
    std::thread::sleep(Duration::from_secs(5));
    signal(&child, "STOP");
    std::thread::sleep(Duration::from_secs(13));
    signal(&child, "CONT");
    let outcome = outcome(child);
    println!("ended after {:?}", since.elapsed());
    assert!(since.elapsed() < Duration::from_secs(45));
    // Limits of readings do not wait for the twin.
    assert_eq!(number(&outcome, "/record/samples"), f64::from(count));
    assert_eq!(list(&outcome, "events").len(), 1);
    let (compared, notes) = (number(&outcome, "/record/compared"), outcome["notes"].to_string());
    assert!(compared > 0.0 && compared < f64::from(count) - 12_800.0, "{compared}");
    assert!(notes.contains("Stopped before the twin had processed the last"), "{notes}");
}

/// The indicators of a second from readings are shown before the twin has passed through it.
#[test]
fn metrics_are_shown_while_the_twin_is_started() {
    let (sandbox, port, at) = (sandbox(), port(), port());
    let (source_at, at) = (format!("tcp:{port}"), at.to_string());
    let args = ["--source", &source_at, "--encoding", "frames", "--state", "state", "--prometheus", &at];
    let mut child = monitor(&sandbox, &args);
    let frame_of = displaced(0..0);
    let mut stream = connected(port);
    let told = acknowledged(&stream);
    let since = Instant::now();
    (0..16_000).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    wait("a second's indicators", || {
        use std::io::Read;
        let mut scrape = connected(at.parse().unwrap());
        scrape.write_all(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
        let mut page = String::new();
        scrape.read_to_string(&mut page).unwrap();
        page.contains("ballrace_probe_peak_to_peak_um{probe=\"DE_X_um\"}").then_some(())
    });
    let shown = since.elapsed();
    told.recv_timeout(PATIENCE).unwrap();
    let started = since.elapsed();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(2 * shown < started, "shown after {shown:?}, twin started after {started:?}");
}

#[test]
fn stopped_at_standstill_it_reports_what_was_measured() {
    let sandbox = sandbox();
    let (child, port) =
        listening(&sandbox, "tcp", &["--encoding", "frames", "--events", "events.jsonl", "--report", "r.html"]);
    let rows = rows(12_800);
    let mut stream = connected(port);
    let turning = endless(&rows);
    (0..12_800).for_each(|sequence| stream.write_all(&turning(sequence)).unwrap());
    let mut still = rows[10].clone();
    still[5] = 0.0;
    (12_800..25_600).for_each(|sequence| stream.write_all(&frame(sequence, &still)).unwrap());
    wait_for_event(&sandbox, "events.jsonl", "shaft-not-turning");
    terminate(child.id());
    let outcome = outcome(child);
    assert!(number(&outcome, "/record/compared") > 10_000.0);
    let notes = list(&outcome, "notes");
    assert!(notes.iter().any(|note| note.as_str().unwrap().contains("no shaft angle")), "{notes:#?}");
    assert!(sandbox.read("r.html").contains("</html>"));
}

/// The demonstration with a speed column at 0 rpm, and a gap of `gap` seconds in the middle of its time column.
pub fn at_rest_with_gap(gap: f64) -> Sandbox {
    let keyphasor = "keyphasor = { column = \"keyphasor\", pulses_per_turn = 1 }";
    let scene = swap(DEMO_SCENE, keyphasor, "speed = { column = \"keyphasor\", unit = \"rpm\" }");
    let scene = swap(&scene, "rate = \"12.8 kHz\"", "time = \"time_s\"");
    let mut text = String::new();
    for (i, line) in short_recording(4096).lines().enumerate() {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if i > 0 {
            let sample = (i - 1) as f64;
            cells[0] = format!("{:.7}", sample / 12_800.0 + if i > 2048 { gap } else { 0.0 });
            cells[6] = "0".to_owned();
        }
        text += &(cells.join(",") + "\n");
    }
    Sandbox::with(&scene, &text)
}

#[test]
fn a_long_gap_at_standstill_is_not_integrated() {
    let sandbox = at_rest_with_gap(600.0);
    let child = sandbox.command(&["replay", "scene.toml", "--format", "json"]).spawn().unwrap();
    let output = ended(child);
    let outcome: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(number(&outcome, "/record/compared"), 4096.0);
    let notes = list(&outcome, "notes");
    assert!(notes.iter().any(|note| note.as_str().unwrap().contains("gap")), "{notes:#?}");
}

#[test]
fn implausible_rates_are_refused() {
    let sandbox = Sandbox::rig();
    sandbox.put("slow.toml", swap(DEMO_SCENE, "rate = \"12.8 kHz\"", "rate = \"12.8 Hz\""));
    sandbox.refused(&["replay", "slow.toml"], 2, &["rate", "12.8 Hz", "3000 rpm"]);
    sandbox.refused(&["replay", "slow.toml", "--paced"], 2, &["rate", "12.8 Hz", "3000 rpm"]);
    sandbox.put("stamps.toml", swap(DEMO_SCENE, "rate = \"12.8 kHz\"", "time = \"time_s\""));
    for (step, rate) in [(10.0, "0.1 Hz"), (1e-12, "1000000000000 Hz")] {
        let stamped = |(i, line): (usize, &str)| match line.split_once(',') {
            Some((_, rest)) if i > 0 => format!("{:e},{rest}\n", (i - 1) as f64 * step),
            _ => line.to_owned() + "\n",
        };
        sandbox.put("healthy.csv", short_recording(2048).lines().enumerate().map(stamped).collect::<String>());
        sandbox.refused(&["replay", "stamps.toml"], 1, &["healthy.csv", rate]);
        sandbox.refused(&["replay", "stamps.toml", "--paced"], 1, &["healthy.csv", rate]);
    }
}

#[test]
fn a_paced_start_is_not_a_silent_source() {
    let sandbox = sandbox();
    let child = monitor(&sandbox, &["--events", "events.jsonl"]);
    outcome(child);
    assert_eq!(sandbox.read("events.jsonl"), "");
}

#[test]
fn source_that_disconnects_sends_no_row_twice() {
    let sandbox = sandbox();
    let (child, port) = listening(&sandbox, "tcp", &["--encoding", "frames", "--events", "events.jsonl"]);
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    let mut stream = connected(port);
    (0..6_400).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    wait_for_event(&sandbox, "events.jsonl", "source-silent");
    drop(stream);
    wait_for_event(&sandbox, "events.jsonl", "source-gone");
    let mut stream = connected(port);
    (6_400..6_500).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    wait_for_event(&sandbox, "events.jsonl", "source-speaks");
    assert_eq!(
        kinds(&sandbox, "events.jsonl"),
        ["source-connected", "source-silent", "source-gone", "source-connected", "source-speaks"]
    );
    terminate(child.id());
    assert_eq!(source(&outcome(child), "stalls"), 1.0);
}

/// Before its first sample a monitor has nothing to report, and ends like any command after a signal.
#[test]
fn a_monitor_is_stopped_before_its_first_sample() {
    let sandbox = sandbox();
    let (child, port) = listening(&sandbox, "tcp", &[]);
    let _stream = connected(port);
    terminate(child.id());
    let output = ended(child);
    assert_eq!(output.status.code(), Some(130), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("stopped before the first sample arrived"), "{output:?}");
}

/// A monitor takes memory for the samples that wait, not for all that its buffers could hold: 80 MiB instead of 121 once the
/// demonstration, which is simulated faster than it runs, has filled the ring of 16384 samples and gone on.
#[test]
#[cfg(target_os = "linux")]
fn memory_is_that_of_the_samples_that_wait() {
    let monitor = crate::page::Site::demonstration(&[]);
    monitor.wait("samples", |state| state["counts"]["rows"].as_u64().filter(|rows| *rows >= 4 * 16_384));
    let largest = monitor.memory("VmHWM");
    println!("largest resident memory: {largest:?} MiB");
    assert!(largest.is_some_and(|largest| largest > 20.0 && largest < 100.0), "{largest:?} MiB");
}
