//! The Prometheus endpoint under clients that misbehave.

use crate::frames_source::{connected, port, wait_until};
#[cfg(target_os = "linux")]
use crate::support::memory;
use crate::support::{DEMO_SCENE, Sandbox, short_recording};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A monitor that waits for its source, with an endpoint; killed at the end.
struct Endpoint {
    child: Child,
    port: u16,
    _desk: Sandbox,
}

impl Endpoint {
    /// With a limit of the descriptors, where given.
    fn start(descriptors: Option<u32>) -> Self {
        let sandbox = Sandbox::with(DEMO_SCENE, &short_recording(256));
        let (source, port) = (format!("tcp:{}", port()), port());
        let metrics = port.to_string();
        let args = ["replay", "scene.toml", "--paced", "--source", &source, "--prometheus", &metrics];
        let mut command = sandbox.command(&args);
        if let Some(descriptors) = descriptors {
            let program = crate::support::program();
            command = Command::new("sh");
            let limit = format!("ulimit -n {descriptors} && exec \"$0\" \"$@\"");
            command.arg("-c").arg(limit).arg(program).args(args).current_dir(sandbox.path(""));
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        }
        let endpoint = Self { child: command.spawn().unwrap(), port, _desk: sandbox };
        drop(connected(port));
        endpoint
    }

    fn answer(&self, request: &[u8]) -> String {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(3))).unwrap();
        stream.write_all(request).unwrap();
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    fn is_answering(&self) -> bool {
        self.answer(b"GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n").starts_with("HTTP/1.1 200 OK\r\n")
    }

    /// Largest resident memory, MiB.
    #[cfg(target_os = "linux")]
    fn memory(&self) -> f64 {
        memory(self.child.id(), "VmHWM").unwrap()
    }
}

impl Drop for Endpoint {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn requests_that_are_none_are_answered_or_closed() {
    let endpoint = Endpoint::start(None);
    assert!(endpoint.answer(b"GET /x HTTP/1.1\r\nHost: localhost\r\n\r\n").starts_with("HTTP/1.1 404"));
    // A page of a foreign name that resolves to this machine.
    for host in ["Host: evil.example\r\n", "Host: localhost.evil.example:80\r\n", ""] {
        let answer = endpoint.answer(format!("GET /metrics HTTP/1.1\r\n{host}\r\n").as_bytes());
        assert!(answer.starts_with("HTTP/1.1 403") && !answer.contains("ballrace_"), "{host}: {answer}");
    }
    assert!(endpoint.answer(b"DELETE /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n").starts_with("HTTP/1.1 405"));
    for request in [&b"GARBAGE\r\n\r\n"[..], b"\0\0\0\0\r\n\r\n", b"GET /metrics HTTP/9.9\r\n\r\n"] {
        assert!(endpoint.answer(request).starts_with("HTTP/1.1 4"), "{}", String::from_utf8_lossy(request));
    }
    assert!(endpoint.is_answering());
}

#[test]
fn request_without_its_body_blocks_no_other_client() {
    let endpoint = Endpoint::start(None);
    let mut clients = vec![];
    for header in ["Content-Length: 1000000", "Transfer-Encoding: chunked"] {
        let mut client = connected(endpoint.port);
        write!(client, "POST /metrics HTTP/1.1\r\nHost: a\r\n{header}\r\n\r\n").unwrap();
        clients.push(client);
        assert!(endpoint.is_answering(), "{header}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn an_endless_header_is_cut_short() {
    let endpoint = Endpoint::start(None);
    let before = endpoint.memory();
    let mut client = connected(endpoint.port);
    client.set_write_timeout(Some(Duration::from_secs(3))).unwrap();
    client.write_all(b"GET /metrics HTTP/1.1\r\nX: ").unwrap();
    let block = vec![b'A'; 1 << 20];
    // 64 MB, far more than the buffers of the connection hold.
    let sent = (0..64).take_while(|_| client.write_all(&block).is_ok()).count();
    assert!(sent < 64, "all of it was read");
    assert!(endpoint.memory() < before + 8.0, "{} and {before} MiB", endpoint.memory());
    assert!(endpoint.is_answering());
}

/// More clients than the process has descriptors: the endpoint answers while they are there and after they left.
#[test]
#[cfg(target_os = "linux")]
fn idle_clients_do_not_end_the_endpoint() {
    let mut endpoint = Endpoint::start(Some(64));
    let clients: Vec<TcpStream> = (0..300)
        .map(|_| {
            let mut client = connected(endpoint.port);
            let _ = client.write_all(b"GET /m");
            client
        })
        .collect();
    wait_until("an answer among idle clients", || endpoint.is_answering());
    drop(clients);
    wait_until("an answer after they left", || endpoint.is_answering());
    assert!(endpoint.child.try_wait().unwrap().is_none());
}
