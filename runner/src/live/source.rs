//! The reader's thread: rows from a file, from standard input or from a socket into the ring.
//!
//! Files, pipes and TCP connections block while the ring buffer is full. Datagrams cannot; those without room are
//! dropped and counted. A TCP source that goes away may come back, and it or another one goes on. A connection that does not
//! begin as a source does, or that has another sampling rate, is refused.

use super::address::Address;
use super::connections::{Beginning, Connections, Followed};
use super::datagrams::{Datagrams, LARGEST, Lines};
use super::feed::{Item, Sender, count};
use super::frames::{Layout, Place, Sequence};
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_twin::error::Error;
use ballrace_twin::recording::clock::check_rate;
use ballrace_twin::recording::flaws::{Flaw, FlawLedger, FlawSummary, Position};
use ballrace_twin::recording::{Reader, Row};
use ballrace_twin::scene::{Clock, Recording, RotationSource, Scene};
use socket2::SockRef;
use std::io::{BufReader, ErrorKind, Read};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// How often a reader that waits for its source looks whether it is to end.
const PATIENCE: Duration = Duration::from_millis(100);
/// Requested size of the system's datagram buffer.
const MOST_WAITING: usize = 4 << 20;
/// How far the sampling rates of two connections may lie apart.
const RATE_TOLERANCE: f64 = 1e-3;

/// Form of the samples on a stream.
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

/// Where a monitor that was stopped goes on.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Resume {
    /// Number of the next sample.
    pub index: u64,
    /// Sequence number of the frame that has it.
    pub sequence: Option<u32>,
}

/// Messages of a reader at its start and at its end.
pub struct Reading {
    /// Sampling rate, Hz, as soon as it is known.
    pub rate: mpsc::Receiver<Result<f64>>,
    /// The flaws it found, or what ended it.
    pub end: std::thread::JoinHandle<Result<Vec<FlawSummary>>>,
    /// The connection on which acknowledgements go back.
    pub back: AckChannel,
}

/// The connection of the present source, if it has one.
pub type AckChannel = Arc<Mutex<Option<TcpStream>>>;

/// Starts the reader of `address`.
///
/// # Errors
/// An address that cannot be listened at.
pub fn start(
    address: &Address,
    encoding: Encoding,
    scene: &Scene,
    recording: &Recording,
    resume: Resume,
    sender: Sender,
) -> Result<Reading> {
    let (tell, rate) = mpsc::channel();
    let back = AckChannel::default();
    let listener = match address {
        Address::Tcp(place) => Some(TcpListener::bind(place).with_context(|| cannot_listen(address))?),
        _ => None,
    };
    let socket = match address {
        Address::Udp(place) => Some(UdpSocket::bind(place).with_context(|| cannot_listen(address))?),
        _ => None,
    };
    let frame_rate = match recording.clock {
        Clock::Rate(rate) => rate,
        Clock::Column(_) => 0.0,
    };
    let feeder = Feeder {
        layout: Layout::new(recording, encoding == Encoding::FramesCrc),
        recording: recording.clone(),
        scene: scene.clone(),
        encoding,
        sequence: Sequence::new(frame_rate, resume.sequence, resume.index),
        suspect: None,
        next: resume.index,
        next_time: None,
        rate: None,
        sender,
        tell: Some(tell),
        ledger: FlawLedger::default(),
        flaws: vec![],
        back: back.clone(),
    };
    let address = address.clone();
    let read = move || feeder.run(&address, listener, socket);
    let end = std::thread::Builder::new().name("reader".to_owned()).spawn(read)?;
    Ok(Reading { rate, end, back })
}

fn cannot_listen(address: &Address) -> String {
    format!("{address}: cannot be listened at, allowed: an address of this machine and a free port")
}

struct Feeder {
    recording: Recording,
    scene: Scene,
    layout: Layout,
    encoding: Encoding,
    sequence: Sequence,
    /// A frame whose number does not fit, until the next one comes.
    suspect: Option<Row>,
    /// Number of the next sample of CSV.
    next: u64,
    /// Its time where a connection was followed before, s.
    next_time: Option<f64>,
    /// Sampling rate of the first connection, Hz.
    rate: Option<f64>,
    sender: Sender,
    tell: Option<mpsc::Sender<Result<f64>>>,
    ledger: FlawLedger,
    flaws: Vec<FlawSummary>,
    back: AckChannel,
}

