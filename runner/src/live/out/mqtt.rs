//! Publisher of indicators and events to an MQTT broker. The client reconnects; messages sent meanwhile may be lost.

use anyhow::{Context, Result, bail};
use rumqttc::{Client, MqttOptions, QoS};
use std::time::Duration;

/// Capacity of the message queue.
const QUEUE_CAPACITY: usize = 256;
/// Interval between two connection attempts.
const RETRY_INTERVAL: Duration = Duration::from_secs(2);
/// Time for sending queued messages at the end.
const FLUSH_TIME: Duration = Duration::from_millis(300);

/// Connection to a broker, on a thread of its own.
pub struct Publisher {
    client: Client,
    topic: String,
}

impl Publisher {
    /// Connects to the broker at `url`, of the form `mqtt://HOST:PORT/TOPIC`.
    ///
    /// # Errors
    /// Returns an error if the URL is invalid. A broker that cannot be reached is not an error.
    pub fn connect(url: &str) -> Result<Self> {
        let invalid = || format!("--mqtt: invalid URL: {url:?}, expected mqtt://HOST:PORT/TOPIC");
        let rest = url.strip_prefix("mqtt://").with_context(invalid)?;
        let (address, topic) = rest.split_once('/').with_context(invalid)?;
        let (host, port) = address.rsplit_once(':').with_context(invalid)?;
        let port: u16 = port.parse().with_context(invalid)?;
        if host.is_empty() || topic.is_empty() || topic.contains(['#', '+']) {
            bail!(invalid());
        }
        let name = format!("ballrace-{}", std::process::id());
        let (client, mut connection) = Client::new(MqttOptions::new(name, host, port), QUEUE_CAPACITY);
        std::thread::Builder::new().name("mqtt".to_owned()).spawn(move || {
            for event in connection.iter() {
                match event {
                    Ok(rumqttc::Event::Outgoing(rumqttc::Outgoing::Disconnect)) => break,
                    Ok(_) => {}
                    Err(_) => std::thread::sleep(RETRY_INTERVAL),
                }
            }
        })?;
        Ok(Self { client, topic: topic.to_owned() })
    }

    /// Publishes a message under `TOPIC/subtopic` with quality of service 1; drops it if the queue is full.
    pub fn publish(&mut self, subtopic: &str, message: &str) {
        let _ = self.client.try_publish(format!("{}/{subtopic}", self.topic), QoS::AtLeastOnce, false, message);
    }

    /// Sends the queued messages and disconnects.
    pub fn finish(self) {
        std::thread::sleep(FLUSH_TIME);
        let _ = self.client.try_disconnect();
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use std::io::{Read, Write};
    use std::net::TcpListener;

    #[test]
    fn a_broker_receives_topic_and_message() {
        let broker = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("mqtt://127.0.0.1:{}/plant/pump", broker.local_addr().unwrap().port());
        let mut publisher = Publisher::connect(&url).unwrap();
        publisher.publish("indicators", "{\"time_s\":1}");
        let (mut stream, _) = broker.accept().unwrap();
        let (mut received, mut buffer) = (Vec::<u8>::new(), [0; 1024]);
        while !received.windows(12).any(|w| w == b"{\"time_s\":1}") {
            let length = stream.read(&mut buffer).unwrap();
            assert!(length > 0, "closed before the message");
            if received.is_empty() {
                // MQTT 3.1.1, CONNACK: accepted.
                stream.write_all(&[0x20, 2, 0, 0]).unwrap();
            }
            received.extend(&buffer[..length]);
        }
        assert!(received.windows(21).any(|w| w == b"plant/pump/indicators"));
    }

    #[test]
    fn an_invalid_url_is_rejected() {
        for url in ["localhost:1883/t", "mqtt://localhost/t", "mqtt://localhost:1883", "mqtt://:1/t", "mqtt://h:1/a/#"]
        {
            assert!(Publisher::connect(url).is_err_and(|e| e.to_string().contains("expected mqtt://")), "{url}");
        }
    }
}
