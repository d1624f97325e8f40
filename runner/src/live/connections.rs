//! TCP connections: those that begin as a source does are followed one after the other; the others are refused.

use super::feed::{Notes, Stopped};
use super::frames::Layout;
use super::source::{is_wait, lock};
use socket2::{SockRef, TcpKeepalive};
use std::io::{ErrorKind, Read};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A source that is silent for this long gives way to a successor.
pub const SILENT: Duration = Duration::from_secs(1);
/// A beginning that is not complete within this time is refused.
const BEGINNING: Duration = Duration::from_secs(2);
/// Most connections that wait.
const WAITING: usize = 16;
/// Longest first line, bytes.
const LONGEST_LINE: usize = 1 << 16;
/// Idle time before the first TCP keepalive probe, and the interval of the probes.
const PROBE_INTERVAL: Duration = Duration::from_secs(5);
/// Keepalive probes without an answer after which the peer has vanished.
const PROBES: u32 = 3;

/// First bytes of a source.
pub enum Beginning {
    /// A line with the names of these columns.
    Columns(Vec<String>),
    /// A frame.
    Frame(Layout),
}

impl Beginning {
    /// Returns the first line where it is the header of a source.
    pub fn header<'a>(&self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        let end = bytes.iter().position(|byte| *byte == b'\n')?;
        let line = bytes.get(..=end)?;
        (!line.trim_ascii().is_empty() && self.judge(bytes)?.is_ok()).then_some(line)
    }

    /// Judges the first bytes: none where there are too few of them, else why they are not those of a source.
    fn judge(&self, bytes: &[u8]) -> Option<Result<(), String>> {
        match self {
            Self::Frame(layout) => {
                let frame = bytes.get(..layout.size())?;
                Some(if layout.is_whole(frame) { Ok(()) } else { Err("found a frame with a wrong CRC-32".to_owned()) })
            }
            Self::Columns(names) => {
                let Some(end) = bytes.iter().position(|byte| *byte == b'\n') else {
                    let long = bytes.len() >= LONGEST_LINE;
                    return long.then(|| Err(format!("found a first line of more than {LONGEST_LINE} bytes")));
                };
                let line = String::from_utf8_lossy(bytes.get(..end).unwrap_or_default());
                if line.trim().is_empty() {
                    // Blank lines may precede the header.
                    return Some(Ok(()));
                }
                let missing = names.iter().find(|name| !has_name(&line, name.trim()));
                Some(missing.map_or(Ok(()), |name| Err(format!("its first line has no column `{name}`"))))
            }
        }
    }
}

/// Returns true where `name` stands in `line` by itself, not as a part of a longer name.
fn has_name(line: &str, name: &str) -> bool {
    let is_inner = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(name).any(|(start, _)| {
        let (before, after) = (line.get(..start), line.get(start + name.len()..));
        !before.is_some_and(|text| text.ends_with(is_inner)) && !after.is_some_and(|text| text.starts_with(is_inner))
    })
}

/// Ends the connection of a peer that no longer answers, whether or not data for it are under way.
fn detect_vanished_peer(stream: &TcpStream) -> std::io::Result<()> {
    let socket = SockRef::from(stream);
    let keepalive = TcpKeepalive::new().with_time(PROBE_INTERVAL).with_interval(PROBE_INTERVAL).with_retries(PROBES);
    socket.set_tcp_keepalive(&keepalive)?;
    // Keepalive pauses while an acknowledgement waits for its confirmation.
    #[cfg(target_os = "linux")]
    socket.set_tcp_user_timeout(Some(PROBE_INTERVAL * (PROBES + 1)))?;
    Ok(())
}

struct Candidate {
    stream: TcpStream,
    peer: SocketAddr,
    since: Instant,
    /// It has sent something.
    speaks: bool,
}

/// Accepts connections.
pub struct Connections {
    listener: TcpListener,
    beginning: Beginning,
    candidates: Vec<Candidate>,
    notes: Notes,
    buffer: Vec<u8>,
}

