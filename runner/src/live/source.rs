//! Reader thread: reads rows from a file, from standard input or from a socket into the ring.
//!
//! Files, pipes and TCP connections block while the ring is full. Datagrams cannot block; they are dropped and counted while
//! the ring is full. After the end of a TCP connection, the same or another source may connect and continue. A connection
//! with an invalid preamble or another sampling rate is refused.

use super::address::Address;
use super::connections::{Connections, Preamble, SourceStream, is_wait};
use super::datagrams::{DatagramStream, Datagrams, MAX_DATAGRAM_LENGTH};
use super::demonstration;
pub use super::feed::lock;
use super::feed::{FeedItem, FeedSender, add};
use super::frames::{FramePosition, SequenceTracker};
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_twin::error::Error;
use ballrace_twin::recording::clock::check_rate;
use ballrace_twin::recording::flaws::{Flaw, FlawLedger, FlawSummary, Position};
use ballrace_twin::recording::frames::FrameLayout;
use ballrace_twin::recording::{Reader, Row};
use ballrace_twin::scene::{Clock, KeyphasorSignal, Recording, RotationSource, Scene, Sequence};
use socket2::SockRef;
use std::io::{BufReader, Read, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// Time-out of socket operations, after which the reader checks whether the monitor has ended.
const SOCKET_TIMEOUT: Duration = Duration::from_millis(100);
/// Interval at which the reader checks for a new connection.
const CONNECTION_INTERVAL: Duration = Duration::from_millis(25);
/// Requested size of the system's receive buffer for datagrams, bytes.
const RECEIVE_BUFFER_SIZE: usize = 4 << 20;
/// Largest relative difference between the sampling rates of two connections.
const RATE_TOLERANCE: f64 = 1e-3;

/// Encoding of the samples on a stream.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Encoding {
    /// CSV lines with a header.
    #[default]
    Csv,
    /// Binary frames: a `u32` sequence number and one `f32` per column, little-endian.
    Frames,
    /// Binary frames followed by the `u32` CRC-32 of their bytes.
    FramesCrc,
}

/// Position at which a restarted monitor continues.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Resume {
    /// Number of the next sample.
    pub index: u64,
    /// Sequence number of the frame with this sample.
    pub sequence: Option<u32>,
}

/// Handle of a reader thread.
pub struct ReaderHandle {
    /// Receiver of the sampling rate, Hz, which the reader sends once.
    pub rate: mpsc::Receiver<Result<f64>>,
    /// Thread; its result is the flaws of the samples, or the error that ended it.
    pub thread: std::thread::JoinHandle<Result<Vec<FlawSummary>>>,
    /// Connection for acknowledgements.
    pub ack_channel: AckChannel,
}

/// Receiver of the acknowledgements, which changes with the connections.
pub type AckChannel = Arc<Mutex<AckReceiver>>;

/// Receiver of acknowledgements.
pub enum AckReceiver {
    /// The source on this TCP connection.
    Source(TcpStream),
    /// No source is connected.
    Absent,
    /// The source reads none: files, datagrams, and a source whose buffer is full.
    Unread,
}

impl AckReceiver {
    /// Sends the last sequence number that the source may discard. A source that leaves acknowledgements unread until its buffer is full gets
    /// no more of them; one that has closed the connection may not have read the last ones.
    pub fn send(&mut self, last: u32) {
        let Self::Source(stream) = self else { return };
        match stream.write_all(format!("acknowledged {last}\n").as_bytes()) {
            Ok(()) => {}
            Err(error) if is_wait(&error) => *self = Self::Unread,
            Err(_) => *self = Self::Absent,
        }
    }
}