impl Feeder {
    fn run(
        mut self,
        address: &Address,
        listener: Option<TcpListener>,
        socket: Option<UdpSocket>,
    ) -> Result<Vec<FlawSummary>> {
        let done = match (address, listener, socket) {
            (_, Some(listener), _) => self.connections(listener),
            (_, _, Some(socket)) => self.datagrams(socket),
            (Address::File(path), ..) => self.file(path),
            (Address::BuiltIn(bytes, name), ..) => self.stream(Box::new(std::io::Cursor::new(*bytes)), name),
            _ => self.stream(Box::new(std::io::stdin()), "standard input"),
        };
        match (done, &self.tell) {
            // No sample yet: the caller that waits for the rate receives the error.
            (Err(error), Some(tell)) => {
                let _ = tell.send(Err(error));
            }
            (done, _) => done?,
        }
        self.flaws.extend(self.ledger.summary());
        Ok(self.flaws)
    }

    /// Passes on the rate of the first connection, and refuses another one of a later connection.
    fn establish_rate(&mut self, rate: f64, name: &str) -> Result<()> {
        if let Some(known) = self.rate {
            if (rate / known - 1.0).abs() > RATE_TOLERANCE {
                bail!("{name}: found a sampling rate of {rate:.3} Hz, allowed: {known:.3} Hz as before");
            }
            return Ok(());
        }
        check_rate(rate, &self.recording, self.scene.shaft.speed).map_err(|e| Error::from(e.of(&self.scene, name)))?;
        self.rate = Some(rate);
        if let Some(tell) = self.tell.take() {
            let _ = tell.send(Ok(rate));
        }
        Ok(())
    }

    /// Frames have no header from which anything else could be learned.
    fn rate_of_frames(&self) -> Result<f64> {
        match self.recording.clock {
            Clock::Rate(rate) => Ok(rate),
            Clock::Column(_) => bail!(UsageError(
                "[recording] time: found a column of times, allowed with frames: rate = \"51.2 kHz\"".to_owned()
            )),
        }
    }

    fn file(&mut self, path: &Path) -> Result<()> {
        match self.encoding {
            Encoding::Csv => {
                let reader = Reader::open(path, &self.recording)?;
                // A file begins where it began before: what is done already is passed over.
                let done = std::mem::take(&mut self.next);
                self.rows(reader, done, &path.display().to_string())
            }
            Encoding::Frames | Encoding::FramesCrc => {
                let file = std::fs::File::open(path).with_context(|| path.display().to_string())?;
                self.stream(Box::new(file), &path.display().to_string())
            }
        }
    }

    fn stream(&mut self, stream: Box<dyn Read + Send>, name: &str) -> Result<()> {
        match self.encoding {
            Encoding::Csv => {
                let reader = Reader::from_reader(stream, Path::new(name), None, &self.recording)?;
                self.rows(reader, 0, name)
            }
            Encoding::Frames | Encoding::FramesCrc => self.frames(stream, name),
        }
    }

    /// Rows of text, those before the number `done` left out.
    fn rows(&mut self, mut reader: Reader, done: u64, name: &str) -> Result<()> {
        self.establish_rate(reader.rate(), name)?;
        // A new connection continues where the one before it ended, whatever its own clock.
        let rate = self.rate.unwrap_or_else(|| reader.rate());
        let (first, begin) = (self.next, self.next_time.unwrap_or(self.next as f64 / rate));
        let mut row = self.sender.blank();
        while !self.sender.is_stopped() && reader.next_row(&mut row)? {
            if row.index < done {
                continue;
            }
            if first > 0 {
                row.time = begin + row.index as f64 / rate;
                row.index += first;
            }
            (self.next, self.next_time) = (row.index + 1, Some(row.time + 1.0 / rate));
            let full = std::mem::replace(&mut row, self.sender.blank());
            self.sender.push(Item::Row(full));
        }
        self.flaws.extend(reader.flaws().summary());
        Ok(())
    }

