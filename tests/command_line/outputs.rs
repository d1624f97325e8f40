//! Files that a monitor writes: who owns them, what a start that fails leaves, what a disk that fails costs.

use crate::frames_source::{PATIENCE, RATE, Rig, port, signal, spike, wait_until};
use crate::support::{DEMO_SCENE, SHORT, Sandbox, is_progress, number, short_recording};
use serde_json::Value;
use std::fs;
use std::net::TcpListener;
use std::time::Instant;

const FILES: [&str; 6] = ["--state", "state", "--events", "events.jsonl", "--indicators", "trend"];

fn kinds(sandbox: &Sandbox, log: &str) -> Vec<String> {
    let kind = |line: &str| serde_json::from_str::<Value>(line).unwrap()["kind"].as_str().unwrap().to_owned();
    sandbox.read(log).lines().map(kind).collect()
}

fn end(child: std::process::Child) -> Value {
    signal(&child, "TERM");
    let output = child.wait_with_output().unwrap();
    let err = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 3)), "{:?} {err}", output.status);
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_start_on_a_busy_port_changes_nothing() {
    let sandbox = Sandbox::rig();
    let earlier = "{\"at\":\"2026-01-01T00:00:00Z\",\"time_s\":99.0,\"kind\":\"limit-crossed\",\"sentence\":\"\"}\n";
    sandbox.put("events.jsonl", earlier);
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let busy = taken.local_addr().unwrap().port();
    let (source, metrics) = (format!("tcp:{busy}"), busy.to_string());
    let free = format!("tcp:{}", port());
    for args in [["--source", &source].to_vec(), ["--source", &free, "--prometheus", &metrics].to_vec()] {
        let args = [&["replay", "scene.toml", "--paced", "--encoding", "frames"], &args[..], &FILES].concat();
        let answer = sandbox.run(&args);
        assert!(answer.code == Some(1) && answer.err.contains("free port"), "{answer:?}");
        assert_eq!(sandbox.read("events.jsonl"), earlier);
        assert!(!sandbox.path("trend").exists() && !sandbox.path("state/state.json").exists(), "{:?}", sandbox.files());
    }
    // Nor does the next start remove anything.
    let args = ["replay", "scene.toml", "--paced", "--format", "json"];
    let answer = sandbox.run(&[&args[..], &FILES].concat());
    assert_eq!(answer.code, Some(0), "{answer:?}");
    assert!(sandbox.read("events.jsonl").starts_with(earlier), "{}", sandbox.read("events.jsonl"));
}

#[test]
fn a_killed_monitor_keeps_the_events_of_earlier_runs() {
    let rig = Rig::new(&FILES);
    let earlier = "{\"at\":\"2026-01-01T00:00:00Z\",\"time_s\":99.0,\"kind\":\"limit-crossed\",\"sentence\":\"\"}\n";
    rig.sandbox.put("events.jsonl", earlier);
    let mut child = rig.start();
    rig.feed(u64::MAX, |rig| rig.acknowledged() >= 4 * RATE);
    child.kill().unwrap();
    child.wait().unwrap();
    let before = rig.sandbox.read("events.jsonl");
    assert!(before.starts_with(earlier) && before.lines().count() > 3, "{before}");
    // A kill in the middle of a line leaves a part of it.
    rig.sandbox.put("events.jsonl", before.clone() + "{\"at\":\"2026-");
    let child = rig.start();
    rig.feed(u64::MAX, |rig| rig.acknowledged() >= 6 * RATE);
    end(child);
    let after = rig.sandbox.read("events.jsonl");
    assert!(after.starts_with(&before), "{before}\nbecame\n{after}");
    assert!(kinds(&rig.sandbox, "events.jsonl").contains(&"monitor-resumed".to_owned()), "{after}");
}

#[test]
fn one_running_monitor_owns_state_log_and_indicators() {
    let rig = Rig::new(&FILES);
    let child = rig.start();
    rig.feed(u64::MAX, |rig| rig.acknowledged() >= 3 * RATE);
    let before = rig.sandbox.read("events.jsonl");
    let owner = format!("in use by process {} since", child.id());
    let source = format!("tcp:{}", port());
    for (files, found) in [
        (&FILES[..], owner.as_str()),
        (&["--indicators", "trend"], owner.as_str()),
        (&["--events", "events.jsonl"], "events.jsonl: this log is in use by another process"),
    ] {
        let args = ["replay", "scene.toml", "--paced", "--encoding", "frames", "--source", &source];
        let answer = rig.sandbox.run(&[&args[..], files].concat());
        assert!(answer.code == Some(1) && answer.err.contains(found), "{files:?}: {answer:?}");
    }
    assert!(rig.sandbox.read("events.jsonl").starts_with(&before));
    // The running one goes on.
    rig.feed(u64::MAX, |rig| rig.acknowledged() >= 5 * RATE);
    end(child);
    let times: Vec<f64> = rig.seconds("trend").into_iter().map(|(time, _)| time).collect();
    assert_eq!(times, (1..=times.len()).map(|i| i as f64).collect::<Vec<_>>());
}

