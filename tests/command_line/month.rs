//! A month of a slow machine by the clock of its samples, as fast as it goes: kills, full disks, rotations, damaged
//! files, restarts of the source, steps of both clocks, and clients of the live page. Nothing that was acknowledged is
//! lost or doubled, nothing false is reported, memory and files are bounded.

use crate::clock_steps::{clock_library, get, set_clock};
use crate::frames_source::{Connection, Rig, connected, port, seconds_of, signal, wait_until};
use crate::full_disk::{can_mount, fill, fill_pages, metric};
use crate::kills::{DAMAGES, Random, kill};
use crate::live_start::ended;
use crate::support::{DEMO_SCENE, Sandbox, memory, number, numbers, swap};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Sampling rate, Hz, samples of a turn of 8 s, and samples of a day.
const RATE: u64 = 8;
const TURN: u64 = 64;
const DAY: u64 = 86_400 * RATE;
/// Samples of a block of the limits: 16 turns.
const BLOCK: u64 = 16 * TURN;
/// The motion repeats after five turns, which are two turns of the cage.
const REPEAT: u64 = 5 * TURN;
/// Samples that the source sends beyond the last acknowledged one: an hour.
const WINDOW: u64 = 3600 * RATE;
/// How long a part of the run may take on a slow, busy machine.
const PATIENCE: Duration = Duration::from_secs(1800);
/// Noise of the probes, um.
const NOISE: f64 = 0.03;
/// A shock on the first probe every 1.84 h, which exceeds its limit in one block.
const SHOCK: (u64, u64) = (4_000, 53_000);
/// The source loses one to five frames every 2.1 h.
const LOSS: (u64, u64) = (30_000, 61_000);
/// Size of the disk, MiB.
const DISK_MIB: u32 = 48;
const TOKEN: &str = "correct-horse-battery";

/// The alarm of the fault.
const FAULT: &str = "fault spall outer-race of DE";

/// A slow machine: heavily damped, integrated with the sample period.
fn scene(noise: f64, step: f64, more: &str) -> String {
    let scene = swap(DEMO_SCENE, "speed = \"3000 rpm\"", "speed = \"7.5 rpm\"");
    let scene = swap(&scene, "rate = \"12.8 kHz\"", "rate = \"8 Hz\"");
    let damping = "[\"400 N s/m\", \"400 N s/m\", \"400 N s/m\", \"0.4 N m s/rad\", \"0.4 N m s/rad\"]";
    let slow = "[\"1e7 N s/m\", \"1e7 N s/m\", \"1e7 N s/m\", \"1e5 N m s/rad\", \"1e5 N m s/rad\"]";
    let scene = swap(&scene, damping, slow).replace("noise = \"0.03 um\"", &format!("noise = \"{noise} um\""));
    let limit = "[[limit]]\nindicator = \"peak-to-peak\"\nprobe = \"DE_X_um\"\nmax = \"2.5 um\"\n";
    scene + &format!("\n[integration]\nmethod = \"newmark\"\nstep = \"{step} s\"\n\n{limit}{more}")
}

/// The readings of five turns, without noise.
fn motion(sandbox: &Sandbox, defect: &str) -> Vec<Vec<f32>> {
    // The scene of the monitor states neither the slip of the cages nor the defect.
    let scene = scene(1e-6, 0.002, "").replace("pitch_diameter", "cage_ratio = 0.4\npitch_diameter");
    sandbox.put("generating.toml", swap(&scene, "name = \"DE\"\n", &format!("name = \"DE\"\n{defect}")));
    let args = ["simulate", "generating.toml", "--duration", "40 s", "--settle", "160 s", "--as-recording"];
    sandbox.done(&[&args[..], &["-o", "motion.csv"]].concat());
    let (_, rows) = numbers(&sandbox.read("motion.csv"));
    assert_eq!(rows.len() as u64, REPEAT);
    rows.iter().map(|row| row.iter().map(|x| *x as f32).collect()).collect()
}

/// Number of the event of every `(first, every)` samples at or before `index`, and the samples since.
fn latest((first, every): (u64, u64), index: u64) -> Option<(u64, u64)> {
    let since = index.checked_sub(first)?;
    Some((since / every, since % every))
}

fn is_lost(index: u64) -> bool {
    latest(LOSS, index).is_some_and(|(number, since)| since <= number % 5)
}

