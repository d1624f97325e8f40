//! Sources that are not what they should be: foreign, vanished, changed, restarted, corrupted.

use crate::live::{connected, endless, frame, kinds, kinds_so_far, listening, outcome, rows, sandbox, source};
use crate::live_start::{terminate, wait, wait_for_event};
use crate::support::{DEMO_SCENE, HEALTHY_RECORDING, Sandbox, number, program, short_recording, swap};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The scene with outer rings that turn: such a machine is not diagnosed, which spares the processor where the source is the subject.
fn undiagnosed(scene: &str) -> String {
    swap(scene, "[shaft]\n", "[shaft]\nouter_speed = \"1 rpm\"\n")
}

/// Writes what a monitor may no longer want.
fn offer(stream: &mut TcpStream, bytes: &[u8]) {
    let _ = stream.write_all(bytes);
}

/// A request of HTTP, and the end of the connection.
fn foreign(port: u16) {
    let mut stream = connected(port);
    offer(&mut stream, b"GET / HTTP/1.1\r\nHost: x\r\n\r\n");
    let _ = stream.shutdown(std::net::Shutdown::Write);
    let _ = stream.read_to_end(&mut vec![]);
}

#[test]
fn foreign_connections_are_logged_and_the_next_one_is_followed() {
    let sandbox = Sandbox::with(&undiagnosed(DEMO_SCENE), HEALTHY_RECORDING);
    let (child, port) = listening(&sandbox, "tcp", &["--for", "1.9 s", "--events", "events.jsonl"]);
    drop(connected(port));
    foreign(port);
    let mut stream = connected(port);
    offer(&mut stream, HEALTHY_RECORDING.as_bytes());
    drop(stream);
    foreign(port);
    let mut stream = connected(port);
    offer(&mut stream, HEALTHY_RECORDING.as_bytes());
    let outcome = outcome(child);
    assert!(number(&outcome, "/record/samples") > 24_000.0);
    let kinds = kinds(&sandbox, "events.jsonl");
    assert_eq!(kinds.iter().filter(|kind| *kind == "source-refused").count(), 3, "{kinds:?}");
}

#[test]
fn a_source_that_vanished_does_not_block_its_successor() {
    let sandbox = Sandbox::with(&undiagnosed(DEMO_SCENE), HEALTHY_RECORDING);
    let (child, port) =
        listening(&sandbox, "tcp", &["--encoding", "frames", "--for", "1.9 s", "--events", "events.jsonl"]);
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    let mut vanished = connected(port);
    (0..12_800).for_each(|sequence| vanished.write_all(&frame_of(sequence)).unwrap());
    // Its end never comes.
    let mut successor = connected(port);
    (12_800..25_600).for_each(|sequence| successor.write_all(&frame_of(sequence)).unwrap());
    let outcome = outcome(child);
    assert!(number(&outcome, "/record/samples") > 24_000.0);
    assert_eq!((source(&outcome, "connections"), source(&outcome, "lost_frames")), (2.0, 0.0));
    let kinds = kinds(&sandbox, "events.jsonl");
    assert!(kinds.contains(&"source-replaced".to_owned()), "{kinds:?}");
    drop(vanished);
}

/// The link of a source is cut, so neither its end nor an answer to a keepalive probe ever comes.
#[cfg(target_os = "linux")]
#[test]
fn a_source_behind_a_dead_link_is_given_up() {
    let may_isolate = Command::new("unshare").args(["-rn", "ip", "link", "show", "lo"]).output();
    if !may_isolate.is_ok_and(|output| output.status.success()) {
        println!("omitted: no network namespace here (unshare -rn ip)");
        return;
    }
    let sandbox = Sandbox::with(&undiagnosed(DEMO_SCENE), HEALTHY_RECORDING);
    sandbox.put("head.csv", short_recording(6_400));
    let script = r#"
        ip link set lo up
        "$@" &
        monitor=$!
        trap 'kill $monitor' EXIT
        listens() { (exec 3<>/dev/tcp/127.0.0.1/9000) 2>/dev/null; }
        has_event() { grep -q "\"kind\":\"$1\"" events.jsonl; }
        until listens; do sleep 0.1; done
        exec 3<>/dev/tcp/127.0.0.1/9000
        cat head.csv >&3
        until has_event source-silent; do sleep 0.1; done
        ip link set lo down
        until has_event source-gone; do sleep 0.1; done
        ip link set lo up
        exec 4<>/dev/tcp/127.0.0.1/9000
        cat healthy.csv >&4
        trap - EXIT
        wait $monitor
    "#;
    let mut command = Command::new("unshare");
    command.args(["-rn", "bash", "-c", script, "bash"]).arg(program());
    command.args(["replay", "scene.toml", "--paced", "--format", "json", "--source", "tcp:9000"]);
    command.args(["--for", "1.4 s", "--events", "events.jsonl"]).current_dir(sandbox.path(""));
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let outcome = outcome(child);
    assert_eq!(source(&outcome, "connections"), 2.0);
    let longest = source(&outcome, "longest_stall_s");
    assert!((10.0..40.0).contains(&longest), "{longest}");
}

