//! Messages to the service manager that started the monitor (systemd, `Type=notify`): readiness, watchdog and end.
//!
//! Without a service manager nothing is sent.

use std::time::{Duration, Instant};

/// Connection to the service manager.
pub struct Service {
    /// Interval of the watchdog messages; `None` without a watchdog.
    interval: Option<Duration>,
    next: Instant,
}

impl Service {
    /// Reports that the monitor listens to its source and that its outputs are open.
    #[must_use]
    pub fn ready() -> Self {
        send(Message::Ready);
        // Twice in the time after which the service manager restarts the monitor.
        Self { interval: watchdog_timeout().map(|timeout| timeout / 2), next: Instant::now() }
    }

    /// Reports that the monitor loop runs, if a message is due.
    pub fn keep_alive(&mut self) {
        if let Some(interval) = self.interval
            && Instant::now() >= self.next
        {
            self.next = Instant::now() + interval;
            send(Message::Alive);
        }
    }
}

impl Drop for Service {
    /// Reports that the monitor ends.
    fn drop(&mut self) {
        send(Message::Stopping);
    }
}

/// Message to the service manager.
enum Message {
    Ready,
    Alive,
    Stopping,
}

#[cfg(target_os = "linux")]
fn send(message: Message) {
    use sd_notify::NotifyState;
    let state = match message {
        Message::Ready => NotifyState::Ready,
        Message::Alive => NotifyState::Watchdog,
        Message::Stopping => NotifyState::Stopping,
    };
    // A service manager that does not listen does not stop the monitor; its watchdog restarts it.
    let _ = sd_notify::notify(&[state]);
}

#[cfg(target_os = "linux")]
fn watchdog_timeout() -> Option<Duration> {
    sd_notify::watchdog_enabled()
}

#[cfg(not(target_os = "linux"))]
fn send(message: Message) {
    match message {
        Message::Ready | Message::Alive | Message::Stopping => {}
    }
}

#[cfg(not(target_os = "linux"))]
const fn watchdog_timeout() -> Option<Duration> {
    None
}
