//! A source of frames over TCP that keeps what was not acknowledged, and a monitor that can be killed under it.

pub use crate::live::{connected, port};
use crate::support::{DEMO_SCENE, Sandbox, short_recording, swap};
use serde_json::Value;
use std::cell::Cell;
use std::io::{BufRead, BufReader, Write};
use std::net::{Shutdown, TcpStream};
use std::path::Path;
use std::process::{Child, Command};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Sampling rate of the frames, Hz: a quarter of the demonstration's.
pub const RATE: u64 = 3200;
/// Samples of a turn at that rate.
const TURN: u64 = 64;
/// Samples that may be sent beyond the last acknowledged one.
const WINDOW: u64 = 6 * RATE;
/// How long a monitor may take for a step of a test.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// A spike on the first probe every 1.3 s, which exceeds its limit in one block.
pub fn spike(number: u64) -> u64 {
    3 * RATE / 10 + number * (RATE + 3 * RATE / 10)
}

/// Vibration on the third probe for 2 s in every 6 s, which exceeds its limit for longer than the limit's duration.
pub fn plateau(number: u64) -> std::ops::Range<u64> {
    (1 + 6 * number) * RATE..(3 + 6 * number) * RATE
}

/// The demonstration's scene at the frames' rate, with a limit for the spikes and one for the plateaus.
pub fn scene() -> String {
    swap(DEMO_SCENE, "rate = \"12.8 kHz\"", "rate = \"3.2 kHz\"")
        + "\n[[limit]]\nindicator = \"peak-to-peak\"\nprobe = \"DE_X_um\"\nmax = \"2.5 um\"\n"
        + "\n[[limit]]\nindicator = \"peak-to-peak\"\nprobe = \"NDE_X_um\"\nmax = \"2.5 um\"\nduration = \"0.5 s\"\n"
}

