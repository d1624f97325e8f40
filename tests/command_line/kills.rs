//! A monitor killed at any moment and started again: no second and no event is lost or written twice.

use crate::frames_source::{RATE, Rig, connected, plateau, signal, spike, wait_until};
use std::io::Write;
use std::process::Child;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// A sequence of pseudo-random numbers from 0 to 1 (Knuth's linear congruential generator).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

pub fn kill(mut child: Child) {
    child.kill().unwrap();
    child.wait().unwrap();
}

/// What a power failure or a bad disk does to a state.
pub const DAMAGES: [fn(Vec<u8>) -> Vec<u8>; 4] = [
    |bytes| bytes[..bytes.len() / 2].to_vec(),
    |_| vec![],
    |bytes| vec![0; bytes.len()],
    |bytes| String::from_utf8(bytes).unwrap().replacen("\"seconds_index\": ", "\"seconds_index\": 9", 1).into(),
];

/// Kills the monitor `kills` times at random moments, then checks everything up to the sample `end`.
fn assert_nothing_lost_or_doubled(kills: u32, seed: u64) {
    let options = ["--state", "state", "--events", "events.jsonl", "--indicators", "trend"];
    let rig = Rig::new(&[&options[..], &["--indicators-file-length", "3 s"]].concat());
    let mut random = Random(seed);
    for number in 0..kills {
        let child = rig.start();
        // A third of the kills comes during the start, the others after some acknowledgements.
        let before = rig.acknowledged();
        let (life, steps) = match number % 3 {
            0 => (Duration::from_secs_f64(0.6 * random.next()), u64::MAX),
            _ => (Duration::from_secs(60), (2.0 * random.next() * RATE as f64) as u64),
        };
        let since = Instant::now();
        rig.feed(u64::MAX, |rig| since.elapsed() > life || rig.acknowledged() - before > steps);
        std::thread::sleep(Duration::from_secs_f64(0.05 * random.next()));
        kill(child);
    }
    let end = rig.acknowledged() + 5 * RATE;
    let child = rig.start();
    rig.feed(end, |rig| rig.acknowledged() > end - 2 * RATE);
    signal(&child, "TERM");
    let output = child.wait_with_output().unwrap();
    // The monitors before may have reported every event.
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", String::from_utf8_lossy(&output.stderr));

    // Everything before this sample was acknowledged, with a block to spare.
    let sure = end - 3 * RATE;
    let times: Vec<(f64, f64)> = rig.seconds("trend");
    let whole: Vec<(f64, f64)> = (1..=times.len()).map(|i| (i as f64, RATE as f64)).collect();
    assert_eq!(times, whole, "a second is missing, written twice or incomplete");
    assert!(times.len() as u64 >= sure / RATE, "{} of {}", times.len(), sure / RATE);

    let events = rig.limit_events("events.jsonl");
    let starts = |kind: &str, probe: &str, from: f64, to: f64| {
        let found = events.iter().filter(|(k, p, start)| k == kind && p == probe && (from..to).contains(start));
        found.count()
    };
    let assert_once = |probe: &str, from: u64, what: &str| {
        let at = from as f64 / RATE as f64;
        for kind in ["limit-crossed", "limit-ended"] {
            // A block has 16 turns, 0.32 s.
            let found = starts(kind, probe, at - 0.34, at + 0.01);
            assert_eq!(found, 1, "{kind} of the {what} at {at} s: {events:#?}");
        }
    };
    let mut wanted = 0;
    for from in (0..).map(spike).take_while(|at| *at < sure) {
        assert_once("DE_X_um", from, "spike");
        wanted += 2;
    }
    for range in (0..).map(plateau).take_while(|range| range.end < sure) {
        assert_once("NDE_X_um", range.start, "plateau");
        wanted += 2;
    }
    let sure_s = sure as f64 / RATE as f64;
    let found = events.iter().filter(|(_, probe, start)| {
        let slack = if probe == "DE_X_um" { 0.34 } else { 2.34 };
        *start < sure_s - slack
    });
    assert!(found.count() <= wanted, "events of nothing: {events:#?}");
    println!("{kills} kills, {} s acknowledged, {wanted} events", rig.acknowledged() / RATE);
}