impl Connections {
    /// Connections to `listener` that begin with `beginning`; refused ones are reported to `notes`.
    ///
    /// # Errors
    /// A listener that cannot be polled.
    pub fn new(listener: TcpListener, beginning: Beginning, notes: Notes) -> std::io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self { listener, beginning, candidates: vec![], notes, buffer: vec![0; LONGEST_LINE] })
    }

    /// Accepts and judges what has come; returns true where a source waits.
    pub fn poll(&mut self) -> bool {
        self.first().is_some()
    }

    /// The first source that waits.
    pub fn take(&mut self) -> Option<(TcpStream, SocketAddr)> {
        let Candidate { stream, peer, .. } = self.first().map(|i| self.candidates.remove(i))?;
        Some((stream, peer))
    }

    /// Place of the first source that waits.
    fn first(&mut self) -> Option<usize> {
        self.accept();
        let mut i = 0;
        while let Some(candidate) = self.candidates.get_mut(i) {
            let judged = match candidate.stream.peek(&mut self.buffer) {
                Ok(0) => Some(Err("it closed without a sample".to_owned())),
                Ok(read) => {
                    candidate.speaks = true;
                    self.beginning.judge(self.buffer.get(..read).unwrap_or_default())
                }
                Err(error) if is_wait(&error) => None,
                Err(error) => Some(Err(error.to_string())),
            };
            match judged {
                Some(Ok(())) => return Some(i),
                Some(Err(why)) => self.refuse(i, &why),
                None if candidate.speaks && candidate.since.elapsed() > BEGINNING => {
                    self.refuse(i, "its beginning is incomplete");
                }
                None => i += 1,
            }
        }
        if self.candidates.len() == WAITING {
            self.refuse(0, "too many connections wait");
        }
        None
    }

    fn accept(&mut self) {
        while self.candidates.len() < WAITING
            && let Ok((stream, peer)) = self.listener.accept()
        {
            if detect_vanished_peer(&stream).and_then(|()| stream.set_nonblocking(true)).is_ok() {
                self.candidates.push(Candidate { stream, peer, since: Instant::now(), speaks: false });
            }
        }
    }

    fn refuse(&mut self, i: usize, why: &str) {
        let candidate = self.candidates.remove(i);
        self.notes.send("source-refused", format!("Connection {} is refused: {why}.", candidate.peer));
    }
}

/// The connection of the present source. A read waits until something comes, the other side closes, the monitor ends, or
/// the source is silent while a successor waits.
pub struct Followed {
    /// The connection.
    pub stream: TcpStream,
    /// Others.
    pub connections: Arc<Mutex<Connections>>,
    /// Set where a successor takes over.
    pub replaced: Arc<AtomicBool>,
    /// Set where the monitor ends.
    pub stopped: Stopped,
    /// Last arrival.
    pub heard: Instant,
}

impl Read for Followed {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        loop {
            match self.stream.read(buffer) {
                Err(error) if is_wait(&error) => {
                    if self.stopped.is_stopped() {
                        return Ok(0);
                    }
                    if lock(&self.connections).poll() && self.heard.elapsed() >= SILENT {
                        self.replaced.store(true, Ordering::Relaxed);
                        return Ok(0);
                    }
                }
                // A connection that is reset has ended.
                Err(error) if error.kind() == ErrorKind::ConnectionReset => return Ok(0),
                Ok(read) => {
                    self.heard = Instant::now();
                    return Ok(read);
                }
                other => return other,
            }
        }
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn a_vanished_peer_is_given_up_after_20_seconds() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let stream = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        detect_vanished_peer(&stream).unwrap();
        let socket = SockRef::from(&stream);
        assert!(socket.keepalive().unwrap());
        let idle = socket.tcp_keepalive_time().unwrap();
        let probes = socket.tcp_keepalive_interval().unwrap() * socket.tcp_keepalive_retries().unwrap();
        assert_eq!(idle + probes, Duration::from_secs(20));
        assert_eq!(socket.tcp_user_timeout().unwrap(), Some(Duration::from_secs(20)));
    }

    #[test]
    fn a_name_is_not_a_part_of_another() {
        for header in ["t,DE_X", "\"DE_X\";t", "DE_X [um]\tt", " DE_X "] {
            assert!(has_name(header, "DE_X"), "{header}");
        }
        for header in ["t,NDE_X", "DE_X_um", "DE_X2", ""] {
            assert!(!has_name(header, "DE_X"), "{header}");
        }
    }
}
