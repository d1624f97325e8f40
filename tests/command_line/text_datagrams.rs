//! Lines of text over UDP: whoever does not send the scene's columns is ignored, and the monitor goes on.

use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use crate::live::{kinds, listening, outcome, sandbox, source};
use crate::live_start::{terminate, wait, wait_for_event};
use crate::support::{DEMO_SCENE, Sandbox, number, short_recording, swap};

/// A sender to a monitor that listens.
fn sender(to: SocketAddr) -> UdpSocket {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    wait("a listener", || UdpSocket::bind(to).is_err().then_some(()));
    socket
}

/// Sends a text in datagrams of whole lines, not faster than they are taken.
fn send(socket: &UdpSocket, to: SocketAddr, text: &str) {
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    for (i, block) in lines.chunks(64).enumerate() {
        socket.send_to(block.concat().as_bytes(), to).unwrap();
        if i % 10 == 9 {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

fn events(sandbox: &Sandbox, kind: &str) -> usize {
    kinds(sandbox, "events.jsonl").iter().filter(|of| *of == kind).count()
}

#[test]
fn datagrams_of_other_columns_are_ignored() {
    let sandbox = sandbox();
    let (child, port) = listening(&sandbox, "udp", &["--events", "events.jsonl"]);
    let to: SocketAddr = ([127, 0, 0, 1], port).into();
    let (stranger, own) = (sender(to), sender(to));
    let other = swap(&short_recording(100), "DE_X_um", "DE_Z_um");
    stranger.send_to(other.as_bytes(), to).unwrap();
    wait_for_event(&sandbox, "events.jsonl", "source-refused");
    send(&own, to, &short_recording(3_000));
    wait_for_event(&sandbox, "events.jsonl", "source-connected");
    // Neither rows, nor text, nor the right header of another sender disturb the one that is followed.
    for foreign in ["1,2,3\n", "x", "", "GET / HTTP/1.1\r\n\r\n", other.as_str(), &short_recording(100)] {
        stranger.send_to(foreign.as_bytes(), to).unwrap();
    }
    let rest: String = short_recording(6_000).split_inclusive('\n').skip(3_001).collect();
    send(&own, to, &rest);
    wait_for_event(&sandbox, "events.jsonl", "source-silent");
    terminate(child.id());
    let outcome = outcome(child);
    assert_eq!(number(&outcome, "/record/samples"), 6_000.0);
    let log = sandbox.read("events.jsonl");
    assert_eq!(source(&outcome, "connections"), 1.0, "{log}");
    assert_eq!(events(&sandbox, "source-refused"), 7, "{log}");
}

#[test]
fn a_sender_is_read_on_after_a_wrong_cell_and_after_its_restart() {
    let sandbox = sandbox();
    let (child, port) = listening(&sandbox, "udp", &["--events", "events.jsonl"]);
    let to: SocketAddr = ([127, 0, 0, 1], port).into();
    let own = sender(to);
    send(&own, to, &short_recording(2_560));
    own.send_to(b"0,oops,0,0,0,0,0\n", to).unwrap();
    wait_for_event(&sandbox, "events.jsonl", "source-failed");
    let rest: String = short_recording(5_120).split_inclusive('\n').skip(2_561).collect();
    send(&own, to, &rest);
    wait_for_event(&sandbox, "events.jsonl", "source-silent");
    // It begins again with its header, and then another one takes its place.
    send(&own, to, &short_recording(2_560));
    wait_for_event(&sandbox, "events.jsonl", "source-speaks");
    wait("its silence", || (events(&sandbox, "source-silent") == 2).then_some(()));
    send(&sender(to), to, &short_recording(2_560));
    wait("its arrival", || (events(&sandbox, "source-speaks") == 2).then_some(()));
    wait("its silence", || (events(&sandbox, "source-silent") == 3).then_some(()));
    terminate(child.id());
    let outcome = outcome(child);
    assert_eq!(number(&outcome, "/record/samples"), 4.0 * 2_560.0);
    // Time goes on from the last sample.
    assert!((number(&outcome, "/record/duration_s") - (4.0 * 2_560.0 - 1.0) / 12_800.0).abs() < 1e-6);
    assert_eq!((events(&sandbox, "source-failed"), events(&sandbox, "source-replaced")), (1, 2));
    assert_eq!(events(&sandbox, "source-connected"), 4);
}

/// Lines at many times the rate of the scene, while the twin is started.
#[test]
fn lines_without_room_are_dropped_and_counted() {
    let step = swap(DEMO_SCENE, "[recording]", "[integration]\nstep = \"20 us\"\n\n[recording]");
    let sandbox = Sandbox::with(&step, "");
    let (child, port) = listening(&sandbox, "udp", &["--events", "events.jsonl"]);
    let to: SocketAddr = ([127, 0, 0, 1], port).into();
    let own = sender(to);
    let text = short_recording(12_800);
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    own.send_to(lines[0].as_bytes(), to).unwrap();
    let datagrams: Vec<String> = lines[1..].chunks(512).map(|lines| lines.concat()).collect();
    wait("dropped samples", || {
        for datagram in &datagrams {
            own.send_to(datagram.as_bytes(), to).unwrap();
        }
        let log = std::fs::read_to_string(sandbox.path("events.jsonl")).ok()?;
        log.contains("\"kind\":\"samples-dropped\"").then_some(())
    });
    // A stopped monitor would process what waits, for which this test does not ask.
    crate::kills::kill(child);
}