fn is_shock(index: u64) -> bool {
    latest(SHOCK, index).is_some_and(|(_, since)| since == 0)
}

/// The sound machine, and from the sample `fault` on the one with a spall.
struct Machine {
    sound: Vec<Vec<f32>>,
    spalled: Vec<Vec<f32>>,
    fault: u64,
    /// Values of noise, um, which a hash of sample and probe selects, so that a frame that is sent again is the same.
    noise: Vec<f32>,
}

impl Machine {
    fn new(sandbox: &Sandbox, fault: u64) -> Self {
        let form = "half_width = \"2.5 deg\", depth = \"3 um\", shape = \"half-sine\"";
        let spall = format!("defect = [{{ surface = \"outer\", azimuth = \"-70 deg\", {form} }}]\n");
        let mut random = Random(7);
        let mut normal = || ((0..12).map(|_| random.next()).sum::<f64>() - 6.0) * NOISE;
        let noise = (0..1 << 16).map(|_| normal() as f32).collect();
        Self { sound: motion(sandbox, ""), spalled: motion(sandbox, &spall), fault, noise }
    }

    fn readings(&self, index: u64) -> Vec<f32> {
        if is_lost(index) {
            return vec![];
        }
        let motion = if index < self.fault { &self.sound } else { &self.spalled };
        let mut row = motion[(index % REPEAT) as usize].clone();
        let probes = row.len() - 1;
        for (probe, x) in row[..probes].iter_mut().enumerate() {
            // The mixing of SplitMix64.
            let mut hash = (8 * index + probe as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            *x += self.noise[((hash ^ (hash >> 27)) >> 40) as usize % self.noise.len()];
        }
        if is_shock(index) {
            row[0] += 5.0;
        }
        row
    }
}

/// A disk of its own size in a mount namespace, held by a process; `disk` on the sandbox leads to it.
struct Disk(Child);

impl Disk {
    fn mount(sandbox: &Sandbox) -> Self {
        fs::create_dir(sandbox.path("mount")).unwrap();
        let script = format!("mount -t tmpfs -o size={DISK_MIB}m none mount && echo ready && exec sleep infinity");
        let mut command = Command::new("unshare");
        command.args(["-rm", "sh", "-c", &script]).current_dir(sandbox.path("")).stdin(Stdio::null());
        let mut holder = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut ready = [0; 5];
        holder.stdout.as_mut().unwrap().read_exact(&mut ready).unwrap();
        let mount = format!("/proc/{}/root{}", holder.id(), sandbox.path("mount").display());
        std::os::unix::fs::symlink(mount, sandbox.path("disk")).unwrap();
        Self(holder)
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Clients of the live page that come, go and never read, until `stop`.
fn clients(port: u16, stop: &AtomicBool) -> u64 {
    let mut random = Random(11);
    let (mut silent, mut count) = (Vec::new(), 0);
    while !stop.load(Ordering::SeqCst) {
        std::thread::sleep(Duration::from_millis(100));
        let Ok(mut client) = TcpStream::connect(("127.0.0.1", port)) else { continue };
        count += 1;
        client.set_read_timeout(Some(Duration::from_secs(3))).unwrap();
        let choice = (random.next() * 40.0) as u32;
        let path = match choice {
            0..16 => "/events",
            16 => "/history?hours=24",
            17 => "/figures",
            18 => "/",
            _ => "/state",
        };
        let half = if choice == 39 { "" } else { "\r\n" };
        let _ = write!(client, "GET {path} HTTP/1.1\r\nHost: localhost\r\n{half}");
        match choice {
            // Never read, as a half request; the oldest ones go.
            0..12 | 39 => silent.push(client),
            // A stream that is read for a moment.
            12..16 => drop(client.read(&mut [0; 4096])),
            _ => drop(client.read_to_end(&mut vec![])),
        }
        if silent.len() > 40 {
            silent.drain(..(random.next() * 40.0) as usize);
        }
    }
    count
}

/// Names and bytes of all files below a folder.
fn files(folder: &Path) -> Vec<(PathBuf, u64)> {
    let mut all = vec![];
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let about = entry.metadata().unwrap();
        if about.is_dir() { all.extend(files(&entry.path())) } else { all.push((entry.path(), about.len())) }
    }
    all
}

/// What happened, for the figures.
#[derive(Debug, Default)]
struct Counts {
    starts: u32,
    kills: u32,
    kills_during_start: u32,
    ends_by_signal: u32,
    rotations: u32,
    deletions: u32,
    full_disks: u32,
    damages: u32,
    reconnections: u32,
    restarted_counts: u32,
    clock_steps: u32,
}

/// A run of the monitor, and what is known about it.
struct Month {
    rig: Rig,
    page: u16,
    metrics: u16,
    clock: Option<PathBuf>,
    random: Random,
    counts: Counts,
    /// Lines of the logs that were rotated away.
    log: Vec<String>,
    /// Seconds that were read from the indicator files.
    seconds: u64,
    /// The page has shown the alarm of the fault.
    has_alarm: bool,
    /// Largest memory, MiB.
    largest: f64,
    /// Largest number of files, and of bytes of each kind of file.
    most_files: usize,
    most_bytes: BTreeMap<String, u64>,
    fault: u64,
}

/// A monitor of the run; killed where the test fails.
struct Life {
    child: Option<Child>,
    /// Its clock may be set.
    has_clock: bool,
}

impl Life {
    fn id(&self) -> u32 {
        self.child.as_ref().unwrap().id()
    }
}

impl Drop for Life {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Month {
    fn new(fault: u64) -> (Self, Disk) {
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", scene(NOISE, 1.0 / RATE as f64, ""));
        sandbox.put("token", TOKEN);
        sandbox.put("clock", "+0");
        let disk = Disk::mount(&sandbox);
        let machine = Machine::new(&sandbox, fault);
        let (page, metrics) = (port(), port());
        let metrics_port = metrics.to_string();
        let files = ["--state", "disk/state", "--events", "disk/events.jsonl", "--indicators", "disk/trend"];
        let address = page.to_string();
        let others = ["--no-report", "--http", &address, "--http-token-file", "token", "--prometheus"];
        let options = [&files[..], &others, &[&metrics_port]].concat();
        let rig = Rig::with(sandbox, Box::new(move |index| machine.readings(index)), WINDOW, &options);
        let month = Self {
            rig,
            page,
            metrics,
            clock: clock_library(),
            random: Random(3),
            counts: Counts::default(),
            log: vec![],
            seconds: 0,
            has_alarm: false,
            largest: 0.0,
            most_files: 0,
            most_bytes: BTreeMap::new(),
            fault,
        };
        (month, disk)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.rig.sandbox.path("disk").join(name)
    }

