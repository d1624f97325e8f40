//! The live page of a running monitor: requests, acknowledgement, restart, hostile clients.

use crate::live::{connected, kinds, kinds_so_far, port};
use crate::live_start::{terminate, wait};
use crate::support::{DEMO_SCENE, Sandbox, short_recording, swap};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Child;
use std::time::{Duration, Instant};

const TOKEN: &str = "correct-horse-battery";

/// A monitor with a live page; killed at the end.
pub struct Site {
    child: Child,
    pub port: u16,
    pub sandbox: Sandbox,
}

/// Status line and headers, and body of a response.
pub struct Response {
    pub head: String,
    pub body: String,
}

impl Site {
    /// The built-in machine with a spall, simulated without an end.
    pub fn demonstration(options: &[&str]) -> Self {
        let args = [&["--source", "demonstration"], options].concat();
        Self::start(Sandbox::empty(), &args)
    }

    pub fn start(sandbox: Sandbox, args: &[&str]) -> Self {
        let port = port();
        sandbox.put("token", format!("{TOKEN}\n"));
        let address = format!("127.0.0.1:{port}");
        let args = [&["replay", "--paced", "--http", &address], args].concat();
        let site = Self { child: sandbox.command(&args).spawn().unwrap(), port, sandbox };
        drop(connected(port));
        site
    }

    /// A number of the process, MiB.
    #[cfg(target_os = "linux")]
    pub fn memory(&self, name: &str) -> Option<f64> {
        crate::support::memory(self.child.id(), name)
    }

    pub fn send(&self, request: &str) -> Response {
        let mut stream = connected(self.port);
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let text = String::from_utf8_lossy(&answer).into_owned();
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
        Response { head: head.to_lowercase(), body: body.to_owned() }
    }

