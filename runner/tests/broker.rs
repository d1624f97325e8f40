//! The monitor and a real MQTT broker, mosquitto, on the loopback interface: TLS, password, last will, restart of the broker.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use rumqttc::{Client, Event, MqttOptions, Packet, QoS, Transport};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::io::Write;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

const SCENE: &str = include_str!("../demo/healthy.toml");
const RECORDING: &str = include_str!("../../tests/recordings/healthy.csv");
/// Rows of a second: every fourth of the demonstration's.
const RATE: usize = 3200;
const PASSWORD: &str = "correct horse";
const PATIENCE: Duration = Duration::from_secs(60);

fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let since = Instant::now();
    while !holds() {
        assert!(since.elapsed() < PATIENCE, "timed out: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn run(program: &str, args: &[&str], folder: &Path) {
    let output = Command::new(program).args(args).current_dir(folder).output();
    let output = output.unwrap_or_else(|e| panic!("{program}: {e}; type: tests/run tools"));
    assert!(output.status.success(), "{program} {args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A process that is killed at the end of a test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Folder with a broker's certificates, passwords and configuration, and with a scene.
struct Sandbox {
    folder: tempfile::TempDir,
    port: u16,
}

impl Sandbox {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let subject = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-batch"];
        let authority = ["req", "-x509", "-subj", "/CN=test authority", "-keyout", "ca.key", "-out", "ca.pem"];
        run("openssl", &[&authority[..], &subject].concat(), at);
        let request = ["req", "-subj", "/CN=localhost", "-keyout", "broker.key", "-out", "broker.csr"];
        run("openssl", &[&request[..], &subject].concat(), at);
        fs::write(at.join("names"), "subjectAltName=DNS:localhost,IP:127.0.0.1\n").unwrap();
        let sign = ["x509", "-req", "-in", "broker.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial"];
        run("openssl", &[&sign[..], &["-extfile", "names", "-out", "broker.pem"]].concat(), at);
        run("mosquitto_passwd", &["-c", "-b", "passwords", "rig", PASSWORD], at);
        let path = |name: &str| at.join(name).display().to_string();
        let mut text = format!("user {}\npersistence true\npersistence_location {}/\n", user(), at.display());
        write!(text, "allow_anonymous false\npassword_file {}\nmax_queued_messages 0\n", path("passwords")).unwrap();
        write!(text, "listener {port} 127.0.0.1\ncafile {}\n", path("ca.pem")).unwrap();
        write!(text, "certfile {}\nkeyfile {}\n", path("broker.pem"), path("broker.key")).unwrap();
        fs::write(at.join("broker.conf"), text).unwrap();
        fs::write(at.join("password"), format!("{PASSWORD}\n")).unwrap();
        fs::write(at.join("wrong"), "guess").unwrap();
        fs::write(at.join("scene.toml"), SCENE.replace("rate = \"12.8 kHz\"", "rate = \"3.2 kHz\"")).unwrap();
        Self { folder, port }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Starts the broker and waits until it listens.
    fn broker(&self) -> Process {
        let program = if Path::new("/usr/sbin/mosquitto").exists() { "/usr/sbin/mosquitto" } else { "mosquitto" };
        let log = fs::OpenOptions::new().create(true).append(true).open(self.path("broker.log")).unwrap();
        let mut command = Command::new(program);
        command.arg("-c").arg(self.path("broker.conf")).stdin(Stdio::null()).stdout(Stdio::null()).stderr(log);
        let broker = Process(command.spawn().unwrap_or_else(|e| panic!("{program}: {e}; type: tests/run tools")));
        wait_until("the broker listens", || std::net::TcpStream::connect(("127.0.0.1", self.port)).is_ok());
        broker
    }

    /// Starts a monitor of standard input that publishes JSON.
    fn monitor(&self, password: &str) -> Monitor {
        self.monitor_with("--mqtt", "works/pump", password)
    }

    /// Starts a monitor of standard input with an output to the broker.
    fn monitor_with(&self, option: &str, path: &str, password: &str) -> Monitor {
        let url = format!("mqtts://rig@127.0.0.1:{}/{path}", self.port);
        let args = ["replay", "scene.toml", "--paced", "--source", "-", "--format", "json", "--no-report"];
        let mut command = Command::new(env!("CARGO_BIN_EXE_ballrace"));
        command.args(args).args(["--events", "events.jsonl", "--indicators", "trend"]);
        command.args([option, &url, "--mqtt-ca", "ca.pem"]);
        command.args(["--mqtt-password-file", password]).current_dir(self.folder.path());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit());
        let mut child = command.spawn().unwrap();
        let mut input = child.stdin.take().unwrap();
        input.write_all(RECORDING.lines().next().unwrap().as_bytes()).unwrap();
        input.write_all(b"\n").unwrap();
        Monitor { process: Process(child), input: Some(input), rows: 0 }
    }

    /// Ends of the seconds in the indicator file.
    fn written_seconds(&self) -> Vec<f64> {
        use parquet::file::reader::{FileReader, SerializedFileReader};
        use parquet::record::RowAccessor;
        let file = fs::File::open(self.path("trend/indicators-0001.parquet")).unwrap();
        let rows = SerializedFileReader::new(file).unwrap();
        rows.get_row_iter(None).unwrap().map(|row| row.unwrap().get_double(0).unwrap()).collect()
    }

    fn log(&self) -> String {
        fs::read_to_string(self.path("events.jsonl")).unwrap_or_default()
    }

    /// Returns a client with a session that the broker keeps.
    fn client(&self) -> (Client, rumqttc::Connection) {
        let mut options = MqttOptions::new("subscriber", "localhost", self.port);
        options.set_credentials("rig", PASSWORD).set_clean_session(false).set_max_packet_size(1 << 20, 1 << 20);
        options.set_transport(Transport::tls(fs::read(self.path("ca.pem")).unwrap(), None, None));
        Client::new(options, 10)
    }

    /// Subscribes to everything.
    fn subscribe(&self) -> Arc<Mutex<Vec<(String, String)>>> {
        let received = Arc::<Mutex<Vec<(String, String)>>>::default();
        let of_thread = received.clone();
        let (client, mut connection) = self.client();
        client.subscribe("works/#", QoS::AtLeastOnce).unwrap();
        std::thread::spawn(move || {
            // The subscription ends with this thread.
            let _client = client;
            for event in connection.iter() {
                match event {
                    Ok(Event::Incoming(Packet::Publish(message))) => {
                        let payload = String::from_utf8_lossy(&message.payload).into_owned();
                        of_thread.lock().unwrap().push((message.topic, payload));
                    }
                    Ok(_) => {}
                    Err(_) => std::thread::sleep(Duration::from_millis(200)),
                }
            }
        });
        received
    }
}

/// The broker started by root would take the rights of another user, who cannot read the folder.
fn user() -> String {
    let output = Command::new("id").arg("-un").output().unwrap();
    String::from_utf8(output.stdout).unwrap().trim().to_owned()
}

struct Monitor {
    process: Process,
    input: Option<std::process::ChildStdin>,
    rows: usize,
}

impl Monitor {
    /// Writes as many seconds of the demonstration's motion.
    fn feed(&mut self, seconds: usize) {
        let all: Vec<&str> = RECORDING.lines().skip(1).step_by(4).collect();
        let mut text = String::new();
        for index in self.rows..self.rows + seconds * RATE {
            // The pulse is too short to be there in every fourth sample; 64 samples are a revolution.
            let (cells, _) = all[index % all.len()].rsplit_once(',').unwrap();
            writeln!(text, "{cells},{}", u8::from(index % 64 < 3)).unwrap();
        }
        self.rows += seconds * RATE;
        self.input.as_mut().unwrap().write_all(text.as_bytes()).unwrap();
    }

    /// Ends the input and returns the outcome.
    fn end(mut self) -> Value {
        self.input = None;
        let mut out = self.process.0.stdout.take().unwrap();
        let mut text = String::new();
        std::io::Read::read_to_string(&mut out, &mut text).unwrap();
        assert!(self.process.0.wait().unwrap().success(), "{text}");
        serde_json::from_str(&text).unwrap()
    }
}

/// Seconds in the messages, each once, in the order in which they arrived first.
fn seconds(received: &Mutex<Vec<(String, String)>>) -> Vec<f64> {
    let mut all = vec![];
    for (_, payload) in received.lock().unwrap().iter().filter(|(topic, _)| topic == "works/pump/indicators") {
        let message: Value = serde_json::from_str(payload).unwrap();
        assert_eq!(message["schema"], "ballrace-second-1");
        let time = message["time_s"].as_f64().unwrap();
        if !all.contains(&time) {
            all.push(time);
        }
    }
    all
}

fn statuses(received: &Mutex<Vec<(String, String)>>) -> Vec<String> {
    let received = received.lock().unwrap();
    received.iter().filter(|(topic, _)| topic == "works/pump/status").map(|(_, payload)| payload.clone()).collect()
}

#[test]
fn a_restarted_broker_gets_every_message() {
    let sandbox = Sandbox::new();
    let mut broker = sandbox.broker();
    let received = sandbox.subscribe();
    let mut monitor = sandbox.monitor("password");
    monitor.feed(6);
    wait_until("seconds at the broker", || seconds(&received).len() >= 2);
    assert_eq!(statuses(&received), ["online"]);
    run("kill", &["-TERM", &broker.0.id().to_string()], sandbox.folder.path());
    // The broker stores its sessions before it ends.
    assert!(broker.0.wait().unwrap().success());
    monitor.feed(4);
    wait_until("an event about the broker", || sandbox.log().contains("\"kind\":\"output-failing\""));
    let _broker = sandbox.broker();
    wait_until("the end of the failure", || sandbox.log().contains("\"kind\":\"output-recovered\""));
    monitor.feed(2);
    let outcome = monitor.end();
    assert_eq!(outcome["timing"]["outputs"]["messages_not_delivered"], 0, "{}", sandbox.log());
    // The broker has every second that is in the indicator files.
    let written = sandbox.written_seconds();
    assert!(written.len() >= 9, "{written:?}");
    wait_until("the end of the monitor", || statuses(&received).last().is_some_and(|status| status == "offline"));
    assert_eq!(seconds(&received), written, "{}", fs::read_to_string(sandbox.path("broker.log")).unwrap());
    // Every event of the log was published.
    let published: Vec<String> = received.lock().unwrap().iter().map(|(_, payload)| payload.clone()).collect();
    for line in sandbox.log().lines() {
        assert!(published.iter().any(|payload| payload == line), "{line}");
    }
}

#[test]
fn the_last_will_of_a_killed_monitor_is_published() {
    let sandbox = Sandbox::new();
    let _broker = sandbox.broker();
    let received = sandbox.subscribe();
    let monitor = sandbox.monitor("password");
    wait_until("the monitor is online", || statuses(&received) == ["online"]);
    drop(monitor);
    wait_until("the last will", || statuses(&received) == ["online", "offline"]);
}

/// A wrong password and a broker of another authority stop no monitor and deliver nothing.
#[test]
fn no_data_for_a_broker_that_rejects_or_is_not_trusted() {
    let sandbox = Sandbox::new();
    let _broker = sandbox.broker();
    let received = sandbox.subscribe();
    let mut monitor = sandbox.monitor("wrong");
    monitor.feed(4);
    wait_until("an event about the password", || sandbox.log().contains("NotAuthorized"));
    let outcome = monitor.end();
    assert!(outcome["timing"]["outputs"]["messages_not_delivered"].as_u64().unwrap() >= 3, "{outcome:#}");
    fs::remove_file(sandbox.path("events.jsonl")).unwrap();
    fs::copy(sandbox.path("ca.pem"), sandbox.path("trusted.pem")).unwrap();
    let other =
        ["req", "-x509", "-subj", "/CN=another", "-newkey", "rsa:2048", "-nodes", "-keyout", "o.key", "-out", "ca.pem"];
    run("openssl", &other, sandbox.folder.path());
    let mut monitor = sandbox.monitor("password");
    monitor.feed(1);
    wait_until("an event about the certificate", || sandbox.log().contains("certificate"));
    drop(monitor);
    assert!(received.lock().unwrap().is_empty());
}

#[test]
fn options_of_the_broker_are_checked_before_the_start() {
    let sandbox = Sandbox::new();
    let refused = |args: &[&str], part: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ballrace"));
        command.args(["replay", "scene.toml", "--paced", "--source", "-", "--no-report"]).args(args);
        let output = command.current_dir(sandbox.folder.path()).stdin(Stdio::null()).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && text.lines().count() == 1 && text.contains(part), "{args:?}: {text}");
    };
    refused(&["--mqtt", "mqtt://rig:secret@h:1/a"], "the URL has a password");
    refused(&["--mqtt", "mqtt://rig@h:1/a"], "no password of the user \"rig\"");
    refused(&["--mqtt", "mqtts://h:1/a"], "mqtts:// without --mqtt-ca");
    refused(&["--mqtt", "mqtts://h:1/a", "--mqtt-ca", "scene.toml"], "scene.toml: no certificate");
    refused(&["--mqtt", "mqtts://h:1/a", "--mqtt-ca", "absent.pem"], "absent.pem: this file cannot be read");
    refused(&["--mqtt", "mqtt://h:1/a", "--mqtt-ca", "ca.pem"], "the URL has no TLS");
    refused(&["--mqtt", "mqtt://h:1/a", "--mqtt-password-file", "password"], "--mqtt-password-file: no user");
    refused(&["--mqtt", "h:1/a"], "expected mqtt://HOST:PORT/TOPIC");
    #[cfg(feature = "sparkplug")]
    for path in ["works/hall", "works/hall/pump/x", "works//pump", "works/+/pump"] {
        refused(&["--sparkplug", &format!("mqtt://h:1/{path}")], "expected mqtt://HOST:PORT/GROUP/NODE/DEVICE");
    }
}