    /// A whole number below `below`.
    fn below(&mut self, below: u64) -> u64 {
        (self.random.next() * below as f64) as u64
    }

    fn start(&mut self) -> Life {
        self.counts.starts += 1;
        let mut command = self.rig.command();
        // A clock that may be set costs a read of a file whenever the program asks for the time.
        let has_clock = self.counts.starts % 4 == 3 && self.clock.is_some();
        if let Some(library) = self.clock.as_ref().filter(|_| has_clock) {
            set_clock(&mut command, &self.rig.sandbox, library);
        }
        Life { child: Some(command.spawn().unwrap()), has_clock }
    }

    /// Feeds until `samples` more are acknowledged; the connection stays open.
    fn feed_open(&self, samples: u64) -> Connection {
        let end = self.rig.acknowledged() + samples;
        self.feed_until(|rig| rig.acknowledged() >= end)
    }

    /// Feeds until `samples` more are acknowledged.
    fn feed(&self, samples: u64) {
        self.feed_open(samples).close();
    }

    fn feed_until(&self, until: impl FnMut(&Rig) -> bool) -> Connection {
        self.rig.feed_from(self.rig.acknowledged(), u64::MAX, PATIENCE, until)
    }

    /// The alarms of the page are those that there are.
    fn look_at_page(&mut self) {
        let state = get(self.page, "/state");
        let alarms = state["alarms"].as_array().unwrap();
        let has_fault = alarms.iter().any(|alarm| alarm["id"] == FAULT);
        let is_allowed =
            |id: &str| id.starts_with("limit") || (self.rig.sent.load(Ordering::SeqCst) > self.fault && id == FAULT);
        assert!(alarms.iter().all(|alarm| is_allowed(alarm["id"].as_str().unwrap())), "{alarms:#?}");
        assert!(has_fault || !self.has_alarm, "the alarm is gone: {state:#}");
        self.has_alarm = has_fault;
    }

