//! The monitor in real time: sources that stall, burst, repeat, lose, die and come back; the monitor killed and started again.

use crate::support::{DEMO_SCENE, Sandbox, list, number, short_recording, sound, swap};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::process::Child;
use std::time::{Duration, Instant};

/// Rows of the demonstration's recording as frames hold them: five probes and the keyphasor.
pub fn rows(samples: usize) -> Vec<Vec<f32>> {
    let cells = |line: &str| line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
    short_recording(samples).lines().skip(1).map(cells).collect()
}

pub fn frame(sequence: u32, row: &[f32]) -> Vec<u8> {
    let mut frame = sequence.to_le_bytes().to_vec();
    row.iter().for_each(|value| frame.extend(value.to_le_bytes()));
    frame
}

/// The demonstration's recording over and over; its 50 turns follow on each other.
pub fn endless(rows: &[Vec<f32>]) -> impl Fn(u32) -> Vec<u8> {
    |sequence| frame(sequence, &rows[sequence as usize % rows.len()])
}

/// A port that nobody has.
pub fn port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// A connection to a monitor as soon as it listens.
pub fn connected(port: u16) -> TcpStream {
    let since = Instant::now();
    loop {
        match TcpStream::connect(("127.0.0.1", port)) {
            Ok(stream) => return stream,
            Err(error) if since.elapsed() > Duration::from_secs(120) => panic!("nobody listens: {error}"),
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
    }
}

pub fn monitor(sandbox: &Sandbox, more: &[&str]) -> Child {
    let args = [&["replay", "scene.toml", "--paced", "--format", "json"], more].concat();
    sandbox.command(&args).spawn().unwrap()
}

/// A monitor that listens at a free port for `protocol` (`tcp` or `udp`), and the port.
pub fn listening(sandbox: &Sandbox, protocol: &str, more: &[&str]) -> (Child, u16) {
    let port = port();
    let source = format!("{protocol}:{port}");
    (monitor(sandbox, &[&["--source", &source], more].concat()), port)
}

pub fn outcome(child: Child) -> Value {
    let output = crate::live_start::ended(child);
    let err = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 3)), "{:?} {err}", output.status);
    // Without a display the monitor states how it is.
    assert!(err.lines().all(|line| line.starts_with("State at ")), "{err}");
    serde_json::from_slice(&output.stdout).unwrap()
}

pub fn sandbox() -> Sandbox {
    Sandbox::with(DEMO_SCENE, &short_recording(12_800))
}

pub fn source(outcome: &Value, count: &str) -> f64 {
    number(outcome, &format!("/timing/source/{count}"))
}

/// The kinds of the events in a log, in order.
pub fn kinds(sandbox: &Sandbox, log: &str) -> Vec<String> {
    sandbox.read(log).lines().map(kind).collect()
}

/// The kinds of the complete events in the log of a monitor that runs. It listens before it creates the log.
pub fn kinds_so_far(sandbox: &Sandbox, log: &str) -> Vec<String> {
    let text = std::fs::read_to_string(sandbox.path(log)).unwrap_or_default();
    text.split_inclusive('\n').filter(|line| line.ends_with('\n')).map(kind).collect()
}

fn kind(event: &str) -> String {
    serde_json::from_str::<Value>(event).unwrap()["kind"].as_str().unwrap().to_owned()
}

