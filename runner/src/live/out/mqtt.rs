//! Indicators and events to an MQTT broker. The client reconnects; messages in between are lost.

use anyhow::{Context, Result, bail};
use rumqttc::{Client, MqttOptions, QoS};
use std::time::Duration;

/// Messages that wait for the broker.
const WAITING: usize = 256;
/// Between two attempts to reach it.
const PAUSE: Duration = Duration::from_secs(2);
/// For what still waits at the end.
const FAREWELL: Duration = Duration::from_millis(300);

/// A connection to a broker, in a thread of its own.
pub struct Publisher {
    client: Client,
    topic: String,
}

impl Publisher {
    /// `mqtt://HOST:PORT/TOPIC`
    ///
    /// # Errors
    /// A URL that is none.
    pub fn connect(url: &str) -> Result<Self> {
        let allowed = || format!("--mqtt: found {url:?}, allowed: mqtt://HOST:PORT/TOPIC");
        let rest = url.strip_prefix("mqtt://").with_context(allowed)?;
        let (place, topic) = rest.split_once('/').with_context(allowed)?;
        let (host, port) = place.rsplit_once(':').with_context(allowed)?;
        let port: u16 = port.parse().with_context(allowed)?;
        if host.is_empty() || topic.is_empty() || topic.contains(['#', '+']) {
            bail!(allowed());
        }
        let name = format!("ballrace-{}", std::process::id());
        let (client, mut connection) = Client::new(MqttOptions::new(name, host, port), WAITING);
        std::thread::Builder::new().name("mqtt".to_owned()).spawn(move || {
            for event in connection.iter() {
                match event {
                    Ok(rumqttc::Event::Outgoing(rumqttc::Outgoing::Disconnect)) => break,
                    Ok(_) => {}
                    Err(_) => std::thread::sleep(PAUSE),
                }
            }
        })?;
        Ok(Self { client, topic: topic.to_owned() })
    }

    /// Publishes under `TOPIC/what`, at least once; with the broker away and the queue full the message is dropped.
    pub fn publish(&mut self, what: &str, message: &str) {
        let _ = self.client.try_publish(format!("{}/{what}", self.topic), QoS::AtLeastOnce, false, message);
    }

    /// Lets what still waits go out.
    pub fn finish(self) {
        std::thread::sleep(FAREWELL);
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
    fn a_broker_hears_topic_and_message() {
        let broker = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("mqtt://127.0.0.1:{}/plant/pump", broker.local_addr().unwrap().port());
        let mut publisher = Publisher::connect(&url).unwrap();
        publisher.publish("indicators", "{\"time_s\":1}");
        let (mut stream, _) = broker.accept().unwrap();
        let (mut heard, mut part) = (Vec::<u8>::new(), [0; 1024]);
        while !heard.windows(12).any(|w| w == b"{\"time_s\":1}") {
            let length = stream.read(&mut part).unwrap();
            assert!(length > 0, "gone before the message");
            if heard.is_empty() {
                // MQTT 3.1.1, CONNACK: accepted.
                stream.write_all(&[0x20, 2, 0, 0]).unwrap();
            }
            heard.extend(&part[..length]);
        }
        assert!(heard.windows(21).any(|w| w == b"plant/pump/indicators"));
    }

    #[test]
    fn what_is_no_address_is_refused() {
        for url in ["localhost:1883/t", "mqtt://localhost/t", "mqtt://localhost:1883", "mqtt://:1/t", "mqtt://h:1/a/#"]
        {
            assert!(Publisher::connect(url).is_err_and(|e| e.to_string().contains("allowed: mqtt://")), "{url}");
        }
    }
}