    fn frames(&mut self, stream: Box<dyn Read + Send>, name: &str) -> Result<()> {
        let rate = self.rate_of_frames()?;
        self.establish_rate(rate, name)?;
        let mut stream = BufReader::new(stream);
        let mut frame = vec![0; self.layout.size()];
        let (mut held, mut aligned) = (0, true);
        while !self.sender.is_stopped() {
            match stream.read(&mut frame[held..]) {
                Ok(0) => break,
                Ok(read) => held += read,
                Err(error) if is_wait(&error) => continue,
                Err(error) => return Err(error).context("frames cannot be read further"),
            }
            if held < frame.len() {
                continue;
            }
            if self.layout.is_whole(&frame) {
                (held, aligned) = (0, true);
                self.frame(&frame, false);
                continue;
            }
            // The next frame may begin at any byte.
            if std::mem::replace(&mut aligned, false) {
                count(&self.sender.counts.malformed, 1);
            }
            frame.copy_within(1.., 0);
            held -= 1;
        }
        if held > 0 && aligned {
            count(&self.sender.counts.malformed, 1);
        }
        Ok(())
    }

    fn frame(&mut self, frame: &[u8], may_drop: bool) {
        let mut row = self.sender.blank();
        let Some(number) = self.layout.read(frame, &mut row) else {
            count(&self.sender.counts.malformed, 1);
            return;
        };
        let open = self.sender.counts.acknowledged.load(Ordering::Relaxed);
        let place = self.sequence.place(number, Instant::now(), (open != u64::MAX).then_some(open));
        let suspect = self.suspect.take();
        if suspect.is_some() && !matches!(place, Place::AnewFromSuspect { .. }) {
            count(&self.sender.counts.malformed, 1);
        }
        match place {
            Place::Repeated => count(&self.sender.counts.repeated, 1),
            Place::Suspect => self.suspect = Some(row),
            Place::Sample { index, lost } => self.sample(row, number, index, lost, may_drop),
            Place::Anew { index } => {
                self.note_new_count(number);
                self.sample(row, number, index, 0, may_drop);
            }
            Place::AnewFromSuspect { index } => {
                self.note_new_count(number.wrapping_sub(1));
                if let Some(suspect) = suspect {
                    self.sample(suspect, number.wrapping_sub(1), index, 0, may_drop);
                }
                self.sample(row, number, index + 1, 0, may_drop);
            }
        }
    }

    fn note_new_count(&mut self, number: u32) {
        let sentence =
            format!("The source restarted its sample counter at {number}; time continues from the last sample.");
        self.sender.note("source-counts-anew", sentence);
    }

    /// Hands on the readings of frame `number`, which are sample `index`, with `lost` samples missing before it.
    fn sample(&mut self, mut row: Row, number: u32, index: u64, lost: u64, may_drop: bool) {
        let offset = u64::from(number.wrapping_sub(index as u32)) | 1 << 32;
        self.sender.counts.since.store(self.sequence.since(), Ordering::Release);
        self.sender.counts.offset.store(offset, Ordering::Relaxed);
        row.index = index;
        row.line = index + 1;
        row.time = index as f64 / self.rate.unwrap_or(1.0);
        let at = Position::from(&row);
        if lost > 0 {
            count(&self.sender.counts.lost, lost);
            self.ledger.record(Flaw::Gap, None, at, lost);
        }
        for (reading, probe) in row.probes.iter().zip(&self.recording.probes) {
            if reading.is_nan() {
                self.ledger.record(Flaw::MissingValue, Some(&probe.column), at, 1);
            }
        }
        if may_drop { self.sender.push_or_drop(row) } else { self.sender.push(Item::Row(row)) }
    }

    /// Returns the first bytes that a source of this scene sends.
    fn beginning(&self) -> Beginning {
        if self.encoding != Encoding::Csv {
            return Beginning::Frame(self.layout.clone());
        }
        let mut names: Vec<String> = self.recording.probes.iter().map(|probe| probe.column.clone()).collect();
        match &self.recording.rotation {
            RotationSource::Keyphasor { column, .. } | RotationSource::SpeedColumn { column, .. } => {
                names.push(column.clone())
            }
            RotationSource::Scene => {}
        }
        if let Clock::Column(column) = &self.recording.clock {
            names.push(column.clone());
        }
        Beginning::Columns(names)
    }

    fn connections(&mut self, listener: TcpListener) -> Result<()> {
        if self.encoding != Encoding::Csv {
            let rate = self.rate_of_frames()?;
            self.establish_rate(rate, "frames")?;
        }
        let connections = Connections::new(listener, self.beginning(), self.sender.notes())?;
        let connections = Arc::new(Mutex::new(connections));
        while !self.sender.is_stopped() {
            let next = lock(&connections).take();
            match next {
                Some((stream, peer)) => self.connection(stream, peer, &connections)?,
                None => std::thread::sleep(PATIENCE / 4),
            }
        }
        Ok(())
    }