/// A source that keeps few frames does not wait for ever for an acknowledgement that the end of a connection took.
#[test]
fn an_acknowledgement_that_was_lost_is_sent_again() {
    let rig = Rig::new(&["--state", "state"]);
    let child = rig.start();
    rig.feed(u64::MAX, |rig| rig.acknowledged() > 2 * RATE);
    kill(child);
    let last = rig.acknowledged.swap(0, Ordering::SeqCst);
    let child = rig.start();
    // The monitor has every frame that it gets.
    rig.feed(last, |rig| rig.acknowledged() >= last);
    kill(child);
}

#[test]
fn kills_during_start_run_restart_and_file_change() {
    assert_nothing_lost_or_doubled(6, 1);
}

#[test]
#[ignore = "slow: some minutes; tests/run --all runs it"]
fn long_200_kills_during_start_run_restart_and_file_change() {
    for seed in 0..4 {
        assert_nothing_lost_or_doubled(50, 100 + seed);
    }
}

/// The block in which a limit is crossed ends after the second in which it is crossed.
#[test]
fn a_crossing_of_an_acknowledged_second_is_reported_after_a_kill() {
    // At 2.9 s, in the block from 2.88 s to 3.20 s.
    assert_eq!(spike(2), 29 * RATE / 10);
    let events = |is_killed: bool| {
        let rig = Rig::new(&["--state", "state", "--events", "events.jsonl"]);
        if is_killed {
            let child = rig.start();
            let has_three_seconds = |rig: &Rig| {
                let text = std::fs::read_to_string(rig.sandbox.path("state/state.json")).unwrap_or_default();
                let state: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
                state["time_s"].as_f64().is_some_and(|time| time >= 3.0)
            };
            // A sample waits for the keyphasor's next pulses, up to 0.12 s.
            rig.feed(319 * RATE / 100, has_three_seconds);
            // An acknowledgement in transit counts too.
            std::thread::sleep(Duration::from_millis(100));
            kill(child);
            let log = rig.limit_events("events.jsonl");
            assert!(log.iter().all(|(_, _, start)| *start < 2.5), "too late to be of use: {log:?}");
        }
        let child = rig.start();
        rig.feed(6 * RATE, |rig| rig.acknowledged() > 4 * RATE);
        signal(&child, "TERM");
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stderr));
        let events = rig.limit_events("events.jsonl").into_iter();
        let spikes = events.filter(|(_, probe, start)| probe == "DE_X_um" && *start < 3.5);
        spikes.map(|(kind, _, start)| (kind, (start * 20.0).round() as i64)).collect::<Vec<_>>()
    };
    let uninterrupted = events(false);
    assert_eq!(uninterrupted.len(), 6, "three spikes, crossed and ended: {uninterrupted:?}");
    assert_eq!(events(true), uninterrupted);
}

/// The monitor goes on with the copy of a damaged state.
#[test]
fn a_damaged_state_loses_and_doubles_nothing() {
    let rig = Rig::new(&["--state", "state", "--events", "events.jsonl", "--indicators", "trend"]);
    let run = |seconds: u64| {
        let child = rig.start();
        let end = rig.acknowledged() + seconds * RATE;
        rig.feed(u64::MAX, |rig| rig.acknowledged() >= end);
        kill(child);
    };
    run(3);
    for damage in DAMAGES {
        let state = std::fs::read(rig.sandbox.path("state/state.json")).unwrap();
        rig.sandbox.put("state/state.json", damage(state));
        run(2);
    }
    let child = rig.start();
    let end = rig.acknowledged() + 5 * RATE;
    rig.feed(end, |rig| rig.acknowledged() > end - 2 * RATE);
    signal(&child, "TERM");
    let output = child.wait_with_output().unwrap();
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", String::from_utf8_lossy(&output.stderr));
    let times: Vec<f64> = rig.seconds("trend").into_iter().map(|(time, _)| time).collect();
    assert_eq!(times, (1..=times.len()).map(|i| i as f64).collect::<Vec<_>>());
    assert!(times.len() >= 11, "{times:?}");
    let events = rig.limit_events("events.jsonl");
    for number in (0..).take_while(|number| spike(*number) < 10 * RATE) {
        let at = spike(number) as f64 / RATE as f64;
        for kind in ["limit-crossed", "limit-ended"] {
            let found = events.iter().filter(|(of, probe, start)| {
                of == kind && probe == "DE_X_um" && (at - 0.34..at + 0.01).contains(start)
            });
            assert_eq!(found.count(), 1, "{kind} at {at} s: {events:#?}");
        }
    }
    let count = rig.sandbox.read("events.jsonl").matches("\"file-damaged\"").count();
    assert_eq!(count, 4, "{}", rig.sandbox.read("events.jsonl"));
    // Without a copy the monitor starts empty.
    for name in ["state.json", "state.json.copy"] {
        rig.sandbox.put(&format!("state/{name}"), "{\"cut");
    }
    rig.acknowledged.store(0, Ordering::SeqCst);
    run(2);
    assert!(rig.sandbox.read("events.jsonl").contains("start empty"), "{}", rig.sandbox.read("events.jsonl"));
}