    pub fn get(&self, path: &str) -> Response {
        self.send(&format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n\r\n", self.port))
    }

    pub fn state(&self) -> Value {
        serde_json::from_str(&self.get("/state").body).unwrap()
    }

    /// Waits for a state of which `get` returns something.
    pub fn wait<T>(&self, what: &str, get: impl Fn(&Value) -> Option<T>) -> T {
        wait(what, || {
            std::thread::sleep(Duration::from_millis(100));
            get(&self.state())
        })
    }

    /// Waits for the first alarm and returns its identifier.
    pub fn alarm(&self) -> String {
        self.wait("an alarm", |state| Some(state["alarms"][0]["id"].as_str()?.to_owned()))
    }

    fn acknowledge(&self, alarm: &str, header: &str) -> Response {
        let body = serde_json::json!({ "alarm": alarm }).to_string();
        self.send(&format!(
            "POST /acknowledge HTTP/1.1\r\nHost: localhost:{}\r\n{header}Content-Length: {}\r\n\r\n{body}",
            self.port,
            body.len()
        ))
    }

    /// Kills the monitor and returns its sandbox.
    fn kill(mut self) -> Sandbox {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
        std::mem::replace(&mut self.sandbox, Sandbox::empty())
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn is(response: &Response, status: u16) -> bool {
    response.head.split(' ').nth(1) == Some(status.to_string().as_str())
}

fn bearer(token: &str) -> String {
    format!("Authorization: Bearer {token}\r\n")
}

#[test]
fn a_page_shows_a_fault_and_a_user_acknowledges_it_once() {
    let options = ["--state", "state", "--events", "events.jsonl", "--indicators", "trend"];
    let with_token = [&options[..], &["--http-token-file", "token"]].concat();
    let site = Site::demonstration(&with_token);
    let page = site.get("/");
    assert!(is(&page, 200) && page.body.contains("<!DOCTYPE html>"), "{}", page.head);
    for header in
        ["content-security-policy: default-src 'none'", "x-content-type-options: nosniff", "x-frame-options: deny"]
    {
        assert!(page.head.contains(header), "{header} in {}", page.head);
    }
    for outside in ["http://", "https://", "<style", "onclick"] {
        assert!(!page.body.contains(outside), "{outside}");
    }
    let alarm = site.alarm();
    assert_eq!(alarm, "fault spall outer-race of DE");
    let state = site.state();
    assert_eq!((&state["status"]["word"], &state["status"]["level"]), (&"ALARM".into(), &"alarm".into()), "{state:#}");
    assert!(state["status"]["action"].as_str().unwrap().contains("spare bearing"), "{state:#}");
    // A header without the token, and the wrong one.
    assert!(is(&site.acknowledge(&alarm, ""), 403) && is(&site.acknowledge(&alarm, &bearer("correct")), 403));
    assert!(is(&site.acknowledge("fault of nothing", &bearer(TOKEN)), 404));
    assert!(is(&site.acknowledge(&alarm, &bearer(TOKEN)), 202));
    let is_acknowledged = |state: &Value| state["alarms"][0]["acknowledged_at"].as_str().map(str::to_owned);
    let at = site.wait("the acknowledgement", is_acknowledged);
    assert_eq!(site.state()["status"]["word"], "ALARM, ACKNOWLEDGED");
    wait("the event", || {
        kinds_so_far(&site.sandbox, "events.jsonl").contains(&"alarm-acknowledged".to_owned()).then_some(())
    });
    // The figures of the newest samples, and the history.
    let figures = wait("figures", || {
        let figures: Vec<Value> = serde_json::from_str(&site.get("/figures").body).unwrap();
        (figures.len() > 5).then_some(figures)
    });
    assert!(figures.iter().any(|figure| figure["title"].as_str().unwrap().starts_with("Orbit of DE_X_um")));
    let history: Vec<Value> = serde_json::from_str(&site.get("/history?hours=1").body).unwrap();
    assert!(history.len() == 5 && history[0]["note"].as_str().unwrap().contains("files"), "{}", history[0]["note"]);
    assert!(is(&site.get("/history?hours=1e9"), 400));
    // A restart keeps the acknowledgement and does not report the fault again.
    let sandbox = site.kill();
    let site = Site::start(sandbox, &[&["--source", "demonstration"], &options[..]].concat());
    assert_eq!(is_acknowledged(&site.state()), Some(at.clone()), "the first state after the restart");
    site.wait("a diagnosis", |state| {
        let events = state["events"].as_array().unwrap();
        events.iter().any(|event| event["kind"] == "fault-size").then_some(())
    });
    assert_eq!(is_acknowledged(&site.state()), Some(at));
    assert!(is(&site.acknowledge(&alarm, &bearer(TOKEN)), 403), "read-only without a token file");
    terminate(site.child.id());
    let sandbox = site.kill();
    let kinds = kinds(&sandbox, "events.jsonl");
    for once in ["fault-found", "alarm-acknowledged"] {
        assert_eq!(kinds.iter().filter(|kind| *kind == once).count(), 1, "{once} in {kinds:?}");
    }
}

#[test]
fn foreign_hosts_methods_and_paths_are_refused() {
    let site = Site::demonstration(&["--http-host", "rig.plant", "--http-origin", "http://127.0.0.1:1"]);
    let with_host = |host: &str| site.send(&format!("GET /state HTTP/1.1\r\nHost: {host}\r\n\r\n"));
    for host in ["evil.example", "127.0.0.1.evil.example:80", ""] {
        assert!(is(&with_host(host), 403), "{host}");
    }
    for host in ["localhost", "127.0.0.1", "[::1]:80", "rig.plant"] {
        assert!(is(&with_host(host), 200), "{host}");
    }
    assert!(is(&site.send("GET / HTTP/1.0\r\n\r\n"), 403));
    assert!(is(&site.get("/etc/passwd"), 404) && is(&site.get("/acknowledge"), 405));
    assert!(is(&site.send("DELETE /state HTTP/1.1\r\nHost: localhost\r\n\r\n"), 405));
    let from = |origin: &str| site.send(&format!("GET /state HTTP/1.1\r\nHost: localhost\r\nOrigin: {origin}\r\n\r\n"));
    assert!(from("http://127.0.0.1:1").head.contains("access-control-allow-origin: http://127.0.0.1:1"));
    assert!(!from("http://127.0.0.1:2").head.contains("access-control-allow-origin"));
}

/// A stream of states goes on while a thousand clients connect and say nothing: the monitor holds few of their connections, so
/// that memory is bounded, and the loop keeps its deadlines. Three thousand that come and go leave nothing behind.
#[test]
#[cfg(target_os = "linux")]
fn four_thousand_connections_do_not_disturb_the_monitor() {
    let site = Site::demonstration(&[]);
    // The first diagnosis is over: what it needed does not count.
    site.alarm();
    let mut stream = connected(site.port);
    write!(stream, "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    let mut lines = BufReader::new(stream).lines();
    let mut next = || loop {
        let line = lines.next().unwrap().unwrap();
        if let Some(state) = line.strip_prefix("data: ") {
            return serde_json::from_str::<Value>(state).unwrap();
        }
    };
    let misses = |state: &Value| state["deadline_misses"].as_u64().unwrap();
    let mut follow = || {
        let (since, mut last) = (Instant::now(), next());
        while since.elapsed() < Duration::from_secs(3) {
            last = next();
        }
        last
    };
    // Other programs of this machine delay blocks as well: three seconds without the clients, then with them.
    let first = misses(&follow());
    let before = follow();
    let open = || std::fs::read_dir(format!("/proc/{}/fd", site.child.id())).unwrap().count();
    let open_before = open();
    let idle: Vec<TcpStream> = (0..1000)
        .filter_map(|_| {
            let mut client = TcpStream::connect(("127.0.0.1", site.port)).ok()?;
            let _ = client.write_all(b"GET /f");
            Some(client)
        })
        .collect();
    // 32 connections are held, and the system may hand over up to 128 more before the oldest are closed.
    let held = open().saturating_sub(open_before);
    assert!(idle.len() == 1000 && held <= 160, "{held} of {} connections are held", idle.len());
    let last = follow();
    let time = |state: &Value| state["time_s"].as_f64().unwrap();
    assert!(time(&last) - time(&before) > 2.0, "the monitor goes on");
    let (without, with) = (misses(&before) - first, misses(&last) - misses(&before));
    println!("{} clients: {with} deadlines missed in 3 s, {without} without them", idle.len());
    assert!(with <= 3 * without + 50, "{with} deadlines missed, {without} without the clients");
    drop(idle);
    // Three thousand more that connect and go, some with half a request.
    for i in 0..3000 {
        let mut client = TcpStream::connect(("127.0.0.1", site.port)).unwrap();
        if i % 3 == 0 {
            let _ = client.write_all(b"GET /f");
        }
    }
    wait("the connections to be closed", || (open() <= open_before + 40).then_some(()));
    wait("an answer", || is(&site.get("/state"), 200).then_some(()));
}

/// More streams than are served, which are never read: a further one replaces the oldest.
#[test]
fn streams_are_bounded() {
    let site = Site::demonstration(&[]);
    let open = || {
        let mut stream = connected(site.port);
        write!(stream, "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        let mut line = String::new();
        BufReader::new(stream.try_clone().unwrap()).read_line(&mut line).unwrap();
        (stream, line)
    };
    let mut streams: Vec<_> = (0..32).map(|_| open()).collect();
    streams.extend((0..3).map(|_| open()));
    assert!(streams.iter().all(|(_, line)| line.contains("200 OK")));
    assert!(is(&site.get("/state"), 200));
    // The first three have ended, the others go on.
    for (i, (stream, _)) in streams.iter_mut().enumerate().take(7) {
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        if i < 3 {
            stream.read_to_end(&mut vec![]).unwrap();
        } else {
            assert!((0..3).all(|_| stream.read(&mut [0; 1 << 16]).unwrap() > 0), "stream {i}");
        }
    }
    drop(streams);
    assert!(open().1.contains("200 OK"));
}

#[test]
fn wrong_options_are_refused() {
    let sandbox = Sandbox::with(DEMO_SCENE, &short_recording(256));
    sandbox.put("short", "abc");
    let paced = |more: &[&'static str]| -> Vec<&'static str> { [&["replay", "scene.toml", "--paced"], more].concat() };
    // Refused by the parser of the command line, which adds a usage.
    for (options, expected) in [
        (&["--http", "name:1"][..], "expected PORT or ADDRESS:PORT"),
        (&["--http-token-file", "short"], "--http"),
        (&["--http", "0", "--http-also", "http://a/b"], "without a path"),
    ] {
        let answer = sandbox.run(&paced(options));
        assert!(answer.code == Some(2) && answer.err.contains(expected), "{answer:?}");
    }
    sandbox.refused(&paced(&["--http", "0", "--http-token-file", "short"]), 2, &["short", "at least 8"]);
    sandbox.refused(&paced(&["--http", "0", "--http-token-file", "absent"]), 1, &["absent"]);
    sandbox.refused(&paced(&["--http", "192.0.2.1:1"]), 1, &["192.0.2.1:1", "address of this machine"]);
    sandbox.refused(&["replay", "scene.toml", "--http", "0"], 2, &["--http", "--paced"]);
    sandbox.refused(&paced(&["--source", "demonstration"]), 2, &["--source demonstration", "no SCENE"]);
}

/// A machine whose names are markup, with a limit that is exceeded.
pub fn hostile_scene() -> String {
    let scene = swap(DEMO_SCENE, "name = \"6205 rig\"", "name = \"<b>rig</b><script>alert(1)</script>\"");
    let scene = swap(&scene, "name = \"DE\"", "name = \"<b>\"");
    scene + "\n[[limit]]\nindicator = \"peak-to-peak\"\nprobe = \"DE_X_um\"\nmax = \"0.1 um\"\n"
}