#[test]
#[cfg(target_os = "linux")]
fn full_disk_of_the_event_log_affects_events_only() {
    let rig = Rig::new(&["--events", "/dev/full", "--indicators", "trend", "--report", "report.html"]);
    let child = rig.start();
    let since = Instant::now();
    let trend = rig.sandbox.path("trend/indicators.journal");
    rig.feed(6 * RATE, |_| {
        assert!(since.elapsed() < PATIENCE);
        fs::read_to_string(&trend).is_ok_and(|journal| journal.lines().count() >= 5)
    });
    let outcome = end(child);
    assert!(number(&outcome, "/timing/outputs/events_not_written") >= 3.0, "{outcome:#}");
    assert_eq!(number(&outcome, "/timing/outputs/seconds_not_written"), 0.0);
    assert!(rig.seconds("trend").len() >= 4 && rig.sandbox.read("report.html").contains("Not written: "));
}

/// Folders that are gone for a while, as a disk that is full for a while: writing to it fails, then works again.
#[test]
fn outputs_that_fail_for_a_while_lose_nothing() {
    let rig = Rig::new(&[&FILES[..], &["--indicators-file-length", "2 s"]].concat());
    let child = rig.start();
    rig.feed(u64::MAX, |rig| rig.acknowledged() >= 3 * RATE);
    for folder in ["state", "trend"] {
        fs::rename(rig.sandbox.path(folder), rig.sandbox.path(&format!("{folder}-away"))).unwrap();
    }
    let failing =
        |rig: &Rig| kinds(&rig.sandbox, "events.jsonl").iter().filter(|kind| *kind == "output-failing").count();
    rig.feed(u64::MAX, |rig| failing(rig) == 2);
    let acknowledged = rig.acknowledged();
    for folder in ["state", "trend"] {
        fs::rename(rig.sandbox.path(&format!("{folder}-away")), rig.sandbox.path(folder)).unwrap();
    }
    rig.feed(u64::MAX, |rig| rig.acknowledged() >= acknowledged + 4 * RATE);
    let outcome = end(child);
    assert_eq!(number(&outcome, "/timing/outputs/seconds_not_written"), 0.0);
    assert_eq!(number(&outcome, "/timing/outputs/events_not_written"), 0.0);
    let times: Vec<f64> = rig.seconds("trend").into_iter().map(|(time, _)| time).collect();
    assert_eq!(times, (1..=times.len()).map(|i| i as f64).collect::<Vec<_>>());
    assert!(times.len() as u64 >= acknowledged / RATE + 4, "{times:?}");
    let kinds = kinds(&rig.sandbox, "events.jsonl");
    assert_eq!(kinds.iter().filter(|kind| *kind == "output-recovered").count(), 2, "{kinds:?}");
}

#[test]
#[cfg(unix)]
fn a_report_keeps_the_permissions_of_the_one_it_replaces() {
    use std::os::unix::fs::PermissionsExt;
    let sandbox = Sandbox::rig();
    let mode = |name: &str| fs::metadata(sandbox.path(name)).unwrap().permissions().mode() & 0o777;
    for wanted in [0o600, 0o640, 0o664] {
        sandbox.put("report.html", "from before");
        fs::set_permissions(sandbox.path("report.html"), fs::Permissions::from_mode(wanted)).unwrap();
        sandbox.done(&["replay", "scene.toml", "--report", "report.html"]);
        assert_eq!(format!("{:o}", mode("report.html")), format!("{wanted:o}"));
    }
    // A new one has those of any new file.
    sandbox.put("any", "");
    sandbox.done(&["replay", "scene.toml", "--report", "new.html"]);
    assert_eq!(mode("new.html"), mode("any"));
}

#[test]
#[cfg(unix)]
fn a_signal_leaves_no_temporary_file() {
    for name in ["TERM", "INT", "HUP"] {
        let sandbox = Sandbox::with(DEMO_SCENE, &short_recording(12_800));
        let before = sandbox.files();
        let args = ["simulate", "scene.toml", "--duration", "1 h", "--rate", "1 kHz", "--output", "out.csv"];
        let mut child = sandbox.command(&args).spawn().unwrap();
        wait_until("a temporary file", || sandbox.files().len() > before.len());
        signal(&child, name);
        let status = child.wait().unwrap();
        assert_eq!(status.code(), Some(130), "{name}: {status:?}");
        assert_eq!(sandbox.files(), before, "{name}");
    }
}