#[test]
fn frames_lost_repeated_and_of_a_wrong_size_are_counted() {
    let sandbox = sandbox();
    let (child, port) = listening(&sandbox, "tcp", &["--encoding", "frames", "--for", "0.9 s"]);
    let (rows, mut stream) = (rows(12_800), connected(port));
    for sequence in 0..12_800 {
        // 40 are lost, 10 come twice.
        if (5000..5040).contains(&sequence) {
            continue;
        }
        let times = if (7000..7010).contains(&sequence) { 2 } else { 1 };
        for _ in 0..times {
            // The monitor may have had enough of it.
            let _ = stream.write_all(&frame(sequence, &rows[sequence as usize]));
        }
    }
    let outcome = outcome(child);
    assert_eq!((source(&outcome, "lost_frames"), source(&outcome, "repeated_frames")), (40.0, 10.0));
    assert_eq!(source(&outcome, "connections"), 1.0);
    let flaws = list(&outcome, "flaws");
    assert!(flaws.iter().any(|f| f["kind"] == "gap" && f["samples_affected"] == 40), "{flaws:#?}");
    assert_eq!(list(&outcome, "findings").len(), 0);
    // The received samples give the outcome of the file.
    let one_x = |outcome: &Value| number(outcome, "/probes/0/measured/one_x_um");
    assert!((one_x(&outcome) / one_x(sound()) - 1.0).abs() < 0.01);
}

#[test]
fn a_source_that_stalls_dies_and_comes_back_is_followed() {
    let (sandbox, port) = (sandbox(), port());
    let source_at = format!("tcp:{port}");
    let args = ["--source", &source_at, "--encoding", "frames", "--for", "2.2 s", "--events", "events.jsonl"];
    let child = monitor(&sandbox, &[&args[..], &["--state", "state"]].concat());
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    let send = |stream: &mut TcpStream, range: std::ops::Range<u32>| {
        range.for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    };
    let mut stream = connected(port);
    let told = acknowledged(&stream);
    send(&mut stream, 0..16_000);
    // Then the twin has started and has caught up.
    assert_eq!(told.recv_timeout(Duration::from_secs(120)), Ok(12_799));
    std::thread::sleep(Duration::from_millis(1600));
    send(&mut stream, 16_000..20_000);
    // It ends in the middle of a frame.
    stream.write_all(&frame_of(20_000)[..7]).unwrap();
    stream.shutdown(std::net::Shutdown::Both).unwrap();
    let mut stream = connected(port);
    send(&mut stream, 20_000..30_000);
    let outcome = outcome(child);
    assert_eq!((source(&outcome, "connections"), source(&outcome, "malformed_frames")), (2.0, 1.0));
    assert_eq!((source(&outcome, "lost_frames"), source(&outcome, "dropped_rows")), (0.0, 0.0));
    assert!(source(&outcome, "stalls") >= 1.0 && source(&outcome, "longest_stall_s") > 1.0);
    let kinds = kinds(&sandbox, "events.jsonl");
    let at = |kind: &str| kinds.iter().position(|k| k == kind).unwrap_or_else(|| panic!("no {kind} in {kinds:?}"));
    assert!(at("source-connected") < at("source-silent") && at("source-silent") < at("source-speaks"), "{kinds:?}");
    assert_eq!(kinds.iter().filter(|k| *k == "source-connected").count(), 2, "{kinds:?}");
}

/// Sends the acknowledged sequence numbers of a connection to a channel.
pub fn acknowledged(stream: &TcpStream) -> std::sync::mpsc::Receiver<u32> {
    let (tell, told) = std::sync::mpsc::channel();
    let lines = BufReader::new(stream.try_clone().unwrap()).lines();
    std::thread::spawn(move || {
        for line in lines.map_while(Result::ok) {
            let number = line.strip_prefix("acknowledged ").unwrap().parse().unwrap();
            let _ = tell.send(number);
        }
    });
    told
}