/// A source that leaves its acknowledgements unread, with little room for them, stays connected. With room for a single byte the
/// system of the source drops what confirms its own samples, and the connection stalls.
#[cfg(target_os = "linux")]
#[test]
fn a_source_that_reads_no_acknowledgements_stays_connected() {
    use crate::frames_source::{RATE, Rig, scene};
    let rig = Rig::new(&["--state", "state", "--events", "events.jsonl"]);
    rig.sandbox.put("scene.toml", undiagnosed(&scene()));
    let child = rig.start();
    drop(rig.connect());
    let stream = socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::STREAM, None).unwrap();
    stream.set_recv_buffer_size(16_384).unwrap();
    stream.connect(&SocketAddr::from(([127, 0, 0, 1], rig.port)).into()).unwrap();
    let mut stream = TcpStream::from(stream);
    let since = Instant::now();
    let mut index = 0;
    // For longer than a vanished source stays connected, at twice real time.
    while since.elapsed() < Duration::from_secs(45) {
        let sent = (index..index + RATE / 50).try_for_each(|sample| stream.write_all(&rig.frame(sample)));
        if let Err(error) = sent {
            let (after, events) = (since.elapsed(), rig.sandbox.read("events.jsonl"));
            terminate(child.id());
            panic!("{error} after {after:?}: {events}{:?}", crate::live_start::ended(child));
        }
        index += RATE / 50;
        std::thread::sleep(Duration::from_millis(10));
    }
    terminate(child.id());
    assert_eq!(source(&outcome(child), "connections"), 1.0);
}

/// Datagrams at many times the rate of the scene, while the twin is started.
#[test]
fn a_monitor_slower_than_its_source_reports_what_it_skips() {
    let sandbox = Sandbox::with(
        &swap(&undiagnosed(DEMO_SCENE), "[recording]", "[integration]\nstep = \"40 us\"\n\n[recording]"),
        "",
    );
    let (child, port) = listening(&sandbox, "udp", &["--encoding", "frames", "--events", "events.jsonl"]);
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let to: SocketAddr = ([127, 0, 0, 1], port).into();
    while socket.send_to(b"x", to).is_err() || UdpSocket::bind(to).is_ok() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut sequence = 0;
    wait("dropped samples", || {
        for _ in 0..50 {
            let datagram: Vec<u8> = (sequence..sequence + 32).flat_map(&frame_of).collect();
            socket.send_to(&datagram, to).unwrap();
            sequence += 32;
        }
        let text = std::fs::read_to_string(sandbox.path("events.jsonl")).ok()?;
        text.contains("\"kind\":\"samples-dropped\"").then_some(())
    });
    terminate(child.id());
    let outcome = outcome(child);
    let dropped = source(&outcome, "dropped_rows");
    let text = sandbox.read("events.jsonl");
    assert!(text.contains("\"kind\":\"backlog-full\""), "{text}");
    let last = text.lines().rfind(|line| line.contains("samples-dropped")).unwrap();
    assert!(last.contains(&format!(" {dropped} since the start")), "{dropped}: {last}");
}

/// A connection with another request does not end the source that pauses.
#[test]
fn a_foreign_connection_does_not_replace_a_source_that_pauses() {
    let sandbox = sandbox();
    let (child, port) = listening(&sandbox, "tcp", &["--for", "0.9 s", "--events", "events.jsonl"]);
    let (head, tail) = HEALTHY_RECORDING.split_at(HEALTHY_RECORDING.len() / 2);
    let mut stream = connected(port);
    stream.write_all(head.as_bytes()).unwrap();
    wait_for_event(&sandbox, "events.jsonl", "source-connected");
    foreign(port);
    wait_for_event(&sandbox, "events.jsonl", "source-refused");
    stream.write_all(tail.as_bytes()).unwrap();
    let outcome = outcome(child);
    assert_eq!(source(&outcome, "connections"), 1.0);
    assert!(number(&outcome, "/record/samples") > 11_500.0);
}