/// Starts the reader thread of `address`.
///
/// # Errors
/// Returns an error if the socket cannot be bound.
pub fn start(
    address: &Address,
    encoding: Encoding,
    scene: &Scene,
    recording: &Recording,
    resume: Resume,
    sender: FeedSender,
) -> Result<ReaderHandle> {
    let (rate_sender, rate) = mpsc::channel();
    let receiver = if matches!(address, Address::Tcp(_)) { AckReceiver::Absent } else { AckReceiver::Unread };
    let ack_channel = AckChannel::new(Mutex::new(receiver));
    let listener = match address {
        Address::Tcp(local) => Some(TcpListener::bind(local).with_context(|| cannot_listen(address))?),
        _ => None,
    };
    let socket = match address {
        Address::Udp(local) => Some(UdpSocket::bind(local).with_context(|| cannot_listen(address))?),
        _ => None,
    };
    let frame_rate = match recording.clock {
        Clock::Rate(rate) => rate,
        Clock::Column { .. } | Clock::Stated | Clock::Number { .. } => 0.0,
    };
    let reader = SourceReader {
        layout: FrameLayout::new(recording, encoding == Encoding::FramesCrc),
        recording: recording.clone(),
        scene: scene.clone(),
        encoding,
        sequence: SequenceTracker::new(frame_rate, resume.sequence, resume.index),
        suspect: None,
        next_index: resume.index,
        next_time: None,
        rate: None,
        may_drop: socket.is_some(),
        sender,
        rate_sender: Some(rate_sender),
        ledger: FlawLedger::default(),
        flaws: vec![],
        ack_channel: ack_channel.clone(),
    };
    let address = address.clone();
    let run = move || reader.run(&address, listener, socket);
    let thread = std::thread::Builder::new().name("reader".to_owned()).spawn(run)?;
    Ok(ReaderHandle { rate, thread, ack_channel })
}

fn cannot_listen(address: &Address) -> String {
    format!("{address}: cannot listen on this address, expected an address of this machine and a free port")
}

/// Reader of a source; runs on the reader thread.
struct SourceReader {
    recording: Recording,
    scene: Scene,
    layout: FrameLayout,
    encoding: Encoding,
    sequence: SequenceTracker,
    /// Row of a suspect frame, until the next frame arrives.
    suspect: Option<Row>,
    /// Number of the next sample from CSV lines.
    next_index: u64,
    /// Time of this sample after an earlier connection, s.
    next_time: Option<f64>,
    /// Sampling rate of the first connection, Hz.
    rate: Option<f64>,
    /// The source has no flow control: samples are dropped while the ring is full.
    may_drop: bool,
    sender: FeedSender,
    /// `None` after the sampling rate was sent.
    rate_sender: Option<mpsc::Sender<Result<f64>>>,
    ledger: FlawLedger,
    flaws: Vec<FlawSummary>,
    ack_channel: AckChannel,
}

impl SourceReader {
    fn run(
        mut self,
        address: &Address,
        listener: Option<TcpListener>,
        socket: Option<UdpSocket>,
    ) -> Result<Vec<FlawSummary>> {
        let result = match (address, listener, socket) {
            (_, Some(listener), _) => self.read_connections(listener),
            (_, _, Some(socket)) => self.read_datagrams(socket),
            (Address::File(path), ..) => self.read_file(path),
            (Address::Demonstration, ..) => demonstration::start()
                .and_then(|stream| self.read_stream(Box::new(stream), &Address::Demonstration.to_string())),
            (Address::BuiltIn(bytes, name), ..) => self.read_stream(Box::new(std::io::Cursor::new(*bytes)), name),
            _ => self.read_stream(Box::new(std::io::stdin()), "standard input"),
        };
        match (result, &self.rate_sender) {
            // Before the first sample, the error goes to the receiver of the rate.
            (Err(error), Some(rate_sender)) => {
                let _ = rate_sender.send(Err(error));
            }
            (result, _) => result?,
        }
        self.flaws.extend(self.ledger.summary());
        Ok(self.flaws)
    }

    /// Sends the sampling rate of the first connection.
    ///
    /// # Errors
    /// Returns an error if a later connection has another sampling rate, or if the rate is not plausible for the scene.
    fn establish_rate(&mut self, rate: f64, name: &str) -> Result<()> {
        if let Some(known) = self.rate {
            if (rate / known - 1.0).abs() > RATE_TOLERANCE {
                bail!("{name}: sampling rate has changed: {rate:.3} Hz, expected {known:.3} Hz");
            }
            return Ok(());
        }
        check_rate(rate, &self.recording, self.scene.shaft.speed).map_err(|e| Error::from(e.of(&self.scene, name)))?;
        self.rate = Some(rate);
        if let Some(rate_sender) = self.rate_sender.take() {
            let _ = rate_sender.send(Ok(rate));
        }
        Ok(())
    }

