//! UDP datagrams of CSV lines: one sender whose first datagram starts with the header is read; other senders are ignored.

use super::connections::{Preamble, REPLACEMENT_TIMEOUT, is_wait};
use super::feed::{EventSender, StopFlag, lock};
use std::io::Read;
use std::net::{SocketAddr, UdpSocket};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Maximum length of a datagram, bytes.
pub const MAX_DATAGRAM_LENGTH: usize = 1 << 16;

/// Receiver of datagrams that selects the sender to read.
pub struct Datagrams {
    socket: UdpSocket,
    preamble: Preamble,
    events: EventSender,
    buffer: Vec<u8>,
    /// Received bytes that are not read yet.
    pending: Vec<u8>,
    /// Current sender, and the time of its last datagram.
    current: Option<(SocketAddr, Instant)>,
    /// Next sender, whose first datagram is in `pending`.
    next: Option<SocketAddr>,
    /// Last accepted sender and its header: after an error its rows are read without a new header.
    last_accepted: Option<(SocketAddr, Vec<u8>)>,
}

impl Datagrams {
    /// Creates the receiver of `socket`, which has a read time-out; refused senders are reported to `events`.
    #[must_use]
    pub fn new(socket: UdpSocket, preamble: Preamble, events: EventSender) -> Self {
        let buffer = vec![0; MAX_DATAGRAM_LENGTH];
        Self { socket, preamble, events, buffer, pending: vec![], current: None, next: None, last_accepted: None }
    }

    /// Receives at most one datagram within the read time-out and returns the next sender.
    ///
    /// # Errors
    /// Returns an error if the socket cannot be read.
    pub fn poll(&mut self) -> std::io::Result<Option<SocketAddr>> {
        if self.next.is_none() {
            self.receive()?;
        }
        Ok(self.next)
    }

    /// Makes the next sender the current one.
    pub fn start_next(&mut self) {
        self.current = self.next.take().map(|peer| (peer, Instant::now()));
    }

    /// Ends the current sender and discards its pending bytes.
    pub fn end_current(&mut self) {
        self.current = None;
        if self.next.is_none() {
            self.pending.clear();
        }
    }

    /// Receives at most one datagram within the read time-out.
    fn receive(&mut self) -> std::io::Result<()> {
        let (length, peer) = match self.socket.recv_from(&mut self.buffer) {
            Ok(received) => received,
            Err(error) if is_wait(&error) => return Ok(()),
            Err(error) => return Err(error),
        };
        let datagram = self.buffer.get(..length).unwrap_or_default();
        let is_current = self.current.is_some_and(|(current, _)| current == peer);
        if let Some(header) = self.preamble.header(datagram) {
            let is_accepted = self
                .current
                .is_none_or(|(_, last_arrival)| is_current || last_arrival.elapsed() >= REPLACEMENT_TIMEOUT);
            if is_accepted {
                self.last_accepted = Some((peer, header.to_vec()));
                self.pending = datagram.to_vec();
                self.next = Some(peer);
            } else {
                self.refuse(peer, "another source is active");
            }
            return Ok(());
        }
        match &self.last_accepted {
            _ if is_current => {
                self.current = Some((peer, Instant::now()));
                self.pending.extend_from_slice(datagram);
            }
            Some((sender, header)) if *sender == peer && self.current.is_none() => {
                self.pending = [header, datagram].concat();
                self.next = Some(peer);
            }
            _ => self.refuse(peer, "its first line does not have the columns of the scene"),
        }
        Ok(())
    }

    fn refuse(&self, peer: SocketAddr, reason: &str) {
        self.events.send("source-refused", format!("Datagram of {peer} was refused: {reason}."));
    }
}

/// Byte stream of the current sender.
///
/// A read blocks until data arrive, and returns 0 when the sender sends a new header, another sender replaces it, or the
/// monitor ends.
pub struct DatagramStream {
    /// Receiver of the datagrams.
    pub datagrams: Arc<Mutex<Datagrams>>,
    /// Set when the monitor ends.
    pub stop: StopFlag,
}

impl Read for DatagramStream {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let mut datagrams = lock(&self.datagrams);
        loop {
            if datagrams.next.is_some() || self.stop.is_stopped() {
                return Ok(0);
            }
            if !datagrams.pending.is_empty() {
                let read = datagrams.pending.as_slice().read(buffer)?;
                datagrams.pending.drain(..read);
                return Ok(read);
            }
            datagrams.receive()?;
        }
    }
}