/// Waits until `holds` does.
pub fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let since = Instant::now();
    while !holds() {
        assert!(since.elapsed() < PATIENCE, "timed out: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Sends a signal such as `TERM`.
pub fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Frames of the demonstration's motion with spikes and plateaus.
struct Frames {
    rows: Vec<Vec<f32>>,
}

impl Frames {
    fn new() -> Self {
        let cells = |line: &str| line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
        Self { rows: short_recording(12_800).lines().skip(1).step_by(4).map(cells).collect() }
    }

    fn readings(&self, index: u64) -> Vec<f32> {
        let mut row = self.rows[index as usize % self.rows.len()].clone();
        let number = index.saturating_sub(spike(0)) / (spike(1) - spike(0));
        if index == spike(number) {
            row[0] += 5.0;
        }
        if plateau(index / (6 * RATE)).contains(&index) && index.is_multiple_of(2) {
            row[2] += 5.0;
        }
        // The pulse is too short to be there in every fourth sample.
        *row.last_mut().unwrap() = if index % TURN < 3 { 1.0 } else { 0.0 };
        row
    }
}

/// Readings of a sample; none of one that the source loses.
pub type Readings = Box<dyn Fn(u64) -> Vec<f32>>;

/// A sandbox with a monitor's folders, and a source that stores the acknowledged sequence number.
pub struct Rig {
    pub sandbox: Sandbox,
    pub port: u16,
    readings: Readings,
    /// Samples that may be sent beyond the last acknowledged one.
    window: u64,
    /// Sequence number of the sample 0.
    pub first_number: Cell<u32>,
    options: Vec<String>,
    /// Samples that were sent.
    pub sent: Arc<AtomicU64>,
    /// Samples that were acknowledged.
    pub acknowledged: Arc<AtomicU64>,
}

/// A connection of the source, and what it still has to send. Where it is dropped, it stays open and silent.
pub struct Connection {
    stream: TcpStream,
    unsent: Vec<u8>,
    /// The next sample.
    next: u64,
}

impl Connection {
    /// Ends the connection, wherever it is.
    pub fn close(self) {
        let _ = self.stream.shutdown(Shutdown::Both);
    }
}

impl Rig {
    /// With `options` of the monitor besides its source.
    pub fn new(options: &[&str]) -> Self {
        let frames = Frames::new();
        Self::with(Sandbox::with(&scene(), ""), Box::new(move |index| frames.readings(index)), WINDOW, options)
    }

    /// With the scene of a sandbox and a source of these readings, which sends `window` samples beyond the last
    /// acknowledged one.
    pub fn with(sandbox: Sandbox, readings: Readings, window: u64, options: &[&str]) -> Self {
        let options = options.iter().map(|&option| option.to_owned()).collect();
        let (first_number, sent, acknowledged) = (Cell::new(0), Arc::default(), Arc::default());
        Self { sandbox, port: port(), readings, window, first_number, options, sent, acknowledged }
    }

    /// The frame of a sample; empty for one that the source loses.
    pub fn frame(&self, index: u64) -> Vec<u8> {
        let readings = (self.readings)(index);
        if readings.is_empty() {
            return vec![];
        }
        let number = (index as u32).wrapping_add(self.first_number.get()).to_le_bytes();
        number.into_iter().chain(readings.into_iter().flat_map(f32::to_le_bytes)).collect()
    }

    pub fn acknowledged(&self) -> u64 {
        self.acknowledged.load(Ordering::SeqCst)
    }

    pub fn start(&self) -> Child {
        self.command().spawn().unwrap()
    }

    /// The monitor's command.
    pub fn command(&self) -> Command {
        let source = format!("tcp:{}", self.port);
        let options: Vec<&str> = self.options.iter().map(String::as_str).collect();
        let args = ["replay", "scene.toml", "--paced", "--format", "json", "--source", &source, "--encoding", "frames"];
        self.sandbox.command(&[&args[..], &options].concat())
    }

    /// A connection whose acknowledgements are counted.
    pub fn connect(&self) -> TcpStream {
        let stream = connected(self.port);
        stream.set_write_timeout(Some(Duration::from_millis(50))).unwrap();
        let lines = BufReader::new(stream.try_clone().unwrap()).lines();
        let (acknowledged, sent, first) = (self.acknowledged.clone(), self.sent.clone(), self.first_number.get());
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                // A kill may cut a line short.
                if let Some(Ok(last)) = line.strip_prefix("acknowledged ").map(str::parse::<u32>) {
                    let index = u64::from(last.wrapping_sub(first)) + 1;
                    // After a restart of the count there may be an acknowledgement of the former one.
                    if index <= sent.load(Ordering::SeqCst) {
                        acknowledged.fetch_max(index, Ordering::SeqCst);
                    }
                }
            }
        });
        stream
    }

    /// Sends what was not acknowledged, up to the sample `end`, until `until` holds.
    pub fn feed(&self, end: u64, until: impl FnMut(&Self) -> bool) {
        self.feed_from(self.acknowledged(), end, PATIENCE, until);
    }

    /// Sends the samples from `next` to `end`, until `until` holds; returns the connection.
    pub fn feed_from(
        &self,
        mut next: u64,
        end: u64,
        patience: Duration,
        mut until: impl FnMut(&Self) -> bool,
    ) -> Connection {
        let (mut stream, first) = (self.connect(), next);
        let mut unsent = Vec::new();
        let since = Instant::now();
        while !until(self) {
            assert!(since.elapsed() < patience, "timed out with {} samples acknowledged", self.acknowledged());
            // A source that counts from another number knows of no acknowledgement of the samples before it.
            let most = end.min(self.acknowledged().max(first) + self.window).min(next + 256);
            if unsent.is_empty() {
                unsent.extend((next..most).flat_map(|index| self.frame(index)));
                next = next.max(most);
                self.sent.fetch_max(next, Ordering::SeqCst);
            }
            match stream.write(&unsent) {
                Ok(0) => std::thread::sleep(Duration::from_millis(5)),
                Ok(written) => drop(unsent.drain(..written)),
                Err(error) if matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut) => {
                }
                // Killed.
                Err(_) => std::thread::sleep(Duration::from_millis(5)),
            }
        }
        Connection { stream, unsent, next }
    }

    /// Ends a connection in good order: the monitor has all samples before the one that is returned.
    pub fn disconnect(&self, connection: Connection) -> u64 {
        let Connection { mut stream, unsent, next } = connection;
        stream.set_write_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(&unsent).unwrap();
        stream.shutdown(Shutdown::Write).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        wait_until("the end of the connection", || matches!(stream.peek(&mut [0]), Ok(0)));
        next
    }

    /// The events of the log of these kinds: kind, probe, start, s.
    pub fn limit_events(&self, log: &str) -> Vec<(String, String, f64)> {
        let text = if self.sandbox.path(log).exists() { self.sandbox.read(log) } else { String::new() };
        let event = |line: &str| {
            assert_eq!(line.matches("\"sentence\"").count(), 1, "a key stands twice: {line}");
            let event: Value = serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"));
            let text = |key: &str| event[key].as_str().map(str::to_owned);
            Some((text("kind")?, text("probe")?, event["start_s"].as_f64()?))
        };
        text.lines().filter_map(event).collect()
    }

    /// Time and samples of the seconds of every indicators file, in order.
    pub fn seconds(&self, folder: &str) -> Vec<(f64, f64)> {
        let path = |number: u32| self.sandbox.path(&format!("{folder}/indicators-{number:04}.parquet"));
        (1..).map(path).take_while(|path| path.exists()).flat_map(|path| seconds_of(&path)).collect()
    }
}

/// Time and samples of the seconds of an indicators file.
pub fn seconds_of(file: &Path) -> Vec<(f64, f64)> {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;
    use parquet::schema::types::Type;
    let reader = SerializedFileReader::new(std::fs::File::open(file).unwrap()).unwrap();
    let schema = reader.metadata().file_metadata().schema();
    let first = schema.get_fields()[..2].to_vec();
    let projection = Type::group_type_builder(schema.name()).with_fields(first).build().unwrap();
    let rows = reader.get_row_iter(Some(projection)).unwrap().map(Result::unwrap);
    rows.map(|row| (row.get_double(0).unwrap(), row.get_double(1).unwrap())).collect()
}