    /// Returns the sampling rate of frames, which have no time column.
    fn frame_rate(&self) -> Result<f64> {
        let rotation = &self.recording.rotation;
        if matches!(rotation, RotationSource::Keyphasor { signal: KeyphasorSignal::Instants { .. }, .. }) {
            bail!(UsageError(
                "[recording] keyphasor.kind: \"instants\": frames have no instants, expected \"pulses\" or \"count\""
                    .to_owned()
            ));
        }
        match self.recording.clock {
            Clock::Rate(rate) => Ok(rate),
            Clock::Column { .. } => bail!(UsageError(
                "[recording] time: frames have no time column, expected a sampling rate, such as rate = \"51.2 kHz\""
                    .to_owned()
            )),
            Clock::Stated | Clock::Number { .. } => bail!(UsageError(
                "[recording] rate: frames state no rate, expected a sampling rate, such as rate = \"51.2 kHz\""
                    .to_owned()
            )),
        }
    }

    fn read_file(&mut self, path: &Path) -> Result<()> {
        match self.encoding {
            Encoding::Csv => {
                if self.recording.sequence == Some(Sequence::Snapshots) {
                    bail!(UsageError(
                        "[recording] sequence: \"snapshots\" in real time, expected \"continuous\", or replay without --paced"
                            .to_owned()
                    ));
                }
                if path.metadata().is_ok_and(|about| !about.is_file() && !about.is_dir()) {
                    // A named pipe or a device is a stream: it waits for its writer.
                    let file = std::fs::File::open(path).with_context(|| path.display().to_string())?;
                    return self.read_stream(Box::new(file), &path.display().to_string());
                }
                let reader = Reader::open(path, &self.recording)?;
                // A file starts at sample 0 again: samples from before a restart are skipped.
                let skipped = std::mem::take(&mut self.next_index);
                self.read_rows(reader, skipped, &path.display().to_string())
            }
            Encoding::Frames | Encoding::FramesCrc => {
                let file = std::fs::File::open(path).with_context(|| path.display().to_string())?;
                self.read_stream(Box::new(file), &path.display().to_string())
            }
        }
    }

    fn read_stream(&mut self, stream: Box<dyn Read + Send>, name: &str) -> Result<()> {
        match self.encoding {
            Encoding::Csv => {
                let reader = Reader::from_reader(stream, Path::new(name), None, &self.recording)?;
                self.read_rows(reader, 0, name)
            }
            Encoding::Frames | Encoding::FramesCrc => self.read_frames(stream, name),
        }
    }

    /// Reads the rows of a CSV stream or of a recording, except the first `skipped` rows.
    fn read_rows(&mut self, mut reader: Reader, skipped: u64, name: &str) -> Result<()> {
        self.establish_rate(reader.rate(), name)?;
        // A new connection continues at the end of the previous one, independent of its own clock.
        let rate = self.rate.unwrap_or_else(|| reader.rate());
        let (first_index, first_time) = (self.next_index, self.next_time.unwrap_or(self.next_index as f64 / rate));
        let mut row = self.sender.spare_row();
        while !self.sender.is_stopped() && reader.next_row(&mut row)? {
            if row.index < skipped {
                continue;
            }
            if first_index > 0 {
                row.time = first_time + row.index as f64 / rate;
                row.index += first_index;
            }
            (self.next_index, self.next_time) = (row.index + 1, Some(row.time + 1.0 / rate));
            let filled = std::mem::replace(&mut row, self.sender.spare_row());
            self.push_row(filled);
        }
        self.flaws.extend(reader.flaws().summary());
        Ok(())
    }

    fn read_frames(&mut self, stream: Box<dyn Read + Send>, name: &str) -> Result<()> {
        let rate = self.frame_rate()?;
        self.establish_rate(rate, name)?;
        let mut stream = BufReader::new(stream);
        let mut frame = vec![0; self.layout.size()];
        let (mut length, mut is_aligned) = (0, true);
        while !self.sender.is_stopped() {
            match stream.read(&mut frame[length..]) {
                Ok(0) => break,
                Ok(read) => length += read,
                Err(error) if is_wait(&error) => continue,
                Err(error) => return Err(error).context("frames cannot be read"),
            }
            if length < frame.len() {
                continue;
            }
            if self.layout.is_valid(&frame) {
                (length, is_aligned) = (0, true);
                self.process_frame(&frame);
                continue;
            }
            // Frames have no start marker: the next one is searched byte by byte.
            if std::mem::replace(&mut is_aligned, false) {
                add(&self.sender.counters.malformed, 1);
            }
            frame.copy_within(1.., 0);
            length -= 1;
        }
        if length > 0 && is_aligned {
            add(&self.sender.counters.malformed, 1);
        }
        Ok(())
    }

    /// Pushes a row; drops and counts it if the ring is full and the source cannot wait.
    fn push_row(&mut self, row: Row) {
        if self.may_drop { self.sender.push_or_drop(row) } else { self.sender.push(FeedItem::Row(row)) }
    }

