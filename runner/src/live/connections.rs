//! TCP connections: connections with a valid preamble are read one after the other; the others are refused.

use super::feed::{EventSender, StopFlag, lock};
use ballrace_twin::recording::frames::FrameLayout;
use socket2::{SockRef, TcpKeepalive};
use std::io::{ErrorKind, Read};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A source that is silent for this long is replaced by a waiting source.
pub const REPLACEMENT_TIMEOUT: Duration = Duration::from_secs(1);
/// Time limit for a complete preamble after the connection.
const PREAMBLE_TIMEOUT: Duration = Duration::from_secs(2);
/// Maximum number of waiting connections.
const MAX_CANDIDATES: usize = 16;
/// Maximum length of the first line, bytes.
const MAX_LINE_LENGTH: usize = 1 << 16;
/// Idle time before the first TCP keepalive probe, and the interval of the probes.
const PROBE_INTERVAL: Duration = Duration::from_secs(5);
/// Number of unanswered keepalive probes that end a connection.
const PROBES: u32 = 3;

/// First bytes that a source has to send.
pub enum Preamble {
    /// Header line with the names of these columns.
    Columns(Vec<String>),
    /// Valid frame.
    Frame(FrameLayout),
}

impl Preamble {
    /// Returns the first line if it is a header with the columns of the scene.
    pub fn header<'a>(&self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        let end = bytes.iter().position(|byte| *byte == b'\n')?;
        let line = bytes.get(..=end)?;
        (!line.trim_ascii().is_empty() && self.check(bytes)?.is_ok()).then_some(line)
    }

    /// Checks the first bytes; returns `None` while they are incomplete.
    ///
    /// # Errors
    /// Returns the reason if they are not the preamble of a source.
    fn check(&self, bytes: &[u8]) -> Option<Result<(), String>> {
        match self {
            Self::Frame(layout) => {
                let frame = bytes.get(..layout.size())?;
                Some(if layout.is_valid(frame) { Ok(()) } else { Err("the first frame has a wrong CRC-32".to_owned()) })
            }
            Self::Columns(names) => {
                let Some(end) = bytes.iter().position(|byte| *byte == b'\n') else {
                    let is_too_long = bytes.len() >= MAX_LINE_LENGTH;
                    return is_too_long.then(|| Err(format!("the first line has more than {MAX_LINE_LENGTH} bytes")));
                };
                let line = String::from_utf8_lossy(bytes.get(..end).unwrap_or_default());
                if line.trim().is_empty() {
                    // Blank lines may precede the header.
                    return Some(Ok(()));
                }
                let missing = names.iter().find(|name| !has_name(&line, name.trim()));
                Some(missing.map_or(Ok(()), |name| Err(format!("missing column `{name}` in the first line"))))
            }
        }
    }
}

/// Returns `true` if `line` contains `name`, not as a part of a longer name.
fn has_name(line: &str, name: &str) -> bool {
    let is_name_char = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(name).any(|(start, _)| {
        let (before, after) = (line.get(..start), line.get(start + name.len()..));
        !before.is_some_and(|text| text.ends_with(is_name_char))
            && !after.is_some_and(|text| text.starts_with(is_name_char))
    })
}

/// Configures the connection to end when the peer no longer answers.
fn detect_vanished_peer(stream: &TcpStream) -> std::io::Result<()> {
    let keepalive = TcpKeepalive::new().with_time(PROBE_INTERVAL).with_interval(PROBE_INTERVAL).with_retries(PROBES);
    SockRef::from(stream).set_tcp_keepalive(&keepalive)
}