    /// One thing that happens to a running monitor, and samples after it.
    fn episode(&mut self, life: &mut Life) {
        let (samples, has_log) = (BLOCK + self.below(DAY / 4), self.path("events.jsonl").exists());
        match self.below(8) {
            // A rotation is over with the next event.
            0..=2 if !has_log => {}
            0 | 1 => {
                self.counts.rotations += 1;
                let away = format!("events.jsonl.{}", self.counts.rotations);
                fs::rename(self.path("events.jsonl"), self.path(&away)).unwrap();
                if self.counts.rotations.is_multiple_of(2) {
                    signal(life.child.as_ref().unwrap(), "HUP");
                    let log = self.path("events.jsonl");
                    wait_until("a log after SIGHUP", || log.exists());
                }
                self.feed(2 * BLOCK);
                self.take_log(&away);
            }
            2 => {
                // The second name keeps what is in the file that is deleted.
                self.counts.deletions += 1;
                let away = format!("events.jsonl.deleted.{}", self.counts.deletions);
                fs::hard_link(self.path("events.jsonl"), self.path(&away)).unwrap();
                fs::remove_file(self.path("events.jsonl")).unwrap();
                self.feed(2 * BLOCK);
                self.take_log(&away);
            }
            3 => {
                self.counts.full_disks += 1;
                self.feed(BLOCK);
                fill(&self.path("events.jsonl"), &self.path("filler"));
                let (metrics, mut since) = (self.metrics, Instant::now());
                self.feed_until(|_| {
                    let is_due = since.elapsed() > Duration::from_millis(200);
                    if is_due {
                        since = Instant::now();
                    }
                    is_due && metric(metrics, "ballrace_seconds_not_written") >= 2.0
                })
                .close();
                if self.counts.full_disks.is_multiple_of(2) {
                    self.kill(life);
                    // A file that the monitor gave up has left space.
                    fill_pages(&self.path("filler.more"));
                    self.start_on_full_disk();
                    fs::remove_file(self.path("filler.more")).unwrap();
                    fs::remove_file(self.path("filler")).unwrap();
                    *life = self.start();
                } else {
                    fs::remove_file(self.path("filler")).unwrap();
                }
            }
            4 | 5 => {
                // The clock of the samples steps: the source counts from another number, weeks away.
                self.counts.restarted_counts += 1;
                // No earlier connection has sent samples beyond those of this one.
                let sent = self.rig.sent.load(Ordering::SeqCst);
                let connection = self.feed_until(|rig| rig.acknowledged() >= sent);
                // An acknowledgement on the connection before may have come after this one began.
                let first = self.rig.disconnect(connection).max(self.rig.acknowledged());
                let by = (30 * DAY + self.below(30 * DAY)) as u32;
                let number = self.rig.first_number.get();
                let is_forward = self.counts.restarted_counts.is_multiple_of(2);
                let next = if is_forward { number.wrapping_add(by) } else { number.wrapping_sub(by) };
                self.rig.first_number.set(next);
                self.rig.feed_from(first, u64::MAX, PATIENCE, |rig| rig.acknowledged() > first + BLOCK).close();
            }
            6.. if life.has_clock => {
                self.counts.clock_steps += 1;
                let offsets = ["+1h", "-2h", "+40d", "+0"];
                self.rig.sandbox.put("clock", offsets[self.counts.clock_steps as usize % offsets.len()]);
            }
            _ => {
                // The source is silent on its connection, and makes another one.
                self.counts.reconnections += 1;
                drop(self.feed_open(BLOCK));
            }
        }
        self.feed(samples);
        self.look_at_page();
        self.measure(life);
        self.take_seconds();
    }

    /// A monitor does not start on a full disk.
    fn start_on_full_disk(&mut self) {
        let mut life = self.start();
        let output = ended(life.child.take().unwrap());
        let err = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(1) && err.contains("cannot be written"), "{:?} {err}", output.status);
    }

    fn kill(&mut self, life: &mut Life) {
        self.counts.kills += 1;
        self.measure(life);
        std::thread::sleep(Duration::from_secs_f64(0.05 * self.random.next()));
        kill(life.child.take().unwrap());
        // What the monitor acknowledged before is under way.
        std::thread::sleep(Duration::from_millis(20));
    }