    /// Pushes the samples of a frame.
    fn process_frame(&mut self, frame: &[u8]) {
        let mut row = self.sender.spare_row();
        let Some(number) = self.layout.read(frame, &mut row) else {
            add(&self.sender.counters.malformed, 1);
            return;
        };
        let acknowledged = self.sender.counters.acknowledged.load(Ordering::Relaxed);
        let acknowledged = (acknowledged != u64::MAX).then_some(acknowledged);
        let position = self.sequence.locate(number, Instant::now(), acknowledged);
        let suspect = self.suspect.take();
        if suspect.is_some() && !matches!(position, FramePosition::RestartedAtSuspect { .. }) {
            add(&self.sender.counters.malformed, 1);
        }
        match position {
            FramePosition::Repeated => add(&self.sender.counters.repeated, 1),
            FramePosition::Suspect => self.suspect = Some(row),
            FramePosition::Sample { index, lost } => self.push_sample(row, number, index, lost),
            FramePosition::Restarted { index } => {
                self.report_restart(number);
                self.push_sample(row, number, index, 0);
            }
            FramePosition::RestartedAtSuspect { index } => {
                self.report_restart(number.wrapping_sub(1));
                if let Some(suspect) = suspect {
                    self.push_sample(suspect, number.wrapping_sub(1), index, 0);
                }
                self.push_sample(row, number, index + 1, 0);
            }
        }
    }

    fn report_restart(&mut self, number: u32) {
        let sentence =
            format!("The source restarted its sequence numbers at {number}; time continues from the last sample.");
        self.sender.push_event("source-counts-anew", sentence);
    }

    /// Pushes the readings of frame `number` as sample `index`, with `lost` samples missing before it.
    fn push_sample(&mut self, mut row: Row, number: u32, index: u64, lost: u64) {
        let offset = u64::from(number.wrapping_sub(index as u32)) | 1 << 32;
        self.sender.counters.offset_since.store(self.sequence.restarted_at(), Ordering::Release);
        self.sender.counters.sequence_offset.store(offset, Ordering::Relaxed);
        row.index = index;
        row.line = index + 1;
        row.time = index as f64 / self.rate.unwrap_or(1.0);
        let position = Position::from(&row);
        if lost > 0 {
            add(&self.sender.counters.lost, lost);
            self.ledger.record(Flaw::Gap, None, position, lost);
        }
        let columns = channels(&self.recording);
        for (reading, column) in row.probes.iter().chain(&row.sensors).zip(columns) {
            if reading.is_nan() {
                self.ledger.record(Flaw::MissingValue, Some(column), position, 1);
            }
        }
        self.push_row(row);
    }

    /// Returns the preamble of a source for this scene.
    fn preamble(&self) -> Preamble {
        if self.encoding != Encoding::Csv {
            return Preamble::Frame(self.layout.clone());
        }
        let mut names: Vec<String> = channels(&self.recording).map(str::to_owned).collect();
        names.extend(self.recording.temperatures.iter().map(|channel| channel.column.clone()));
        match &self.recording.rotation {
            RotationSource::Keyphasor { column, .. } | RotationSource::SpeedColumn { column, .. } => {
                names.push(column.clone())
            }
            RotationSource::Scene | RotationSource::Synchronous => {}
        }
        if let Clock::Column { name: column, .. } = &self.recording.clock {
            names.push(column.clone());
        }
        Preamble::Columns(names)
    }

    /// Reads sources from TCP connections one after the other, until the monitor ends.
    fn read_connections(&mut self, listener: TcpListener) -> Result<()> {
        if self.encoding != Encoding::Csv {
            let rate = self.frame_rate()?;
            self.establish_rate(rate, "frames")?;
        }
        let connections = Connections::try_new(listener, self.preamble(), self.sender.event_sender())?;
        let connections = Arc::new(Mutex::new(connections));
        while !self.sender.is_stopped() {
            let next = lock(&connections).take();
            match next {
                Some((stream, peer)) => self.read_connection(stream, peer, &connections)?,
                None => std::thread::sleep(CONNECTION_INTERVAL),
            }
        }
        Ok(())
    }