#[test]
fn killed_and_started_again_it_loses_nothing_that_was_acknowledged() {
    let scene =
        format!("{DEMO_SCENE}\n[[limit]]\nindicator = \"peak-to-peak\"\nprobe = \"DE_X_um\"\nmax = \"0.1 um\"\n");
    let (sandbox, port) = (Sandbox::with(&scene, &short_recording(12_800)), port());
    let source_at = format!("tcp:{port}");
    let outputs = ["--state", "state", "--events", "events.jsonl", "--indicators", "trend"];
    let args = [&["--source", &source_at, "--encoding", "frames", "--for", "60 s"][..], &outputs].concat();
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    let mut child = monitor(&sandbox, &args);
    let mut stream = connected(port);
    let told = acknowledged(&stream);
    // 3.5 s at once: much faster than the loop.
    (0..44_800).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    let mut last = 0;
    while last < 25_599 {
        last = told.recv_timeout(Duration::from_secs(120)).unwrap();
    }
    // kill -9
    child.kill().unwrap();
    child.wait().unwrap();
    last = told.try_iter().last().unwrap_or(last);
    drop(stream);
    let state: Value = serde_json::from_str(&sandbox.read("state/state.json")).unwrap();
    assert!(state["resume"]["sequence"].as_u64().unwrap() > u64::from(last), "{state} {last}");

    let args: Vec<&str> = args.iter().map(|arg| if *arg == "60 s" { "2.5 s" } else { arg }).collect();
    let child = monitor(&sandbox, &args);
    let mut stream = connected(port);
    // The source repeats a second, to be safe, and goes on.
    let again = last + 1 - 12_800;
    for sequence in again..last + 1 + 12_800 * 4 {
        if stream.write_all(&frame_of(sequence)).is_err() {
            break;
        }
    }
    let outcome = outcome(child);
    assert_eq!(source(&outcome, "lost_frames"), 0.0);
    assert!(source(&outcome, "repeated_frames") >= 12_800.0);
    let times = times(&sandbox, "trend/indicators-0001.parquet");
    let whole: Vec<f64> = (1..=times.len()).map(|i| i as f64).collect();
    assert_eq!(times, whole, "a second is missing or there twice");
    assert!(times.len() >= 4, "{times:?}");
    let kinds = kinds(&sandbox, "events.jsonl");
    assert!(kinds.contains(&"monitor-resumed".to_owned()) && kinds.contains(&"limit-crossed".to_owned()), "{kinds:?}");
    sandbox.put("other.toml", swap(&scene, "name = \"6205 rig\"", "name = \"another\""));
    let refused = sandbox.run(&["replay", "other.toml", "--paced", "--state", "state"]);
    assert!(refused.code == Some(2) && refused.err.contains("another"), "{refused:?}");
}

/// The first column of an indicators file.
pub fn times(sandbox: &Sandbox, name: &str) -> Vec<f64> {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    let reader = SerializedFileReader::new(std::fs::File::open(sandbox.path(name)).unwrap()).unwrap();
    let rows = reader.get_row_iter(None).unwrap();
    rows.map(|row| parquet::record::RowAccessor::get_double(&row.unwrap(), 0).unwrap()).collect()
}

#[test]
fn burst_of_datagrams_is_processed_or_counted() {
    let sandbox = sandbox();
    let (child, port) = listening(&sandbox, "udp", &["--encoding", "frames", "--for", "0.9 s"]);
    let rows = rows(12_800);
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let to: SocketAddr = ([127, 0, 0, 1], port).into();
    // Until the monitor listens there is nobody to hear the first ones.
    while socket.send_to(b"x", to).is_err() || UdpSocket::bind(to).is_ok() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut sent = 0;
    for (i, block) in rows.chunks(32).enumerate() {
        let first = i * 32;
        let datagram: Vec<u8> = block.iter().enumerate().flat_map(|(k, row)| frame((first + k) as u32, row)).collect();
        socket.send_to(&datagram, to).unwrap();
        sent += block.len();
        if i % 50 == 49 {
            std::thread::sleep(Duration::from_millis(50));
        }
    }
    socket.send_to(&[1, 2, 3], to).unwrap();
    let outcome = outcome(child);
    let heard = source(&outcome, "rows") + source(&outcome, "lost_frames") + source(&outcome, "dropped_rows");
    assert!(heard <= sent as f64 && heard > 0.85 * sent as f64, "{heard} of {sent}");
    assert!(source(&outcome, "malformed_frames") >= 1.0);
}

