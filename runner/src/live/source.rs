//! The reader's thread: rows from a file, from standard input or from a socket into the ring.
//!
//! What can wait (a file, a pipe, a TCP connection) waits while the ring is full. Datagrams cannot; what finds no room is
//! dropped and counted. A TCP source that goes away may come back, and it or another one goes on.

use super::address::Address;
use super::feed::{Item, Note, Sender, count};
use super::frames::{Layout, Place, Sequence};
use ballrace_twin::recording::Reader;
use ballrace_twin::recording::error::RecordingError;
use ballrace_twin::recording::flaws::{Flaw, FlawLedger, FlawSummary, Position};
use ballrace_twin::scene::{Clock, Recording};
use anyhow::{Context, Result, bail};
use std::io::{ErrorKind, Read};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::path::Path;
use std::sync::mpsc;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// How often a reader that waits for its source looks whether it is to end.
const PATIENCE: Duration = Duration::from_millis(100);
/// Largest datagram.
const DATAGRAM: usize = 1 << 16;
/// The system is asked for this much room for datagrams.
const MOST_WAITING: usize = 4 << 20;

/// Form of the samples on a stream.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Encoding {
    /// Lines as in a CSV file, a header first.
    #[default]
    Csv,
    /// Binary: `u32` sequence number and one `f32` a column, little-endian.
    Frames,
}

/// Where a monitor that was stopped goes on.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Resume {
    /// Number of the next sample.
    pub index: u64,
    /// Sequence number of the frame that has it.
    pub sequence: Option<u32>,
}

/// What a reader tells at its start and at its end.
pub struct Reading {
    /// Sampling rate, Hz, as soon as it is known.
    pub rate: mpsc::Receiver<Result<f64>>,
    /// The flaws it found, or what ended it.
    pub end: std::thread::JoinHandle<Result<Vec<FlawSummary>>>,
    /// The connection on which acknowledgements go back.
    pub back: Back,
}

/// The connection of the present source, if it has one.
pub type Back = Arc<Mutex<Option<TcpStream>>>;