    /// Damages a file of a monitor that does not run.
    fn damage(&mut self) {
        let (choice, state) = (self.below(12) as usize, self.path("state/state.json"));
        if let Some(damage) = DAMAGES.get(choice) {
            self.counts.damages += 1;
            fs::write(&state, damage(fs::read(&state).unwrap())).unwrap();
        }
        let (log, journal) = (self.path("events.jsonl"), self.path("trend/indicators.journal"));
        let append = |path: &Path, text: &[u8]| {
            fs::OpenOptions::new().append(true).open(path).unwrap().write_all(text).unwrap();
        };
        match choice {
            4 => append(&log, b"{\"schema\":\"ballrace-event-"),
            5 => append(&journal, b"99900,1.0e0,"),
            6 => {
                self.counts.damages += 1;
                append(&journal, b"\x00\x01garbage,,\n");
            }
            7 => fs::write(self.path("state/state.json.copy"), "{\"cut").unwrap(),
            _ => {}
        }
    }

    /// Memory and files now.
    fn measure(&mut self, life: &Life) {
        if let Some(resident) = memory(life.id(), "VmHWM") {
            self.largest = self.largest.max(resident);
        }
        let all = files(&self.path(""));
        self.most_files = self.most_files.max(all.len());
        for (path, bytes) in all {
            let name = path.file_name().unwrap().to_str().unwrap();
            let kind = name.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.').replace(char::is_numeric, "");
            let most = self.most_bytes.entry(kind).or_default();
            *most = (*most).max(bytes);
        }
    }

    /// Takes a log that was rotated away.
    fn take_log(&mut self, name: &str) {
        self.log.extend(fs::read_to_string(self.path(name)).unwrap().lines().map(str::to_owned));
        fs::remove_file(self.path(name)).unwrap();
    }

    /// Takes the seconds of all indicator files except the last one, which the journal may still have after a kill.
    fn take_seconds(&mut self) {
        let mut all: Vec<PathBuf> =
            fs::read_dir(self.path("trend")).unwrap().map(|entry| entry.unwrap().path()).collect();
        all.retain(|path| path.extension().is_some_and(|extension| extension == "parquet"));
        all.sort();
        all.pop();
        for path in all {
            self.add_seconds(&path);
            fs::remove_file(path).unwrap();
        }
    }

    /// Each second follows on the one before, with the samples that the source did not lose.
    fn add_seconds(&mut self, path: &Path) {
        for (time, samples) in seconds_of(path) {
            let first = self.seconds * RATE;
            let expected = (first..first + RATE).filter(|index| !is_lost(*index)).count();
            self.seconds += 1;
            let (found, expected) = ((time, samples), (self.seconds as f64, expected as f64));
            let last = || {
                let log = fs::read_to_string(self.path("events.jsonl")).unwrap_or_default();
                log.lines().skip(log.lines().count().saturating_sub(25)).collect::<Vec<_>>().join("\n")
            };
            assert!(
                found == expected,
                "{found:?} is not {expected:?}: {} {:?}\n{}",
                path.display(),
                self.counts,
                last()
            );
        }
    }

    /// Lives one after the other until `end` samples are acknowledged. One of them lasts from `long.start` to
    /// `long.end`: memory after its first day and at its end, MiB.
    fn run(&mut self, long: std::ops::Range<u64>, end: u64) -> [f64; 2] {
        let mut resident = [0.0; 2];
        while self.rig.acknowledged() < end || !self.has_alarm {
            assert!(self.rig.acknowledged() < end + DAY, "the fault is not found");
            let mut life = self.start();
            if long.contains(&self.rig.acknowledged()) {
                self.feed(DAY.min((long.end - long.start) / 8));
                self.measure(&life);
                resident[0] = memory(life.id(), "VmRSS").unwrap();
                while self.rig.acknowledged() < long.end {
                    self.episode(&mut life);
                    resident[1] = memory(life.id(), "VmRSS").unwrap();
                }
            } else if self.below(4) == 0 {
                self.counts.kills_during_start += 1;
                let time = Duration::from_secs_f64(0.6 * self.random.next());
                let since = Instant::now();
                self.feed_until(|_| since.elapsed() > time).close();
            } else {
                self.feed(BLOCK);
                self.look_at_page();
                (0..1 + self.below(4)).for_each(|_| self.episode(&mut life));
                // A diagnosis takes a time of this computer: it is not cut off again and again.
                while self.rig.acknowledged() > self.fault && !self.has_alarm && self.rig.acknowledged() < end + DAY {
                    self.episode(&mut life);
                }
            }
            if self.below(10) == 0 {
                self.counts.ends_by_signal += 1;
                self.end(life);
            } else {
                self.kill(&mut life);
            }
            self.damage();
            self.progress();
        }
        resident
    }

