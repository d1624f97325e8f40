//! Publisher of indicators and events to an MQTT broker, at least once each.
//!
//! A message stays in the queue until the broker has acknowledged it. After a lost connection all unacknowledged messages are
//! sent again. Every connection has a new client of the library, because the library drops its own queue where a restarted broker does
//! not know its client any more.

use super::super::feed::lock;
use super::broker::{Access, MAX_LENGTH, Url};
use anyhow::Result;
use ballrace_twin::record::EventMessage;
use rumqttc::{Client, Event, LastWill, MqttOptions, Outgoing, Packet, QoS};
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Messages that wait for an acknowledgement of the broker at the same time.
const WINDOW: usize = 64;
/// Maximum number of messages in the queue; further ones are counted as lost.
const MAX_PENDING: usize = 10_000;
/// Interval between two connection attempts.
const RETRY_INTERVAL: Duration = Duration::from_secs(1);
/// Time for sending queued messages at the end.
const FLUSH_TIME: Duration = Duration::from_secs(2);
/// Topic below the monitor's with the retained `online` or `offline`.
const STATUS: &str = "status";

/// Message in the queue.
#[derive(Clone)]
struct Message {
    topic: String,
    payload: String,
    is_retained: bool,
}

/// Messages that the broker has not acknowledged, in order.
#[derive(Default)]
struct Queue {
    messages: VecDeque<Message>,
    /// Number of messages at the front that were passed to the client since it connected.
    sent: usize,
    /// Client of the present connection.
    client: Option<Client>,
    /// Time at which the connection was lost.
    lost_connection: Option<Instant>,
    /// Messages dropped because too many were pending.
    dropped: u64,
    is_finishing: bool,
    events: Vec<EventMessage>,
}

impl Queue {
    /// Passes as many messages to the client as the window allows.
    fn send(&mut self) {
        let Some(client) = &self.client else { return };
        while self.sent < WINDOW
            && let Some(Message { topic, payload, is_retained }) = self.messages.get(self.sent).cloned()
            && client.try_publish(topic, QoS::AtLeastOnce, is_retained, payload).is_ok()
        {
            self.sent += 1;
        }
    }

    fn begin(&mut self, client: Client, status: String) {
        // Each acknowledgement removes a message of the queue, so that this message must not be acknowledged.
        let _ = client.try_publish(status, QoS::AtMostOnce, true, "online");
        self.client = Some(client);
        if let Some(since) = self.lost_connection.take() {
            let sentence = format!("The MQTT broker responds again, after {:.0} s.", since.elapsed().as_secs_f64());
            self.events.push(EventMessage { kind: "output-recovered", sentence });
        }
        self.send();
    }

    /// Removes the oldest sent message: a broker acknowledges messages in their order (MQTT 3.1.1, 4.6).
    fn acknowledge(&mut self) {
        if self.sent > 0 {
            self.messages.pop_front();
            self.sent -= 1;
        }
        self.send();
    }

    fn disconnect(&mut self, broker: &str, error: &rumqttc::ConnectionError) {
        (self.client, self.sent) = (None, 0);
        if self.lost_connection.is_none() {
            self.lost_connection = Some(Instant::now());
            let sentence = format!(
                "MQTT broker {broker}: {error}; the monitor continues, keeps the messages and retries every second."
            );
            self.events.push(EventMessage { kind: "output-failing", sentence });
        }
    }
}

/// Queue and the signal of its changes.
#[derive(Default)]
struct Shared {
    queue: Mutex<Queue>,
    changed: Condvar,
}

/// Connection to a broker, on a thread of its own.
pub struct Publisher {
    shared: Arc<Shared>,
    topic: String,
    thread: JoinHandle<()>,
}

impl Publisher {
    /// Starts the connection to the broker of `--mqtt`.
    ///
    /// # Errors
    /// Returns an error if the URL is invalid or a file cannot be read. A broker that cannot be reached is not an error.
    pub fn connect(url: &str, access: &Access) -> Result<Self> {
        let url = Url::parse("--mqtt", "TOPIC", url)?;
        let mut options = access.options(&url)?;
        options.set_last_will(LastWill::new(format!("{}/{STATUS}", url.topic), "offline", QoS::AtLeastOnce, true));
        Self::start(options, url.topic)
    }

    fn start(options: MqttOptions, topic: &str) -> Result<Self> {
        let shared = Arc::<Shared>::default();
        let (of_thread, status) = (shared.clone(), format!("{topic}/{STATUS}"));
        let thread =
            std::thread::Builder::new().name("mqtt".to_owned()).spawn(move || run(&of_thread, &options, &status))?;
        Ok(Self { shared, topic: topic.to_owned(), thread })
    }

    fn push(&self, subtopic: &str, payload: &str, is_retained: bool) {
        let mut queue = lock(&self.shared.queue);
        if queue.messages.len() >= MAX_PENDING || payload.len() > MAX_LENGTH / 2 {
            queue.dropped += 1;
            return;
        }
        let topic = format!("{}/{subtopic}", self.topic);
        queue.messages.push_back(Message { topic, payload: payload.to_owned(), is_retained });
        queue.send();
    }

    /// Publishes a message under `TOPIC/subtopic` with quality of service 1.
    pub fn publish(&self, subtopic: &str, payload: &str) {
        self.push(subtopic, payload, false);
    }

    /// Removes and returns the events about the connection.
    pub fn take_events(&self) -> Vec<EventMessage> {
        std::mem::take(&mut lock(&self.shared.queue).events)
    }

    /// Returns the number of messages that are lost, or wait for a broker that does not answer.
    #[must_use]
    pub fn not_delivered(&self) -> u64 {
        let queue = lock(&self.shared.queue);
        queue.dropped + if queue.client.is_none() { queue.messages.len() as u64 } else { 0 }
    }

    /// Sends the queued messages and disconnects; returns the number of messages that the broker has not acknowledged.
    pub fn finish(self) -> u64 {
        self.push(STATUS, "offline", true);
        let mut queue = lock(&self.shared.queue);
        queue.is_finishing = true;
        self.shared.changed.notify_all();
        let waited = self.shared.changed.wait_timeout_while(queue, FLUSH_TIME, |queue| !queue.messages.is_empty());
        let (queue, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let remaining = queue.messages.iter().filter(|message| !message.is_retained).count() as u64;
        let not_delivered = queue.dropped + remaining;
        let client = queue.client.clone();
        drop(queue);
        if client.is_some_and(|client| client.try_disconnect().is_ok()) {
            let _ = self.thread.join();
        }
        not_delivered
    }
}

/// Connects until the monitor ends.
fn run(shared: &Shared, options: &MqttOptions, status: &str) {
    let (host, port) = options.broker_address();
    loop {
        let (client, mut connection) = Client::new(options.clone(), WINDOW + 2);
        for event in connection.iter() {
            let mut queue = lock(&shared.queue);
            match event {
                Ok(Event::Incoming(Packet::ConnAck(_))) => queue.begin(client.clone(), status.to_owned()),
                Ok(Event::Incoming(Packet::PubAck(_))) => queue.acknowledge(),
                Ok(Event::Outgoing(Outgoing::Disconnect)) => return,
                Ok(_) => continue,
                Err(error) => {
                    queue.disconnect(&format!("{host}:{port}"), &error);
                    break;
                }
            }
            drop(queue);
            shared.changed.notify_all();
        }
        let waited = shared
            .changed
            .wait_timeout_while(lock(&shared.queue), RETRY_INTERVAL, |queue| !queue.is_finishing)
            .unwrap_or_else(PoisonError::into_inner);
        if waited.0.is_finishing {
            return;
        }
    }
}