/// Limits the time for which data sent to a silent peer may stay unacknowledged, because keepalive probes pause during this time. A
/// source that sends samples has no limit and stays connected, even if it reads nothing.
fn limit_unacknowledged_time(stream: &TcpStream, is_silent: bool) {
    #[cfg(target_os = "linux")]
    {
        // An error is ignored: without this limit the system ends the connection later.
        let limit = is_silent.then_some(PROBE_INTERVAL * (PROBES + 1));
        let _ = SockRef::from(stream).set_tcp_user_timeout(limit);
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (stream, is_silent);
}

/// Connection that waits to be read.
struct Candidate {
    stream: TcpStream,
    peer: SocketAddr,
    connected_at: Instant,
    has_sent: bool,
}

/// Listener that accepts connections and checks their preambles.
pub struct Connections {
    listener: TcpListener,
    preamble: Preamble,
    candidates: Vec<Candidate>,
    events: EventSender,
    buffer: Vec<u8>,
}

impl Connections {
    /// Creates the listener for sources with this `preamble`; refused connections are reported to `events`.
    ///
    /// # Errors
    /// Returns an error if the listener cannot be set to non-blocking mode.
    pub fn try_new(listener: TcpListener, preamble: Preamble, events: EventSender) -> std::io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self { listener, preamble, candidates: vec![], events, buffer: vec![0; MAX_LINE_LENGTH] })
    }

    /// Accepts new connections and checks their preambles; returns `true` if a source is waiting.
    pub fn poll(&mut self) -> bool {
        self.find_source().is_some()
    }

    /// Removes and returns the first waiting source.
    pub fn take(&mut self) -> Option<(TcpStream, SocketAddr)> {
        let Candidate { stream, peer, .. } = self.find_source().map(|i| self.candidates.remove(i))?;
        Some((stream, peer))
    }

    /// Returns the index of the first candidate with a valid preamble, and refuses those with an invalid one.
    fn find_source(&mut self) -> Option<usize> {
        self.accept();
        let mut i = 0;
        while let Some(candidate) = self.candidates.get_mut(i) {
            let check = match candidate.stream.peek(&mut self.buffer) {
                Ok(0) => Some(Err("it was closed without a sample".to_owned())),
                Ok(read) => {
                    candidate.has_sent = true;
                    self.preamble.check(self.buffer.get(..read).unwrap_or_default())
                }
                Err(error) if is_wait(&error) => None,
                Err(error) => Some(Err(error.to_string())),
            };
            match check {
                Some(Ok(())) => return Some(i),
                Some(Err(reason)) => self.refuse(i, &reason),
                None if candidate.has_sent && candidate.connected_at.elapsed() > PREAMBLE_TIMEOUT => {
                    self.refuse(i, "its first line or frame is incomplete");
                }
                None => i += 1,
            }
        }
        if self.candidates.len() == MAX_CANDIDATES {
            self.refuse(0, "too many connections are waiting");
        }
        None
    }

    fn accept(&mut self) {
        while self.candidates.len() < MAX_CANDIDATES
            && let Ok((stream, peer)) = self.listener.accept()
        {
            if detect_vanished_peer(&stream).and_then(|()| stream.set_nonblocking(true)).is_ok() {
                self.candidates.push(Candidate { stream, peer, connected_at: Instant::now(), has_sent: false });
            }
        }
    }

    fn refuse(&mut self, i: usize, reason: &str) {
        let candidate = self.candidates.remove(i);
        self.events.send("source-refused", format!("Connection {} was refused: {reason}.", candidate.peer));
    }
}

/// Connection of the current source.
///
/// A read blocks until data arrive, and returns 0 when the peer closes the connection, the monitor ends, or the source is
/// silent while another source is waiting.
pub struct SourceStream {
    /// Connection.
    pub stream: TcpStream,
    /// Waiting connections.
    pub connections: Arc<Mutex<Connections>>,
    /// Set when a waiting source replaces this one.
    pub is_replaced: Arc<AtomicBool>,
    /// Set when the monitor ends.
    pub stop: StopFlag,
    /// Time at which the last data arrived.
    pub last_arrival: Instant,
    /// No data have arrived for the interval of the keepalive probes.
    pub is_silent: bool,
}

impl SourceStream {
    fn set_silent(&mut self, is_silent: bool) {
        if std::mem::replace(&mut self.is_silent, is_silent) != is_silent {
            limit_unacknowledged_time(&self.stream, is_silent);
        }
    }
}

impl Read for SourceStream {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        loop {
            match self.stream.read(buffer) {
                Err(error) if is_wait(&error) => {
                    if self.stop.is_stopped() {
                        return Ok(0);
                    }
                    if lock(&self.connections).poll() && self.last_arrival.elapsed() >= REPLACEMENT_TIMEOUT {
                        self.is_replaced.store(true, Ordering::Relaxed);
                        return Ok(0);
                    }
                    self.set_silent(self.last_arrival.elapsed() >= PROBE_INTERVAL);
                }
                // A reset by the peer is an end of the connection, not an error.
                Err(error) if error.kind() == ErrorKind::ConnectionReset => return Ok(0),
                Ok(read) => {
                    self.last_arrival = Instant::now();
                    self.set_silent(false);
                    return Ok(read);
                }
                other => return other,
            }
        }
    }
}

/// Returns `true` for an error after which the read is to be repeated.
pub(super) fn is_wait(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn the_connection_of_a_vanished_peer_ends_after_20_seconds() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let stream = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        detect_vanished_peer(&stream).unwrap();
        let socket = SockRef::from(&stream);
        assert_eq!(socket.tcp_user_timeout().unwrap(), None, "a source may leave acknowledgements unread");
        limit_unacknowledged_time(&stream, true);
        assert!(socket.keepalive().unwrap());
        let idle = socket.tcp_keepalive_time().unwrap();
        let probes = socket.tcp_keepalive_interval().unwrap() * socket.tcp_keepalive_retries().unwrap();
        assert_eq!(idle + probes, Duration::from_secs(20));
        assert_eq!(socket.tcp_user_timeout().unwrap(), Some(Duration::from_secs(20)));
    }

    #[test]
    fn a_name_inside_a_longer_name_is_not_found() {
        for header in ["t,DE_X", "\"DE_X\";t", "DE_X [um]\tt", " DE_X "] {
            assert!(has_name(header, "DE_X"), "{header}");
        }
        for header in ["t,NDE_X", "DE_X_um", "DE_X2", ""] {
            assert!(!has_name(header, "DE_X"), "{header}");
        }
    }
}
