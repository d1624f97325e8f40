//! Datagrams of text: a sender whose datagram begins with the header is followed; the datagrams of others are ignored.

use super::connections::{Beginning, SILENT};
use super::feed::{Notes, Stopped};
use super::source::{is_wait, lock};
use std::io::Read;
use std::net::{SocketAddr, UdpSocket};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Largest datagram.
pub const LARGEST: usize = 1 << 16;

/// Datagrams at a socket, sorted by sender.
pub struct Datagrams {
    socket: UdpSocket,
    beginning: Beginning,
    notes: Notes,
    buffer: Vec<u8>,
    /// Bytes to read next.
    waiting: Vec<u8>,
    /// The sender that is followed, and its last arrival.
    present: Option<(SocketAddr, Instant)>,
    /// The sender whose first datagram waits.
    next: Option<SocketAddr>,
    /// The sender followed last, and its header: after an error its rows are read on.
    last: Option<(SocketAddr, Vec<u8>)>,
}

impl Datagrams {
    /// Datagrams at `socket`, which has a read time-out; senders that are refused are reported to `notes`.
    #[must_use]
    pub fn new(socket: UdpSocket, beginning: Beginning, notes: Notes) -> Self {
        let buffer = vec![0; LARGEST];
        Self { socket, beginning, notes, buffer, waiting: vec![], present: None, next: None, last: None }
    }

    /// Receives for the length of the time-out and returns the sender whose first datagram waits.
    ///
    /// # Errors
    /// A socket that cannot be read.
    pub fn poll(&mut self) -> std::io::Result<Option<SocketAddr>> {
        if self.next.is_none() {
            self.receive()?;
        }
        Ok(self.next)
    }

    /// Follows the sender whose first datagram waits.
    pub fn follow(&mut self) {
        self.present = self.next.take().map(|peer| (peer, Instant::now()));
    }

    /// The sender that is followed has ended or failed; what waits of its datagram is left out.
    pub fn leave(&mut self) {
        self.present = None;
        if self.next.is_none() {
            self.waiting.clear();
        }
    }

    /// Receives one datagram, or none within the time-out.
    fn receive(&mut self) -> std::io::Result<()> {
        let (length, peer) = match self.socket.recv_from(&mut self.buffer) {
            Ok(received) => received,
            Err(error) if is_wait(&error) => return Ok(()),
            Err(error) => return Err(error),
        };
        let datagram = self.buffer.get(..length).unwrap_or_default();
        let is_present = self.present.is_some_and(|(present, _)| present == peer);
        if let Some(header) = self.beginning.header(datagram) {
            let gives_way = self.present.is_none_or(|(_, heard)| is_present || heard.elapsed() >= SILENT);
            if gives_way {
                self.last = Some((peer, header.to_vec()));
                self.waiting = datagram.to_vec();
                self.next = Some(peer);
            } else {
                self.refuse(peer, "another source is followed");
            }
            return Ok(());
        }
        match &self.last {
            _ if is_present => {
                self.present = Some((peer, Instant::now()));
                self.waiting.extend_from_slice(datagram);
            }
            Some((last, header)) if *last == peer && self.present.is_none() => {
                self.waiting = [header, datagram].concat();
                self.next = Some(peer);
            }
            _ => self.refuse(peer, "its datagram does not begin with a line of the scene's columns"),
        }
        Ok(())
    }

    fn refuse(&self, peer: SocketAddr, why: &str) {
        self.notes.send("source-refused", format!("Datagram of {peer} is refused: {why}."));
    }
}

/// The rows of the sender that is followed. A read waits until something comes, the sender begins anew, another one takes
/// its place, or the monitor ends.
pub struct Lines {
    /// All datagrams.
    pub datagrams: Arc<Mutex<Datagrams>>,
    /// Set where the monitor ends.
    pub stopped: Stopped,
}

impl Read for Lines {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let mut datagrams = lock(&self.datagrams);
        loop {
            if datagrams.next.is_some() || self.stopped.is_stopped() {
                return Ok(0);
            }
            if !datagrams.waiting.is_empty() {
                let read = datagrams.waiting.as_slice().read(buffer)?;
                datagrams.waiting.drain(..read);
                return Ok(read);
            }
            datagrams.receive()?;
        }
    }
}