    fn progress(&self) {
        let days = self.rig.acknowledged() as f64 / DAY as f64;
        println!("day {days:.2}: {:?}, {:.0} MiB, alarm {}", self.counts, self.largest, self.has_alarm);
    }

    /// Ends a monitor by a signal: it has written everything.
    fn end(&mut self, mut life: Life) {
        signal(life.child.as_ref().unwrap(), "TERM");
        let output = ended(life.child.take().unwrap());
        let err = String::from_utf8_lossy(&output.stderr);
        // It had no sample since its start.
        if output.status.code() == Some(1) && err.contains("no sample") {
            return;
        }
        assert!(matches!(output.status.code(), Some(0 | 3)), "{:?} {err}", output.status);
        let outcome: Value = serde_json::from_slice(&output.stdout).unwrap();
        for count in ["seconds_not_written", "events_not_written"] {
            assert_eq!(number(&outcome, &format!("/timing/outputs/{count}")), 0.0, "{count}");
        }
    }

    /// The events of all logs, each once: one that was written before a rotation and a kill may be repeated, equal to
    /// the byte.
    fn events(&mut self) -> (Vec<Value>, usize) {
        self.take_log("events.jsonl");
        let (mut known, mut events, mut repeated) = (BTreeSet::new(), vec![], 0);
        for line in self.log.iter().filter(|line| !line.trim().is_empty()) {
            if known.insert(line) {
                events.push(serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}")));
            } else {
                repeated += 1;
            }
        }
        (events, repeated)
    }