/// A pipe holds the events until its reader comes; one that is full does not stop the monitor.
#[test]
#[cfg(target_os = "linux")]
fn a_pipe_for_events_without_a_reader_does_not_block_the_monitor() {
    let rig = Rig::new(&["--events", "pipe", "--indicators", "trend"]);
    assert!(std::process::Command::new("mkfifo").arg(rig.sandbox.path("pipe")).status().unwrap().success());
    let child = rig.start();
    let trend = rig.sandbox.path("trend/indicators.journal");
    rig.feed(6 * RATE, |_| fs::read_to_string(&trend).is_ok_and(|journal| journal.lines().count() >= 5));
    let outcome = end(child);
    assert!(!outcome["events"].as_array().unwrap().is_empty());
}

/// Event logs that are rotated or deleted under a monitor, with and without SIGHUP, which does not end it.
#[test]
#[cfg(unix)]
fn a_rotated_or_deleted_log_loses_no_event() {
    let rig = Rig::new(&FILES);
    let child = rig.start();
    let feed = |seconds: u64| {
        let end = rig.acknowledged() + seconds * RATE;
        rig.feed(u64::MAX, |rig| rig.acknowledged() >= end);
    };
    let (log, journal) = (rig.sandbox.path("events.jsonl"), rig.sandbox.path("trend/indicators.journal"));
    feed(3);
    fs::rename(&log, rig.sandbox.path("events.jsonl.1")).unwrap();
    // The next line reopens the log.
    feed(3);
    wait_until("a log at the next line", || log.exists());
    fs::rename(&log, rig.sandbox.path("events.jsonl.2")).unwrap();
    signal(&child, "HUP");
    wait_until("a log after SIGHUP", || log.exists());
    feed(3);
    // Lines that are appended to a file that is deleted are gone with it, unless it has another name; the later ones are not.
    fs::hard_link(&log, rig.sandbox.path("events.jsonl.3")).unwrap();
    fs::remove_file(&log).unwrap();
    fs::remove_file(&journal).unwrap();
    feed(3);
    let outcome = end(child);
    for count in ["seconds_not_written", "events_not_written"] {
        assert_eq!(number(&outcome, &format!("/timing/outputs/{count}")), 0.0, "{count}");
    }
    let logs = ["events.jsonl.1", "events.jsonl.2", "events.jsonl.3", "events.jsonl"];
    let events: Vec<_> = logs.iter().flat_map(|log| rig.limit_events(log)).collect();
    let wanted = (0..).take_while(|number| spike(*number) < 11 * RATE).count();
    for kind in ["limit-crossed", "limit-ended"] {
        let starts: Vec<f64> =
            events.iter().filter(|(of, probe, _)| of == kind && probe == "DE_X_um").map(|event| event.2).collect();
        assert!(starts.len() >= wanted, "{kind}: {starts:?}");
        assert!(starts.windows(2).all(|pair| pair[1] - pair[0] > 0.9), "{kind}: {starts:?}");
    }
    let times: Vec<f64> = rig.seconds("trend").into_iter().map(|(time, _)| time).collect();
    assert_eq!(times, (1..=times.len()).map(|i| i as f64).collect::<Vec<_>>());
}

/// A full disk under forces or report costs a monitor neither its run nor its outcome.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_under_forces_or_report_leaves_the_outcome() {
    let sandbox = Sandbox::with(DEMO_SCENE, &short_recording(12_800));
    let args = ["replay", "scene.toml", "--paced", "--format", "json"];
    let options = ["--forces", "/dev/full", "--events", "events.jsonl", "--report", "report.html"];
    let answer = sandbox.run(&[&args[..], &options].concat());
    assert!(answer.code == Some(0) && is_progress(&answer.err), "{answer:?}");
    let outcome: Value = answer.json();
    assert!(number(&outcome, "/record/compared") > 12_000.0);
    let notes = outcome["notes"].to_string();
    assert!(notes.contains("/dev/full: this file cannot be written"), "{notes}");
    assert!(kinds(&sandbox, "events.jsonl").contains(&"output-failing".to_owned()));
    assert!(sandbox.read("report.html").contains("</html>"));
    // Outside real time a file of forces that is not whole is an error.
    let answer = sandbox.run(&["replay", "scene.toml", "--forces", "/dev/full"]);
    assert!(answer.code == Some(1) && answer.err.contains("/dev/full"), "{answer:?}");
    let answer = sandbox.run(&["replay", "scene.toml", "--report", "/dev/full", "--format", "json"]);
    assert!(answer.code == Some(1) && answer.err.contains("/dev/full"), "{answer:?}");
    let outcome: Value = answer.json();
    assert_eq!(number(&outcome, "/record/samples"), 12_800.0);
}

#[test]
#[cfg(unix)]
fn a_state_keeps_its_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let sandbox = Sandbox::with(DEMO_SCENE, &short_recording(SHORT));
    let args = ["replay", "scene.toml", "--paced", "--no-report", "--state", "state"];
    sandbox.done(&args);
    let path = sandbox.path("state/state.json");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
    sandbox.done(&args);
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
}