/// Starts the reader of `address`.
///
/// # Errors
/// An address that cannot be listened at.
pub fn start(
    address: &Address,
    encoding: Encoding,
    recording: &Recording,
    resume: Resume,
    sender: Sender,
) -> Result<Reading> {
    let (tell, rate) = mpsc::channel();
    let back = Back::default();
    let listener = match address {
        Address::Tcp(place) => Some(TcpListener::bind(place).with_context(|| cannot_listen(address))?),
        _ => None,
    };
    let socket = match address {
        Address::Udp(place) => Some(UdpSocket::bind(place).with_context(|| cannot_listen(address))?),
        _ => None,
    };
    let feeder = Feeder {
        layout: Layout::new(recording),
        recording: recording.clone(),
        encoding,
        sequence: Sequence { due: resume.sequence, index: resume.index },
        next: resume.index,
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
    layout: Layout,
    encoding: Encoding,
    sequence: Sequence,
    /// Number of the next sample of CSV.
    next: u64,
    sender: Sender,
    tell: Option<mpsc::Sender<Result<f64>>>,
    ledger: FlawLedger,
    flaws: Vec<FlawSummary>,
    back: Back,
}

impl Feeder {
    fn run(
        mut self,
        address: &Address,
        listener: Option<TcpListener>,
        socket: Option<UdpSocket>,
    ) -> Result<Vec<FlawSummary>> {
        let done = match (address, listener, socket) {
            (_, Some(listener), _) => self.connections(&listener),
            (_, _, Some(socket)) => self.datagrams(socket),
            (Address::File(path), ..) => self.file(path),
            (Address::BuiltIn(bytes, name), ..) => self.stream(Box::new(std::io::Cursor::new(*bytes)), name),
            _ => self.stream(Box::new(std::io::stdin()), "standard input"),
        };
        match (done, &self.tell) {
            // Nothing came yet: whoever waits for the rate is told why.
            (Err(error), Some(tell)) => {
                let _ = tell.send(Err(error));
            }
            (done, _) => done?,
        }
        self.flaws.extend(self.ledger.summary());
        Ok(self.flaws)
    }

    fn tell_rate(&mut self, rate: f64) {
        if let Some(tell) = self.tell.take() {
            let _ = tell.send(Ok(rate));
        }
    }

    fn note(&mut self, kind: &'static str, sentence: String) {
        self.sender.push(Item::Note(Note { kind, sentence }));
    }

    /// Frames have no header from which anything else could be learned.
    fn rate_of_frames(&self) -> Result<f64> {
        match self.recording.clock {
            Clock::Rate(rate) => Ok(rate),
            Clock::Column(_) => bail!(ballrace_twin::fault::SceneFault(
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
                self.rows(reader, done)
            }
            Encoding::Frames => {
                let file = std::fs::File::open(path).with_context(|| path.display().to_string())?;
                self.stream(Box::new(std::io::BufReader::new(file)), &path.display().to_string())
            }
        }
    }

    fn stream(&mut self, stream: Box<dyn Read + Send>, name: &str) -> Result<()> {
        match self.encoding {
            Encoding::Csv => {
                let reader = Reader::from_reader(stream, Path::new(name), None, &self.recording)?;
                self.rows(reader, 0)
            }
            Encoding::Frames => self.frames(stream),
        }
    }

    /// Rows of text, those before the number `done` left out.
    fn rows(&mut self, mut reader: Reader, done: u64) -> Result<()> {
        self.tell_rate(reader.rate());
        let (first, rate) = (self.next, reader.rate());
        let mut row = self.sender.blank();
        while !self.sender.is_stopped() && reader.next_row(&mut row)? {
            if row.index < done {
                continue;
            }
            if first > 0 {
                // Goes on from another connection, whatever its own clock says.
                row.index += first;
                row.time = row.index as f64 / rate;
            }
            self.next = row.index + 1;
            let full = std::mem::replace(&mut row, self.sender.blank());
            self.sender.push(Item::Row(full));
        }
        self.flaws.extend(reader.flaws().summary());
        Ok(())
    }

    fn frames(&mut self, mut stream: Box<dyn Read + Send>) -> Result<()> {
        let rate = self.rate_of_frames()?;
        self.tell_rate(rate);
        let mut frame = vec![0; self.layout.size()];
        let mut held = 0;
        while !self.sender.is_stopped() {
            match stream.read(&mut frame[held..]) {
                Ok(0) => break,
                Ok(read) => held += read,
                Err(error) if is_wait(&error) => continue,
                Err(error) => return Err(error).context("frames cannot be read further"),
            }
            if held == frame.len() {
                held = 0;
                self.frame(&frame, rate, false);
            }
        }
        if held > 0 {
            count(&self.sender.counts.malformed, 1);
        }
        Ok(())
    }

    fn frame(&mut self, frame: &[u8], rate: f64, may_drop: bool) {
        let mut row = self.sender.blank();
        let Some(number) = self.layout.read(frame, &mut row) else {
            count(&self.sender.counts.malformed, 1);
            return;
        };
        let (index, lost) = match self.sequence.place(number) {
            Place::Repeated => {
                count(&self.sender.counts.repeated, 1);
                return;
            }
            Place::Sample { index, lost } => (index, lost),
            Place::Anew { index } => {
                let sentence = format!("The source counts anew, from {number}; time goes on from the last sample.");
                self.note("source-counts-anew", sentence);
                (index, 0)
            }
        };
        let offset = u64::from(number.wrapping_sub(index as u32)) | 1 << 32;
        self.sender.counts.offset.store(offset, std::sync::atomic::Ordering::Relaxed);
        row.index = index;
        row.line = index + 1;
        row.time = index as f64 / rate;
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

    fn connections(&mut self, listener: &TcpListener) -> Result<()> {
        listener.set_nonblocking(true)?;
        if self.encoding == Encoding::Frames {
            let rate = self.rate_of_frames()?;
            self.tell_rate(rate);
        }
        while !self.sender.is_stopped() {
            match listener.accept() {
                Ok((stream, peer)) => self.connection(stream, peer)?,
                Err(error) if is_wait(&error) => std::thread::sleep(PATIENCE / 4),
                Err(error) => return Err(error).context("no connection can be accepted"),
            }
        }
        Ok(())
    }

    /// A connection to its end. What one source does wrong does not end the monitor.
    fn connection(&mut self, stream: TcpStream, peer: SocketAddr) -> Result<()> {
        stream.set_nonblocking(false)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        count(&self.sender.counts.connections, 1);
        self.note("source-connected", format!("Source {peer} connected."));
        *lock(&self.back) = stream.try_clone().ok();
        let patient = Patient { stream, stopped: self.sender.stopped() };
        let end = self.stream(Box::new(patient), &format!("tcp {peer}"));
        *lock(&self.back) = None;
        match end {
            Ok(()) => self.note("source-gone", format!("Source {peer} has gone; waiting for the next.")),
            // Before a first row, what is wrong is between source and scene.
            Err(error) if self.tell.is_some() || is_scene_fault(&error) => return Err(error),
            Err(error) => self.note("source-failed", format!("Source {peer} ended: {error:#}.")),
        }
        Ok(())
    }

    fn datagrams(&mut self, socket: UdpSocket) -> Result<()> {
        socket.set_read_timeout(Some(PATIENCE))?;
        enlarge(&socket);
        if self.encoding == Encoding::Csv {
            let lines = Lines { socket, stopped: self.sender.stopped(), datagram: vec![0; DATAGRAM], at: 0, end: 0 };
            return self.stream(Box::new(lines), "udp");
        }
        let rate = self.rate_of_frames()?;
        self.tell_rate(rate);
        let size = self.layout.size();
        let mut datagram = vec![0; DATAGRAM];
        while !self.sender.is_stopped() {
            match socket.recv(&mut datagram) {
                Ok(length) if length == 0 || length % size != 0 => count(&self.sender.counts.malformed, 1),
                Ok(length) => {
                    for frame in datagram.get(..length).unwrap_or_default().chunks_exact(size) {
                        self.frame(frame, rate, true);
                    }
                }
                Err(error) if is_wait(&error) => {}
                Err(error) => return Err(error).context("datagrams cannot be read further"),
            }
        }
        Ok(())
    }
}

/// Asks for room for bursts; what the system gives is enough where it gives less.
#[cfg(target_os = "linux")]
fn enlarge(socket: &UdpSocket) {
    use nix::sys::socket::{setsockopt, sockopt::RcvBuf};
    let _ = setsockopt(socket, RcvBuf, &MOST_WAITING);
}

#[cfg(not(target_os = "linux"))]
fn enlarge(_: &UdpSocket) {
    let _ = MOST_WAITING;
}

fn is_scene_fault(error: &anyhow::Error) -> bool {
    error.downcast_ref::<RecordingError>().is_some_and(RecordingError::is_scene_fault)
}

fn is_wait(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

/// The connection, also where a thread broke while it had it: there is nothing in it that could be half done.
pub fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// A connection that waits for as long as it takes, unless the monitor is to end.
struct Patient {
    stream: TcpStream,
    stopped: super::feed::Stopped,
}

impl Read for Patient {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        loop {
            match self.stream.read(buffer) {
                Err(error) if is_wait(&error) && !self.stopped.is_stopped() => {}
                Err(error) if is_wait(&error) => return Ok(0),
                // Gone without a word: as if it had said goodbye.
                Err(error) if error.kind() == ErrorKind::ConnectionReset => return Ok(0),
                other => return other,
            }
        }
    }
}

/// Datagrams of whole lines, as one stream.
struct Lines {
    socket: UdpSocket,
    stopped: super::feed::Stopped,
    datagram: Vec<u8>,
    at: usize,
    end: usize,
}

impl Read for Lines {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        while self.at == self.end {
            match self.socket.recv(&mut self.datagram) {
                Ok(length) => (self.at, self.end) = (0, length),
                Err(error) if is_wait(&error) && !self.stopped.is_stopped() => {}
                Err(error) if is_wait(&error) => return Ok(0),
                Err(error) => return Err(error),
            }
        }
        let mut waiting = self.datagram.get(self.at..self.end).unwrap_or_default();
        let read = waiting.read(buffer)?;
        self.at += read;
        Ok(read)
    }
}
