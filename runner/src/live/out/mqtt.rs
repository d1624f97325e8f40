//! Indicators and events to an MQTT broker. A broker that is away is tried again; what was told meanwhile is lost to it.

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
