//! The files of `docs/deploy`: a real Prometheus scrapes the monitor and an alert fires, the service manager hears the monitor.
#![cfg(target_os = "linux")]

use crate::frames_source::{RATE, Rig, connected, port, signal, wait_until};
use crate::support::{Sandbox, program, swap};
use serde_json::Value;
use std::fs;
use std::io::{Read, Write};
use std::os::unix::net::UnixDatagram;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/deploy/");

fn deployed(name: &str) -> String {
    fs::read_to_string(FOLDER.to_owned() + name).unwrap()
}

fn run(program: &str, args: &[&str]) -> String {
    let output = Command::new(program).args(args).current_dir(FOLDER).output();
    let output = output.unwrap_or_else(|e| panic!("{program}: {e}; type: tests/run tools"));
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(output.status.success(), "{program} {args:?}: {text}");
    text
}

/// A process that is killed at the end of a test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// JSON that Prometheus returns for a path of its interface.
fn query(port: u16, path: &str) -> Value {
    let mut stream = connected(port);
    stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
    write!(stream, "GET {path} HTTP/1.0\r\nHost: localhost\r\n\r\n").unwrap();
    let mut answer = String::new();
    let _ = stream.read_to_string(&mut answer);
    answer.split_once("\r\n\r\n").and_then(|(_, body)| serde_json::from_str(body).ok()).unwrap_or_default()
}

#[test]
fn the_alert_rules_fire_when_they_should() {
    run("promtool", &["check", "config", "prometheus.yml"]);
    run("promtool", &["test", "rules", "prometheus-rules-test.yml"]);
}

/// A monitor whose source exceeds a limit: Prometheus has its metrics, and the alert fires.
#[test]
fn prometheus_scrapes_the_monitor_and_its_alert_fires() {
    let (metrics, web) = (port(), port());
    let rig = Rig::new(&["--prometheus", &metrics.to_string(), "--no-report"]);
    let sandbox = &rig.sandbox;
    sandbox.put("prometheus.yml", swap(&deployed("prometheus.yml"), "127.0.0.1:9101", &format!("127.0.0.1:{metrics}")));
    sandbox.put("prometheus-rules.yml", deployed("prometheus-rules.yml"));
    let _monitor = Process(rig.start());
    let prometheus = Command::new("prometheus")
        .arg("--config.file=prometheus.yml")
        .args(["--storage.tsdb.path=data", &format!("--web.listen-address=127.0.0.1:{web}")])
        .current_dir(sandbox.path(""))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(fs::File::create(sandbox.path("prometheus.log")).unwrap())
        .spawn();
    let _prometheus = Process(prometheus.unwrap_or_else(|e| panic!("prometheus: {e}; type: tests/run tools")));
    let is_firing = || {
        let alerts = query(web, "/api/v1/alerts");
        let alerts = alerts["data"]["alerts"].as_array().cloned().unwrap_or_default();
        alerts.iter().any(|alert| {
            let labels = &alert["labels"];
            let is_limit = labels["alertname"] == "BallraceLimitExceeded" && labels["probe"] == "NDE_X_um";
            is_limit && labels["machine"] == "pump" && alert["state"] == "firing"
        })
    };
    // The plateau of the third probe begins after 1 s and lasts 2 s; the motion stops there.
    let mut asked = std::time::Instant::now();
    rig.feed(3 * RATE, |_| {
        asked.elapsed() > Duration::from_millis(200) && {
            asked = std::time::Instant::now();
            is_firing()
        }
    });
    let series = query(web, "/api/v1/label/__name__/values");
    let names: Vec<&str> = series["data"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    for name in
        ["ballrace_probe_one_x_um", "ballrace_probe_peak_to_peak_um", "ballrace_events_total", "ballrace_time_s"]
    {
        assert!(names.contains(&name), "{name} is not in {names:?}");
    }
    let up = query(web, "/api/v1/query?query=up%7Bjob%3D%22ballrace%22%7D");
    assert_eq!(up["data"]["result"][0]["value"][1], "1", "{up:#}");
}

/// Readiness, watchdog and end as datagrams of the protocol of systemd.
#[test]
fn the_service_manager_is_notified() {
    let rig = Rig::new(&["--no-report"]);
    let path = rig.sandbox.path("notify");
    let socket = UnixDatagram::bind(&path).unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let mut command = rig.command();
    // A watchdog of 0.4 s, so that a message comes every 0.2 s.
    let child = command.env("NOTIFY_SOCKET", &path).env("WATCHDOG_USEC", "400000").spawn().unwrap();
    let mut monitor = Process(child);
    let next = || {
        let mut buffer = [0; 256];
        let length = socket.recv(&mut buffer).expect("no message of the monitor");
        String::from_utf8_lossy(&buffer[..length]).trim_end().to_owned()
    };
    assert_eq!(next(), "READY=1");
    // While it waits for its source, and while it processes samples.
    let since = std::time::Instant::now();
    (0..3).for_each(|_| assert_eq!(next(), "WATCHDOG=1"));
    assert!(since.elapsed() >= Duration::from_millis(350), "more often than twice in the time of the watchdog");
    let mut fed = 0;
    rig.feed(4 * RATE, |_| {
        fed += 1;
        fed > 200
    });
    assert_eq!(next(), "WATCHDOG=1");
    signal(&monitor.0, "TERM");
    wait_until("the message at the end", || next() == "STOPPING=1");
    assert!(matches!(monitor.0.wait().unwrap().code(), Some(0 | 3 | 4)));
}

/// systemd accepts the unit, and its sandbox leaves little to a monitor that is taken over.
#[test]
fn systemd_accepts_the_unit() {
    let sandbox = Sandbox::empty();
    let unit = swap(&deployed("ballrace@.service"), "/usr/local/bin/ballrace", &program().display().to_string());
    // `verify` reads the files of an instance.
    sandbox.put("pump.env", deployed("pump.env"));
    let unit = swap(&unit, "/etc/ballrace/%i.env", &sandbox.path("pump.env").display().to_string());
    sandbox.put("ballrace@pump.service", unit);
    let path = sandbox.path("ballrace@pump.service").display().to_string();
    let output = Command::new("systemd-analyze").args(["verify", "--man=no", "--recursive-errors=no", &path]).output();
    let output = output.unwrap_or_else(|e| panic!("systemd-analyze: {e}; type: tests/run tools"));
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !text.contains("ballrace"), "{text}");
    // Exposure at most 2.5 of 10.
    run("systemd-analyze", &["security", "--offline=true", "--threshold=25", "--no-pager", &path]);
}