/// The demonstration's recording with time stamps of another rate from another beginning.
fn stamped(rate: f64, begin: f64) -> String {
    let line = |(i, line): (usize, &str)| match line.split_once(',') {
        Some((_, rest)) if i > 0 => format!("{:.9},{rest}\n", begin + (i - 1) as f64 / rate),
        _ => line.to_owned() + "\n",
    };
    short_recording(6_400).lines().enumerate().map(line).collect()
}

#[test]
fn a_source_that_returns_with_another_rate_is_refused() {
    let scene = swap(DEMO_SCENE, "rate = \"12.8 kHz\"", "time = \"time_s\"");
    let sandbox = Sandbox::with(&scene, &short_recording(2048));
    let (child, port) = listening(&sandbox, "tcp", &["--events", "events.jsonl"]);
    let send = |text: &str, events: usize| {
        let mut stream = connected(port);
        offer(&mut stream, text.as_bytes());
        drop(stream);
        wait("the end of a connection", || {
            let ends = |kind: &&String| matches!(kind.as_str(), "source-gone" | "source-refused");
            (kinds_so_far(&sandbox, "events.jsonl").iter().filter(ends).count() == events).then_some(())
        });
    };
    send(&stamped(12_800.0, 1000.0), 1);
    send(&stamped(25_600.0, 2000.0), 2);
    send(&swap(&stamped(12_800.0, 3000.0), "DE_X_um", "DE_Z_um"), 3);
    send(&stamped(12_800.0, 4000.0), 4);
    terminate(child.id());
    let outcome = outcome(child);
    assert_eq!(number(&outcome, "/record/samples"), 12_800.0);
    // Time goes on from the last sample and never back.
    assert!((number(&outcome, "/record/duration_s") - 12_799.0 / 12_800.0).abs() < 1e-4);
    let text = sandbox.read("events.jsonl");
    let refused: Vec<&str> = text.lines().filter(|line| line.contains("source-refused")).collect();
    assert!(refused.len() == 2 && refused[0].contains("Hz") && refused[1].contains("DE_X_um"), "{refused:?}");
}

#[test]
fn a_source_that_counts_from_0_again_is_followed() {
    let sandbox = Sandbox::with(&undiagnosed(DEMO_SCENE), HEALTHY_RECORDING);
    let (child, port) =
        listening(&sandbox, "tcp", &["--encoding", "frames", "--for", "3.4 s", "--events", "events.jsonl"]);
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    for count in [30_000, 15_000] {
        let mut stream = connected(port);
        (0..count).for_each(|sequence| offer(&mut stream, &frame_of(sequence)));
    }
    let outcome = outcome(child);
    assert!(number(&outcome, "/record/samples") > 43_500.0);
    assert_eq!((source(&outcome, "repeated_frames"), source(&outcome, "lost_frames")), (0.0, 0.0));
    let kinds = kinds(&sandbox, "events.jsonl");
    assert_eq!(kinds.iter().filter(|kind| *kind == "source-counts-anew").count(), 1, "{kinds:?}");
}

/// Where the restart falls within what a source may repeat, its pace shows that the samples are new.
#[test]
fn a_source_that_restarts_soon_is_recognised_by_its_pace() {
    let sandbox = sandbox();
    let (child, port) = listening(&sandbox, "tcp", &["--encoding", "frames", "--events", "events.jsonl"]);
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    let mut stream = connected(port);
    (0..12_800).for_each(|sequence| offer(&mut stream, &frame_of(sequence)));
    drop(stream);
    let mut stream = connected(port);
    let since = Instant::now();
    // In real time, until the monitor has noticed.
    for sequence in 0..12_000 {
        offer(&mut stream, &frame_of(sequence));
        if sequence % 128 == 0 {
            let due = Duration::from_secs_f64(f64::from(sequence) / 12_800.0);
            std::thread::sleep(due.saturating_sub(since.elapsed()));
        }
    }
    drop(stream);
    wait("both ends", || {
        (kinds(&sandbox, "events.jsonl").iter().filter(|k| *k == "source-gone").count() == 2).then_some(())
    });
    terminate(child.id());
    let outcome = outcome(child);
    let repeated = source(&outcome, "repeated_frames");
    assert!(repeated > 0.0 && repeated < 6_400.0, "{repeated}");
    assert_eq!(source(&outcome, "rows") + repeated, 24_800.0);
}