#[test]
fn lines_from_a_pipe_are_the_file() {
    let sandbox = sandbox();
    let mut command = sandbox.command(&["replay", "scene.toml", "--paced", "--format", "json", "--source", "-"]);
    let mut child = command.stdin(std::process::Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(short_recording(12_800).as_bytes()).unwrap();
    let (piped, filed) = (outcome(child), sound());
    assert_eq!((&piped["probes"], &piped["findings"]), (&filed["probes"], &filed["findings"]));
    assert_eq!(piped["record"]["samples"], filed["record"]["samples"]);
    assert_eq!(source(&piped, "rows"), 12_800.0);
}

#[test]
fn prometheus_and_only_where_asked_for() {
    let (sandbox, port, at) = (sandbox(), port(), port());
    let (source_at, at) = (format!("tcp:{port}"), at.to_string());
    let mut child = monitor(&sandbox, &["--source", &source_at, "--encoding", "frames", "--prometheus", &at]);
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    let mut stream = connected(port);
    (0..30_000).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    let since = Instant::now();
    let page = loop {
        let mut scrape = connected(at.parse().unwrap());
        scrape.write_all(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
        let mut page = String::new();
        scrape.read_to_string(&mut page).unwrap();
        // The seconds of the start are shown before the twin has passed through them, without forces.
        if (page.contains("ballrace_time_s 2") && page.contains("ballrace_bearing_FY_N{"))
            || since.elapsed() > Duration::from_secs(120)
        {
            break page;
        }
        std::thread::sleep(Duration::from_millis(100));
    };
    child.kill().unwrap();
    child.wait().unwrap();
    for metric in [
        "ballrace_probe_peak_to_peak_um{probe=\"DE_X_um\"}",
        "ballrace_bearing_FY_N{bearing=\"DE\"}",
        "# TYPE ballrace_rows_total counter",
        "ballrace_frames_lost_total 0",
    ] {
        assert!(page.contains(metric), "{metric} is not in\n{page}");
    }
}

#[test]
fn contradictory_options_are_rejected() {
    let sandbox = sandbox();
    let refused =
        |args: &[&str], parts: &[&str]| sandbox.refused(&[&["replay", "scene.toml"], args].concat(), 2, parts);
    refused(&["--source", "tcp:9"], &["--source", "--paced"]);
    refused(&["--prometheus", "9"], &["--prometheus", "--paced"]);
    sandbox.put("times.toml", swap(DEMO_SCENE, "rate = \"12.8 kHz\"", "time = \"time_s\""));
    let args = ["replay", "times.toml", "--paced", "--source", "-", "--encoding", "frames"];
    let answer = sandbox.run(&args);
    assert!(answer.code == Some(2) && answer.err.contains("rate = "), "{answer:?}");
    let answer = sandbox.run(&["watch", "scene.toml"]);
    assert!(answer.code == Some(2) && answer.err.contains("terminal"), "{answer:?}");
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let source_at = format!("tcp:{}", taken.local_addr().unwrap().port());
    let answer = sandbox.run(&["replay", "scene.toml", "--paced", "--source", &source_at]);
    assert!(answer.code == Some(1) && answer.err.contains("free port"), "{answer:?}");
}

/// The demonstration of a spall: a restart of the observer at 13 s is no event, and the wait for the first diagnosis is seen.
#[test]
fn the_demonstration_raises_its_fault_alone_and_a_wait_is_reported_without_a_terminal() {
    let sandbox = Sandbox::empty();
    let args = ["replay", "--paced", "--source", "demonstration", "--no-report", "--events", "events.jsonl"];
    let answer = sandbox.run(&[&args[..], &["--for", "16 s"]].concat());
    let events = sandbox.read("events.jsonl");
    let kinds = events.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()["kind"].clone());
    let others: Vec<Value> = kinds.filter(|kind| !kind.as_str().unwrap().starts_with("fault-")).collect();
    assert!(others.is_empty(), "{events}");
    let states: Vec<&str> = answer.err.lines().filter(|line| line.starts_with("State at ")).collect();
    let words = ["STARTING. ", "NO VERDICT YET. ", "ALARM. "];
    assert!(!states.is_empty() && states.len() == answer.err.lines().count(), "{answer:?}");
    assert!(states.iter().all(|line| words.iter().any(|word| line.contains(word))), "{states:#?}");
}