    /// Follows a connection to its end. Errors of one source do not end the monitor.
    fn connection(&mut self, stream: TcpStream, peer: SocketAddr, others: &Arc<Mutex<Connections>>) -> Result<()> {
        stream.set_nonblocking(false)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let rows = self.sender.counts.rows.load(Ordering::Relaxed);
        count(&self.sender.counts.connections, 1);
        self.sender.note("source-connected", format!("Source {peer} connected."));
        *lock(&self.back) = stream.try_clone().ok();
        let replaced = Arc::new(AtomicBool::new(false));
        let followed = Followed {
            stream,
            connections: others.clone(),
            replaced: replaced.clone(),
            stopped: self.sender.stopped(),
            heard: Instant::now(),
        };
        let end = self.stream(Box::new(followed), &format!("tcp {peer}"));
        *lock(&self.back) = None;
        let (kind, words) = if replaced.load(Ordering::Relaxed) {
            ("source-replaced", "is silent; the next connection replaces it")
        } else {
            ("source-gone", "has gone; waiting for the next")
        };
        self.note_end(peer, end, kind, words, rows);
        Ok(())
    }

    /// Reports the end of a source that began after `rows` rows: `kind` and `words`, or its error.
    fn note_end(&mut self, peer: SocketAddr, end: Result<()>, kind: &'static str, words: &str, rows: u64) {
        if self.sender.is_stopped() {
            // The monitor has ended the connection.
            return;
        }
        let has_rows = self.sender.counts.rows.load(Ordering::Relaxed) > rows;
        let (kind, sentence) = match end {
            Ok(()) => (kind, format!("Source {peer} {words}.")),
            Err(error) if has_rows => ("source-failed", format!("Source {peer} ended: {error:#}.")),
            Err(error) => ("source-refused", format!("Source {peer} is refused: {error:#}.")),
        };
        self.sender.note(kind, sentence);
    }

    /// Follows the senders of text one after the other. Errors of one sender do not end the monitor.
    fn lines(&mut self, socket: UdpSocket) -> Result<()> {
        let datagrams = Datagrams::new(socket, self.beginning(), self.sender.notes());
        let datagrams = Arc::new(Mutex::new(datagrams));
        while !self.sender.is_stopped() {
            let next = lock(&datagrams).poll().context("datagrams cannot be read further")?;
            let Some(peer) = next else { continue };
            lock(&datagrams).follow();
            let rows = self.sender.counts.rows.load(Ordering::Relaxed);
            count(&self.sender.counts.connections, 1);
            self.sender.note("source-connected", format!("Source {peer} sends."));
            let lines = Lines { datagrams: datagrams.clone(), stopped: self.sender.stopped() };
            let end = self.stream(Box::new(lines), &format!("udp {peer}"));
            lock(&datagrams).leave();
            self.note_end(peer, end, "source-replaced", "restarted, or another source replaced it", rows);
        }
        Ok(())
    }

    fn datagrams(&mut self, socket: UdpSocket) -> Result<()> {
        socket.set_read_timeout(Some(PATIENCE))?;
        // A smaller buffer than requested is acceptable.
        let _ = SockRef::from(&socket).set_recv_buffer_size(MOST_WAITING);
        if self.encoding == Encoding::Csv {
            return self.lines(socket);
        }
        let rate = self.rate_of_frames()?;
        self.establish_rate(rate, "frames")?;
        let size = self.layout.size();
        let mut datagram = vec![0; LARGEST];
        while !self.sender.is_stopped() {
            match socket.recv(&mut datagram) {
                Ok(length) if length == 0 || length % size != 0 => count(&self.sender.counts.malformed, 1),
                Ok(length) => {
                    for frame in datagram.get(..length).unwrap_or_default().chunks_exact(size) {
                        self.frame(frame, true);
                    }
                }
                Err(error) if is_wait(&error) => {}
                Err(error) => return Err(error).context("datagrams cannot be read further"),
            }
        }
        Ok(())
    }
}

/// The read is to be repeated.
pub(super) fn is_wait(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

/// The connection, also where a thread broke while it had it: there is nothing in it that could be half done.
pub fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