#[test]
fn wrong_frames_do_not_advance_the_twin() {
    let sandbox = sandbox();
    let (child, port) =
        listening(&sandbox, "udp", &["--encoding", "frames", "--for", "0.9 s", "--events", "events.jsonl"]);
    let rows = rows(12_800);
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let to: SocketAddr = ([127, 0, 0, 1], port).into();
    while socket.send_to(b"x", to).is_err() || UdpSocket::bind(to).is_ok() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut random = 0x2545_f491_u32;
    for (i, block) in rows.chunks(32).enumerate() {
        let first = i * 32;
        let datagram: Vec<u8> = block.iter().enumerate().flat_map(|(k, row)| frame((first + k) as u32, row)).collect();
        socket.send_to(&datagram, to).unwrap();
        // A wrong number and wrong readings.
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        socket.send_to(&frame((1 << 20) + (random >> 1), &[1e30; 6]), to).unwrap();
        if i % 50 == 49 {
            std::thread::sleep(Duration::from_millis(50));
        }
    }
    let outcome = outcome(child);
    assert!(source(&outcome, "lost_frames") < 1_000.0, "{}", source(&outcome, "lost_frames"));
    assert!(source(&outcome, "malformed_frames") > 300.0);
    assert!(number(&outcome, "/probes/0/measured/peak_to_peak_um") < 1e3);
    assert!(kinds(&sandbox, "events.jsonl").len() < 10, "{}", sandbox.read("events.jsonl"));
}

/// A frame of the second version: its CRC-32 at its end.
fn checked(sequence: u32, row: &[f32]) -> Vec<u8> {
    let mut frame = frame(sequence, row);
    let crc = crc32(&frame);
    frame.extend(crc.to_le_bytes());
    frame
}

/// CRC-32 of IEEE 802.3, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let bit = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 };
    let byte = |crc: u32, byte: &u8| (0..8).fold(crc ^ u32::from(*byte), |crc, _| bit(crc));
    !bytes.iter().fold(!0, byte)
}

#[test]
fn frames_with_a_checksum_are_checked() {
    assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    let sandbox = sandbox();
    let (child, port) =
        listening(&sandbox, "tcp", &["--encoding", "frames-crc", "--for", "0.9 s", "--events", "events.jsonl"]);
    let (rows, mut stream) = (rows(12_800), connected(port));
    for sequence in 0..12_800 {
        let mut frame = checked(sequence, &rows[sequence as usize]);
        if sequence == 4_000 {
            // A reading changed in transit.
            frame[9] ^= 0x40;
        }
        if sequence == 6_000 {
            // A byte lost: the frames after it are found again.
            frame.remove(5);
        }
        offer(&mut stream, &frame);
    }
    let outcome = outcome(child);
    assert_eq!((source(&outcome, "lost_frames"), source(&outcome, "malformed_frames")), (2.0, 2.0));
    assert_eq!(kinds(&sandbox, "events.jsonl"), ["source-connected"]);
}

#[test]
fn events_of_one_kind_are_limited_in_number() {
    let sandbox = sandbox();
    let (child, port) =
        listening(&sandbox, "tcp", &["--encoding", "frames", "--for", "0.9 s", "--events", "events.jsonl"]);
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    // 170 connections within the 0.9 s; the last one sends on until the monitor ends.
    for i in 0..170 {
        let mut stream = connected(port);
        let end = if i < 169 { (i + 1) * 64 } else { 12_800 };
        (i * 64..end).for_each(|sequence| offer(&mut stream, &frame_of(sequence)));
    }
    let outcome = outcome(child);
    assert!(source(&outcome, "connections") > 120.0);
    let kinds = kinds(&sandbox, "events.jsonl");
    assert!(kinds.len() < 40, "{}", kinds.len());
    let notes = outcome["notes"].to_string();
    assert!(notes.contains("source-connected"), "{notes}");
}