#[cfg(feature = "sparkplug")]
mod sparkplug {
    use super::*;
    use srad_client::{
        DeviceMessage, Event as Received, Message, MessageKind, NodeMessage, topic_and_payload_to_event,
    };
    use srad_types::payload::metric::Value as Number;
    use srad_types::payload::{DataType, Metric, Payload};

    /// A message of the node (`true`) or of the device.
    type Sent = (bool, MessageKind, Payload);

    fn is(sent: &Sent, of_node: bool, kind: MessageKind) -> bool {
        (sent.0, &sent.1) == (of_node, &kind)
    }

    fn named<'a>(payload: &'a Payload, name: &str) -> &'a Metric {
        let found = payload.metrics.iter().find(|metric| metric.name.as_deref() == Some(name));
        found.unwrap_or_else(|| panic!("no metric {name}"))
    }

    /// Number of the life of the node, in its birth and its death.
    fn life(payload: &Payload) -> &Number {
        named(payload, "bdSeq").value.as_ref().unwrap()
    }

    /// Subscribes to all messages of Sparkplug as a host does; returns them with a client for commands.
    fn host(sandbox: &Sandbox) -> (Arc<Mutex<Vec<Sent>>>, Client) {
        let received = Arc::<Mutex<Vec<Sent>>>::default();
        let of_thread = received.clone();
        let (client, mut connection) = sandbox.client();
        client.subscribe("spBv1.0/#", QoS::AtLeastOnce).unwrap();
        // A host that comes later has missed the birth.
        let (subscribed, is_subscribed) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            for event in connection.iter() {
                match event {
                    Ok(Event::Incoming(Packet::SubAck(_))) => drop(subscribed.send(())),
                    Ok(Event::Incoming(Packet::Publish(message))) => {
                        let event = topic_and_payload_to_event(message.topic.into_bytes(), message.payload.to_vec());
                        let (of_node, Message { payload, kind }) = match event {
                            Received::Node(NodeMessage { group_id, node_id, message }) => {
                                assert_eq!((&*group_id, &*node_id), ("works", "hall"));
                                (true, message)
                            }
                            Received::Device(DeviceMessage { device_id, message, .. }) => {
                                assert_eq!(device_id, "pump");
                                (false, message)
                            }
                            other => panic!("{other:?}"),
                        };
                        of_thread.lock().unwrap().push((of_node, kind, payload));
                    }
                    Ok(_) => {}
                    Err(_) => std::thread::sleep(Duration::from_millis(200)),
                }
            }
        });
        is_subscribed.recv_timeout(PATIENCE).unwrap();
        (received, client)
    }

    fn count(received: &Mutex<Vec<Sent>>, of_node: bool, kind: &MessageKind) -> usize {
        received.lock().unwrap().iter().filter(|sent| (sent.0, &sent.1) == (of_node, kind)).count()
    }

    #[test]
    fn a_node_is_born_with_its_device_publishes_seconds_and_dies() {
        let sandbox = Sandbox::new();
        let mut broker = sandbox.broker();
        let (received, client) = host(&sandbox);
        let mut monitor = sandbox.monitor_with("--sparkplug", "works/hall/pump", "password");
        monitor.feed(6);
        wait_until("seconds at the broker", || count(&received, false, &MessageKind::Data) >= 3);
        {
            let received = received.lock().unwrap();
            // The numbers of all messages of a life follow each other, from the birth of the node.
            for (i, (_, _, payload)) in received.iter().enumerate() {
                assert_eq!(payload.seq, Some(i as u64 % 256), "{:?}", received[i]);
            }
            assert!(is(&received[0], true, MessageKind::Birth), "{:?}", received[0]);
            let node = &received[0].2;
            assert_eq!(life(node), &Number::LongValue(0));
            assert_eq!(named(node, "Node Control/Rebirth").value, Some(Number::BooleanValue(false)));
            assert_eq!(named(node, "version").value, Some(Number::StringValue(env!("CARGO_PKG_VERSION").to_owned())));
            let (_, _, device) = received.iter().find(|sent| is(sent, false, MessageKind::Birth)).unwrap();
            let residual = named(device, "DE_X_um_residual_rms_um");
            assert_eq!(residual.datatype, Some(DataType::Double as u32));
            // Every metric of the data was born, and is that of the indicator file by its alias.
            let aliases: Vec<u64> = device.metrics.iter().map(|metric| metric.alias.unwrap()).collect();
            let data = received.iter().filter(|sent| is(sent, false, MessageKind::Data)).map(|sent| &sent.2);
            let mut seconds = vec![];
            for metric in data.flat_map(|payload| &payload.metrics) {
                assert!(aliases.contains(&metric.alias.unwrap()) && metric.timestamp.is_some(), "{metric:?}");
                assert!(metric.value.is_some() != metric.is_null.unwrap_or_default(), "{metric:?}");
                if let Some(Number::DoubleValue(value)) = metric.value
                    && metric.alias == named(device, "time_s").alias
                {
                    seconds.push(value);
                }
            }
            assert!(seconds.len() >= 2 && seconds.windows(2).all(|pair| (pair[1] - pair[0] - 1.0).abs() < 0.01));
        }
        // A host that has missed the birth asks for it.
        let mut rebirth = Metric::new();
        rebirth.set_name("Node Control/Rebirth".to_owned()).set_datatype(DataType::Boolean);
        rebirth.set_value(Number::BooleanValue(true));
        let command = Payload { timestamp: Some(1), metrics: vec![rebirth], seq: None, uuid: None, body: None };
        client.publish("spBv1.0/works/NCMD/hall", QoS::AtLeastOnce, false, Vec::<u8>::from(command)).unwrap();
        wait_until("another birth", || count(&received, false, &MessageKind::Birth) >= 2);
        assert_eq!(count(&received, true, &MessageKind::Death), 0);
        // The next life after a restart of the broker has the next number.
        run("kill", &["-TERM", &broker.0.id().to_string()], sandbox.folder.path());
        assert!(broker.0.wait().unwrap().success());
        wait_until("an event about the broker", || {
            monitor.feed(1);
            sandbox.log().contains("\"kind\":\"output-failing\"")
        });
        let _broker = sandbox.broker();
        wait_until("the next life", || {
            monitor.feed(1);
            let received = received.lock().unwrap();
            received.iter().any(|sent| is(sent, true, MessageKind::Birth) && life(&sent.2) == &Number::LongValue(1))
        });
        wait_until("its device", || count(&received, false, &MessageKind::Birth) >= 3);
        monitor.end();
        wait_until("the death", || {
            let received = received.lock().unwrap();
            received.iter().any(|sent| is(sent, true, MessageKind::Death) && life(&sent.2) == &Number::LongValue(1))
        });
        // Every event of the log was published, also those of the time without a broker.
        let received = received.lock().unwrap();
        let texts = received.iter().flat_map(|sent| &sent.2.metrics).filter_map(|metric| match &metric.value {
            Some(Number::StringValue(text)) => Some(text.as_str()),
            _ => None,
        });
        let published: Vec<&str> = texts.collect();
        let log = sandbox.log();
        assert!(log.lines().count() >= 2);
        for line in log.lines() {
            assert!(published.contains(&line), "{line}");
        }
    }

    #[test]
    fn the_last_will_is_the_death_of_the_node() {
        let sandbox = Sandbox::new();
        let _broker = sandbox.broker();
        let (received, _client) = host(&sandbox);
        let monitor = sandbox.monitor_with("--sparkplug", "works/hall/pump", "password");
        wait_until("the birth", || count(&received, true, &MessageKind::Birth) == 1);
        drop(monitor);
        wait_until("the last will", || count(&received, true, &MessageKind::Death) == 1);
        let received = received.lock().unwrap();
        let death = &received.last().unwrap().2;
        assert_eq!((life(death), death.metrics[0].datatype), (&Number::LongValue(0), Some(DataType::Int64 as u32)));
    }
}