    /// Reads a connection to its end. An error of one source does not end the monitor.
    fn read_connection(
        &mut self,
        stream: TcpStream,
        peer: SocketAddr,
        connections: &Arc<Mutex<Connections>>,
    ) -> Result<()> {
        stream.set_nonblocking(false)?;
        stream.set_read_timeout(Some(SOCKET_TIMEOUT))?;
        stream.set_write_timeout(Some(SOCKET_TIMEOUT))?;
        let rows = self.sender.counters.rows.load(Ordering::Relaxed);
        add(&self.sender.counters.connections, 1);
        self.sender.push_event("source-connected", format!("Source {peer} connected."));
        *lock(&self.ack_channel) = stream.try_clone().map_or(AckReceiver::Unread, AckReceiver::Source);
        let is_replaced = Arc::new(AtomicBool::new(false));
        let source = SourceStream {
            stream,
            connections: connections.clone(),
            is_replaced: is_replaced.clone(),
            stop: self.sender.stop_flag(),
            last_arrival: Instant::now(),
            is_silent: false,
        };
        let result = self.read_stream(Box::new(source), &format!("tcp {peer}"));
        *lock(&self.ack_channel) = AckReceiver::Absent;
        let (kind, reason) = if is_replaced.load(Ordering::Relaxed) {
            ("source-replaced", "is silent and is replaced by the next connection")
        } else {
            ("source-gone", "disconnected; the monitor waits for the next connection")
        };
        self.report_end(peer, result, kind, reason, rows);
        Ok(())
    }

    /// Reports the end of a source that started after `rows` rows: its error, or else `kind` and `reason`.
    fn report_end(&mut self, peer: SocketAddr, result: Result<()>, kind: &'static str, reason: &str, rows: u64) {
        if self.sender.is_stopped() {
            // The monitor has ended, not the source.
            return;
        }
        let has_rows = self.sender.counters.rows.load(Ordering::Relaxed) > rows;
        let (kind, sentence) = match result {
            Ok(()) => (kind, format!("Source {peer} {reason}.")),
            Err(error) if has_rows => ("source-failed", format!("Source {peer} failed: {error:#}.")),
            Err(error) => ("source-refused", format!("Source {peer} was refused: {error:#}.")),
        };
        self.sender.push_event(kind, sentence);
    }

    /// Reads the senders of CSV lines one after the other. An error of one sender does not end the monitor.
    fn read_datagram_lines(&mut self, socket: UdpSocket) -> Result<()> {
        let datagrams = Datagrams::new(socket, self.preamble(), self.sender.event_sender());
        let datagrams = Arc::new(Mutex::new(datagrams));
        while !self.sender.is_stopped() {
            let next = lock(&datagrams).poll().context("datagrams cannot be read")?;
            let Some(peer) = next else { continue };
            lock(&datagrams).start_next();
            let rows = self.sender.counters.rows.load(Ordering::Relaxed);
            add(&self.sender.counters.connections, 1);
            self.sender.push_event("source-connected", format!("Source {peer} started to send."));
            let stream = DatagramStream { datagrams: datagrams.clone(), stop: self.sender.stop_flag() };
            let result = self.read_stream(Box::new(stream), &format!("udp {peer}"));
            lock(&datagrams).end_current();
            self.report_end(peer, result, "source-replaced", "restarted, or another source replaced it", rows);
        }
        Ok(())
    }

    fn read_datagrams(&mut self, socket: UdpSocket) -> Result<()> {
        socket.set_read_timeout(Some(SOCKET_TIMEOUT))?;
        // The system may grant a smaller buffer.
        let _ = SockRef::from(&socket).set_recv_buffer_size(RECEIVE_BUFFER_SIZE);
        if self.encoding == Encoding::Csv {
            return self.read_datagram_lines(socket);
        }
        let rate = self.frame_rate()?;
        self.establish_rate(rate, "frames")?;
        let size = self.layout.size();
        let mut datagram = vec![0; MAX_DATAGRAM_LENGTH];
        while !self.sender.is_stopped() {
            match socket.recv(&mut datagram) {
                Ok(length) if length == 0 || length % size != 0 => add(&self.sender.counters.malformed, 1),
                Ok(length) => {
                    for frame in datagram.get(..length).unwrap_or_default().chunks_exact(size) {
                        self.process_frame(frame);
                    }
                }
                Err(error) if is_wait(&error) => {}
                Err(error) => return Err(error).context("datagrams cannot be read"),
            }
        }
        Ok(())
    }
}

/// Returns the columns of probes, then of sensors.
fn channels(recording: &Recording) -> impl Iterator<Item = &str> {
    let probes = recording.probes.iter().map(|probe| probe.column.as_str());
    probes.chain(recording.sensors.iter().map(|sensor| sensor.column.as_str()))
}
