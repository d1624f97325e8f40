//! A machine that sends frames in real time.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;
use std::thread;
use std::time::{Duration, Instant};

/// Time between two packets.
const PACKET: Duration = Duration::from_millis(20);

/// Returns a port of this machine that is free now.
pub fn free_port() -> std::io::Result<u16> {
    Ok(TcpListener::bind(("127.0.0.1", 0))?.local_addr()?.port())
}

/// The source of one monitor.
pub struct Source<'a> {
    port: u16,
    frames: &'a [Vec<f32>],
}

impl<'a> Source<'a> {
    pub fn new(port: u16, frames: &'a [Vec<f32>]) -> Self {
        Self { port, frames }
    }

    /// Sends frames at `rate` (Hz) until `is_over`; returns their number. A write waits while the monitor does not read.
    pub fn run(&self, rate: u64, is_over: &AtomicBool) -> u64 {
        let Some(mut stream) = self.connected(is_over) else { return 0 };
        if let Ok(read) = stream.try_clone() {
            // The acknowledgements are read so that they do not fill the connection.
            thread::spawn(move || BufReader::new(read).lines().map_while(Result::ok).count());
        }
        let (start, mut sent) = (Instant::now(), 0_u64);
        let mut packet = vec![];
        while !is_over.load(Relaxed) {
            let due = (start.elapsed().as_secs_f64() * rate as f64) as u64;
            packet.clear();
            for number in sent..due {
                packet.extend((number as u32).to_le_bytes());
                let frame = &self.frames[number as usize % self.frames.len()];
                frame.iter().for_each(|reading| packet.extend(reading.to_le_bytes()));
            }
            if stream.write_all(&packet).is_err() {
                break;
            }
            sent = due;
            thread::sleep(PACKET);
        }
        sent
    }

    /// Connects as soon as the monitor listens.
    fn connected(&self, is_over: &AtomicBool) -> Option<TcpStream> {
        while !is_over.load(Relaxed) {
            match TcpStream::connect(("127.0.0.1", self.port)) {
                Ok(stream) => return Some(stream),
                Err(_) => thread::sleep(PACKET),
            }
        }
        None
    }
}