/// The options of the unit, the environment and the container are those of the program.
#[test]
fn deployed_command_lines_are_accepted() {
    let help = Sandbox::empty().done(&["replay", "--help"]).out;
    for file in ["ballrace@.service", "Containerfile"] {
        let text = deployed(file);
        let lines = text.lines().filter(|line| line.contains("ballrace replay"));
        let options: Vec<&str> = lines.flat_map(str::split_whitespace).filter(|word| word.starts_with("--")).collect();
        let options = options.into_iter().filter(|word| !["--network", "--volume"].contains(word));
        let unknown: Vec<&str> = options.filter(|option| !help.contains(option)).collect();
        assert!(text.contains("ballrace replay") && unknown.is_empty(), "{file}: {unknown:?}");
    }
    let version = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml")).unwrap();
    let version = version.lines().find_map(|line| line.strip_prefix("rust-version = ")).unwrap().trim_matches('"');
    assert!(deployed("Containerfile").contains(&format!("/rust:{version}-")), "{version}");
}

/// A rotation renames the log of the unit's option, and `systemctl reload` sends SIGHUP.
#[test]
fn the_rotation_is_that_of_the_unit() {
    let (unit, rotation) = (deployed("ballrace@.service"), deployed("ballrace.logrotate"));
    assert!(unit.contains("--events events.jsonl ") && unit.contains("\nWorkingDirectory=%S/ballrace/%i\n"));
    assert!(unit.contains("\nExecReload=/bin/kill -HUP $MAINPID\n"));
    assert!(rotation.contains("\n/var/lib/ballrace/*/events.jsonl {\n") && !rotation.contains("copytruncate"));
    assert!(rotation.contains("systemctl reload 'ballrace@*.service'"));
}