/// A kill between the indicators and the state: the state is older than the seconds on disk.
#[test]
fn seconds_on_disk_that_the_state_lacks_are_not_written_twice() {
    let rig = Rig::new(&["--state", "state", "--indicators", "trend", "--indicators-file-length", "3 s"]);
    let child = rig.start();
    rig.feed(u64::MAX, |rig| rig.acknowledged() >= 2 * RATE);
    let older = rig.sandbox.read("state/state.json");
    let state: serde_json::Value = serde_json::from_str(&older).unwrap();
    rig.feed(u64::MAX, |rig| rig.acknowledged() >= 7 * RATE);
    kill(child);
    rig.sandbox.put("state/state.json", older);
    rig.acknowledged.store(state["resume"]["index"].as_u64().unwrap(), Ordering::SeqCst);
    let child = rig.start();
    rig.feed(u64::MAX, |rig| rig.acknowledged() >= 9 * RATE);
    signal(&child, "TERM");
    child.wait_with_output().unwrap();
    let times: Vec<f64> = rig.seconds("trend").into_iter().map(|(time, _)| time).collect();
    let whole: Vec<f64> = (1..=times.len()).map(|i| i as f64).collect();
    assert_eq!(times, whole, "a second is missing or written twice");
    assert!(times.len() >= 9, "{times:?}");
}

/// A source that does not know of its acknowledgements sends its frames again: to the same monitor, and to one that was
/// killed.
#[test]
fn frames_whose_acknowledgement_did_not_arrive_are_not_doubled() {
    let rig = Rig::new(&["--state", "state", "--events", "events.jsonl", "--indicators", "trend"]);
    let mut child = rig.start();
    let written = |rig: &Rig| {
        let text = std::fs::read_to_string(rig.sandbox.path("state/state.json")).unwrap_or_default();
        serde_json::from_str::<serde_json::Value>(&text).ok()?["seconds_index"].as_u64()
    };
    let since = Instant::now();
    for end in [8 * RATE, 16 * RATE, 24 * RATE] {
        // The source reads its acknowledgements, and then has forgotten them.
        let mut stream = connected(rig.port);
        // An acknowledgement of 20 s ago is not forgotten.
        let first = if since.elapsed().as_secs() < 15 { 0 } else { written(&rig).unwrap_or(0) };
        (first..end).for_each(|index| stream.write_all(&rig.frame(index)).unwrap());
        // A source that closed with unread bytes would reset the connection, with what the monitor has not read yet.
        stream.shutdown(std::net::Shutdown::Write).unwrap();
        std::io::copy(&mut stream, &mut std::io::sink()).unwrap();
        wait_until("the seconds on disk", || written(&rig).is_some_and(|index| index + 2 * RATE >= end));
        if end == 16 * RATE {
            kill(child);
            child = rig.start();
        }
    }
    signal(&child, "TERM");
    let output = child.wait_with_output().unwrap();
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", String::from_utf8_lossy(&output.stderr));
    let log = rig.sandbox.read("events.jsonl");
    assert!(!log.contains("source-counts-anew"), "{log}");
    let times: Vec<f64> = rig.seconds("trend").into_iter().map(|(time, _)| time).collect();
    assert_eq!(times, (1..=times.len()).map(|i| i as f64).collect::<Vec<_>>());
    assert!((22..=24).contains(&times.len()), "{times:?}");
}
