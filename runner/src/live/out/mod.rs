//! What a monitor tells others: each way off unless asked for.

mod events;
mod indicators;
#[cfg(feature = "mqtt")]
mod mqtt;
mod prometheus;

pub use events::{EventLog, Told};

use super::feed::Counts;
use ballrace_twin::replay::second::Second;
use anyhow::Result;
use indicators::Indicators;
use prometheus::Prometheus;
use std::path::PathBuf;

/// Which of them were asked for.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Asked {
    /// Append events as JSON lines.
    #[arg(long, value_name = "FILE.jsonl")]
    pub events: Option<PathBuf>,
    /// Write every second's indicators, a Parquet file an hour: FOLDER/indicators-0001.parquet and so on.
    #[arg(long, value_name = "FOLDER")]
    pub indicators: Option<PathBuf>,
    /// Answer Prometheus at this port of 127.0.0.1.
    #[arg(long, value_name = "PORT")]
    pub prometheus: Option<u16>,
    /// Publish indicators and events to an MQTT broker: mqtt://HOST:PORT/TOPIC.
    #[cfg(feature = "mqtt")]
    #[arg(long, value_name = "URL")]
    pub mqtt: Option<String>,
}

/// Those under way.
pub struct Outputs {
    events: Option<EventLog>,
    indicators: Option<Indicators>,
    prometheus: Option<Prometheus>,
    #[cfg(feature = "mqtt")]
    mqtt: Option<mqtt::Publisher>,
}

impl Outputs {
    /// Opens what was asked for. `done`, s, is how far a monitor had come that goes on.
    ///
    /// # Errors
    /// A file that cannot be written, a port that is taken.
    pub fn open(asked: &Asked, done: Option<f64>) -> Result<Self> {
        Ok(Self {
            events: asked.events.as_deref().map(|path| EventLog::open(path, done)).transpose()?,
            indicators: asked.indicators.as_deref().map(|folder| Indicators::open(folder, done)).transpose()?,
            prometheus: asked.prometheus.map(Prometheus::listen).transpose()?,
            #[cfg(feature = "mqtt")]
            mqtt: asked.mqtt.as_deref().map(mqtt::Publisher::connect).transpose()?,
        })
    }

    /// Something happened.
    ///
    /// # Errors
    /// A full disk.
    pub fn event(&mut self, told: &Told) -> Result<()> {
        if let Some(log) = &mut self.events {
            log.add(told)?;
        }
        #[cfg(feature = "mqtt")]
        if let Some(publisher) = &mut self.mqtt {
            publisher.publish("events", &serde_json::to_string(told)?);
        }
        Ok(())
    }

    /// A second has ended.
    ///
    /// # Errors
    /// A full disk.
    pub fn second(&mut self, second: &Second) -> Result<()> {
        if let Some(indicators) = &mut self.indicators {
            indicators.add(second)?;
        }
        #[cfg(feature = "mqtt")]
        if let Some(publisher) = &mut self.mqtt {
            publisher.publish("indicators", &serde_json::to_string(second)?);
        }
        Ok(())
    }

    /// Shows a second where it is asked for; the last one counts.
    pub fn show(&self, second: &Second, counts: &Counts, misses: u64) {
        if let Some(prometheus) = &self.prometheus {
            prometheus.show(second, counts, misses);
        }
    }

    /// Events and indicators so far are on disk when this returns.
    ///
    /// # Errors
    /// A full disk.
    pub fn sync(&mut self) -> Result<()> {
        if let Some(log) = &mut self.events {
            log.sync()?;
        }
        if let Some(indicators) = &mut self.indicators {
            indicators.sync()?;
        }
        Ok(())
    }

    /// Ends all of them.
    ///
    /// # Errors
    /// A full disk.
    pub fn finish(mut self) -> Result<()> {
        self.sync()?;
        if let Some(indicators) = self.indicators {
            indicators.finish()?;
        }
        #[cfg(feature = "mqtt")]
        if let Some(publisher) = self.mqtt {
            publisher.finish();
        }
        Ok(())
    }
}