    /// Each shock has its two events, in order, and there are no others of limits. The last block may not be complete.
    fn assert_limits(&self, events: &[Value]) -> usize {
        let end = self.seconds as f64;
        let block = (BLOCK + RATE) as f64 / RATE as f64;
        let shocks = (0..self.seconds * RATE).filter(|index| is_shock(*index) && !is_lost(*index));
        let shocks: Vec<f64> = shocks.map(|index| index as f64 / RATE as f64).collect();
        for kind in ["limit-crossed", "limit-ended"] {
            let starts: Vec<f64> =
                events.iter().filter(|event| event["kind"] == kind).map(|event| number(event, "/start_s")).collect();
            let is_of = |(start, shock): (&f64, &f64)| (shock - block..=*shock).contains(start);
            let wrong = starts.iter().zip(&shocks).find(|pair| !is_of(*pair));
            assert!(wrong.is_none(), "{kind}: start and shock {wrong:?}");
            let rest = shocks.get(starts.len()..).unwrap_or_default();
            assert!(
                starts.len() <= shocks.len() && rest.iter().all(|shock| shock + 2.0 * block > end),
                "{kind}: {rest:?}"
            );
        }
        shocks.len()
    }
}

/// Kinds of events without a cause in the machine.
const OF_THE_RUN: [&str; 11] = [
    "source-connected",
    "source-gone",
    "source-replaced",
    "source-silent",
    "source-speaks",
    "source-counts-anew",
    "backlog-full",
    "backlog-ended",
    "output-failing",
    "output-recovered",
    "monitor-resumed",
];

/// Runs `days` days; the fault begins after two thirds of them.
fn assert_month(days: f64) {
    if !can_mount() {
        return;
    }
    let begun = Instant::now();
    let end = (days * DAY as f64) as u64;
    let fault = end * 2 / 3;
    let (mut month, _disk) = Month::new(fault);
    let stop = Arc::new(AtomicBool::new(false));
    let of_page = std::thread::spawn({
        let (stop, page) = (stop.clone(), month.page);
        move || clients(page, &stop)
    });
    let [after_a_day, at_end] = month.run(end / 3..end * 3 / 5, end);
    stop.store(true, Ordering::SeqCst);
    let visits = of_page.join().unwrap();
    let life = month.start();
    month.feed(2 * BLOCK);
    // A user acknowledges the alarm.
    let body = serde_json::json!({ "alarm": FAULT }).to_string();
    let head = "POST /acknowledge HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer";
    let mut client = connected(month.page);
    write!(client, "{head} {TOKEN}\r\nContent-Length: {}\r\n\r\n{body}", body.len()).unwrap();
    let mut answer = String::new();
    client.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 202"), "{answer}");
    month.feed(2 * BLOCK);
    month.measure(&life);
    month.end(life);
    let acknowledged = month.rig.acknowledged();
    month.take_seconds();
    let last: Vec<PathBuf> = files(&month.path("trend")).into_iter().map(|(path, _)| path).collect();
    for path in last.iter().filter(|path| path.extension().is_some_and(|extension| extension == "parquet")) {
        month.add_seconds(path);
    }
    assert!(month.seconds >= acknowledged / RATE, "{} of {} seconds", month.seconds, acknowledged / RATE);
    let (events, repeated) = month.events();
    let shocks = month.assert_limits(&events);
    let mut kinds: BTreeMap<&str, u32> = BTreeMap::new();
    events.iter().for_each(|event| *kinds.entry(event["kind"].as_str().unwrap()).or_default() += 1);
    let counts = &month.counts;
    println!("{kinds:#?}");
    for (kind, count) in &kinds {
        let expected = match *kind {
            kind if OF_THE_RUN.contains(&kind) || kind.starts_with("limit-") || kind == "fault-size" => continue,
            "fault-found" | "alarm-acknowledged" => 1,
            "file-damaged" => counts.damages,
            _ => 0,
        };
        assert_eq!(*count, expected, "{kind}");
    }
    let found = events.iter().find(|event| event["kind"] == "fault-found").unwrap();
    let delay = number(found, "/time_s") - fault as f64 / RATE as f64;
    assert!(delay > 0.0 && found["sentence"].as_str().unwrap().contains("Outer race of DE"), "{found:#}");
    let seconds = begun.elapsed().as_secs_f64();
    println!(
        "{:.2} days, {acknowledged} samples, {} seconds of indicators, {} events, {repeated} repeated, {shocks} shocks",
        acknowledged as f64 / DAY as f64,
        month.seconds,
        events.len(),
    );
    println!("{counts:?}, {visits} clients of the page");
    println!("fault found {:.2} h after its begin", delay / 3600.0);
    println!(
        "memory: largest {:.0} MiB; without a kill {after_a_day:.0} MiB after a day, {at_end:.0} MiB at the end",
        month.largest
    );
    println!("files: {} at most, largest in bytes {:?}", month.most_files, month.most_bytes);
    assert!(month.largest < 400.0, "{} MiB", month.largest);
    assert!(at_end < 1.2 * after_a_day + 20.0, "memory grows from {after_a_day} to {at_end} MiB");
    assert!(month.most_files < 50, "{} files", month.most_files);
    for (kind, most) in [("state.json", 64 << 10), ("events.jsonl", 1 << 20), ("indicators.journal", 16 << 20)] {
        assert!(month.most_bytes[kind] < most, "{kind}: {}", month.most_bytes[kind]);
    }
    println!("{seconds:.0} s, {:.0} times real time", acknowledged as f64 / RATE as f64 / seconds);
}

#[test]
#[ignore = "slow: some minutes; tests/run --all runs it"]
fn a_month_with_all_that_happens() {
    let days = std::env::var("BALLRACE_TEST_DAYS").map_or(30.0, |days| days.parse().unwrap());
    assert_month(days);
}

/// A source of a slow machine sends an hour that it has kept: the monitor does not take it one sample after the other.
#[test]
fn an_hour_of_a_slow_machine_is_followed_in_seconds() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene(NOISE, 1.0 / RATE as f64, ""));
    let machine = Machine::new(&sandbox, u64::MAX);
    let options = ["--state", "state", "--events", "events.jsonl", "--no-report"];
    let rig = Rig::with(sandbox, Box::new(move |index| machine.readings(index)), WINDOW, &options);
    let mut life = Life { child: Some(rig.start()), has_clock: false };
    let begun = Instant::now();
    rig.feed(u64::MAX, |rig| rig.acknowledged() >= WINDOW);
    let seconds = begun.elapsed().as_secs_f64();
    signal(life.child.as_ref().unwrap(), "TERM");
    ended(life.child.take().unwrap());
    println!("an hour in {seconds:.1} s");
    // With a block of a quarter of a second every 10 ms it would be 96 s.
    assert!(seconds < 50.0, "{seconds} s");
}
