//! A monitor whose events, indicators and state lie on a disk that is full: a tmpfs of a few kB in a mount namespace of its
//! own.
#![cfg(target_os = "linux")]

use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use crate::frames_source::{RATE, Rig, connected, port};
use crate::live_start::terminate;
use crate::support::{Sandbox, is_progress, number};

/// Granularity of a tmpfs, bytes.
const PAGE: usize = 4096;
/// Mounts the disk, runs the program on it, and copies the disk's files to `copy` at its end.
const SCRIPT: &str = r#"
mount -t tmpfs -o size=192k none disk || exit 99
"$@" & echo $! > program.pid
wait $!; code=$?
cp -r disk copy
exit $code
"#;

/// True where this machine lets a user mount a disk in a namespace; prints a note where it does not.
pub fn can_mount() -> bool {
    let sandbox = Sandbox::empty();
    fs::create_dir(sandbox.path("disk")).unwrap();
    let mount = "mount -t tmpfs -o size=64k none disk";
    let mut unshare = Command::new("unshare");
    let status = unshare.args(["-rm", "sh", "-c", mount]).current_dir(sandbox.path("")).stderr(Stdio::null()).status();
    let can = status.as_ref().is_ok_and(std::process::ExitStatus::success);
    if !can {
        println!("skipped: no user namespace with a tmpfs on this machine (unshare -rm: {status:?})");
    }
    can
}

/// Fills the disk of an event log with the file `filler`, until neither a further page nor a further byte of the log's
/// last page is left.
pub fn fill(log: &Path, filler: &Path) {
    let length = fs::metadata(log).unwrap().len() as usize;
    let blanks = " ".repeat(PAGE - 1 - length % PAGE) + "\n";
    fs::OpenOptions::new().append(true).open(log).unwrap().write_all(blanks.as_bytes()).unwrap();
    fill_pages(filler);
}

/// Fills a disk with a file, until no further page is left.
pub fn fill_pages(filler: &Path) {
    let mut file = fs::File::create(filler).unwrap();
    let since = std::time::Instant::now();
    while file.write_all(&[0; 512]).is_ok() {
        assert!(since.elapsed().as_secs() < 10, "the disk is not small");
    }
}

/// A number that the metrics of a monitor show.
pub fn metric(port: u16, name: &str) -> f64 {
    let mut scrape = connected(port);
    scrape.write_all(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
    let mut page = String::new();
    scrape.read_to_string(&mut page).unwrap();
    let line = page.lines().find_map(|line| line.strip_prefix(name)?.trim().parse().ok());
    line.unwrap_or(0.0)
}

/// A monitor that writes to a small disk.
struct SmallDisk {
    rig: Rig,
    metrics: u16,
    monitor: Child,
}

impl SmallDisk {
    fn start() -> Self {
        let metrics = port();
        let files = ["--state", "disk/state", "--events", "disk/events.jsonl", "--indicators", "disk/trend"];
        let others = ["--indicators-file-length", "2 s", "--report", "report.html", "--prometheus"];
        let rig = Rig::new(&[&files[..], &others, &[&metrics.to_string()]].concat());
        fs::create_dir(rig.sandbox.path("disk")).unwrap();
        let program = rig.command();
        let mut command = Command::new("unshare");
        command.args(["-rm", "sh", "-c", SCRIPT, "sh"]).arg(program.get_program()).args(program.get_args());
        command.current_dir(rig.sandbox.path("")).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let monitor = command.spawn().unwrap();
        Self { rig, metrics, monitor }
    }

    /// A file on the disk, in the monitor's mount namespace.
    fn path(&self, name: &str) -> PathBuf {
        let pid = self.rig.sandbox.read("program.pid");
        let sandbox = self.rig.sandbox.path("disk");
        PathBuf::from(format!("/proc/{}/root{}/{name}", pid.trim(), sandbox.display()))
    }

    /// Feeds the monitor until it acknowledges seconds, fills the disk, and feeds it until it lacks seconds on disk.
    fn until_full(&self) {
        self.rig.feed(u64::MAX, |rig| rig.acknowledged() >= 3 * RATE);
        fill(&self.path("events.jsonl"), &self.path("filler"));
        self.rig.feed(u64::MAX, |_| metric(self.metrics, "ballrace_seconds_not_written") >= 2.0);
    }

    /// Ends the monitor and returns its outcome; its files are in `copy` then.
    fn end(self) -> (Value, Rig) {
        terminate(self.rig.sandbox.read("program.pid").trim().parse().unwrap());
        let output = self.monitor.wait_with_output().unwrap();
        let err = String::from_utf8_lossy(&output.stderr);
        assert!(is_progress(&err), "{err}");
        (serde_json::from_slice(&output.stdout).unwrap(), self.rig)
    }
}

fn kinds(rig: &Rig) -> Vec<String> {
    let kind = |line: &str| serde_json::from_str::<Value>(line).unwrap()["kind"].as_str().unwrap().to_owned();
    rig.sandbox.read("copy/events.jsonl").lines().filter(|line| !line.trim().is_empty()).map(kind).collect()
}

/// Times and number of the seconds on the disk: each once, from the first on.
fn seconds(rig: &Rig) -> usize {
    let times: Vec<f64> = rig.seconds("copy/trend").into_iter().map(|(time, _)| time).collect();
    assert_eq!(times, (1..=times.len()).map(|i| i as f64).collect::<Vec<_>>());
    times.len()
}

#[test]
fn a_disk_that_is_full_for_a_while_loses_nothing() {
    if !can_mount() {
        return;
    }
    let disk = SmallDisk::start();
    disk.until_full();
    let acknowledged = disk.rig.acknowledged();
    fs::remove_file(disk.path("filler")).unwrap();
    disk.rig.feed(u64::MAX, |rig| rig.acknowledged() >= acknowledged + 4 * RATE);
    let (outcome, rig) = disk.end();
    for count in ["seconds_not_written", "events_not_written"] {
        assert_eq!(number(&outcome, &format!("/timing/outputs/{count}")), 0.0, "{count}");
    }
    assert!(seconds(&rig) as u64 >= acknowledged / RATE + 4);
    let kinds = kinds(&rig);
    for kind in ["output-failing", "output-recovered"] {
        assert!(kinds.iter().any(|of| of == kind), "{kind} is not in {kinds:?}");
    }
    assert!(rig.sandbox.read("report.html").contains("</html>"));
}

#[test]
fn permanently_full_disk_stops_neither_monitor_nor_report() {
    if !can_mount() {
        return;
    }
    let disk = SmallDisk::start();
    disk.until_full();
    let acknowledged = disk.rig.acknowledged();
    let (outcome, rig) = disk.end();
    assert!(number(&outcome, "/timing/outputs/seconds_not_written") >= 2.0, "{outcome:#}");
    assert!(number(&outcome, "/timing/outputs/events_not_written") >= 1.0, "{outcome:#}");
    assert!(rig.sandbox.read("report.html").contains("Not written: "));
    // Every acknowledged second is on the disk.
    let state: Value = serde_json::from_str(&rig.sandbox.read("copy/state/state.json")).unwrap();
    assert!(state["seconds_index"].as_u64().unwrap() >= acknowledged, "{state} {acknowledged}");
}
