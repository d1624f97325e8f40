//! Outputs of a monitor; each is off by default.

mod events;
mod health;
mod indicators;
#[cfg(feature = "mqtt")]
mod mqtt;
mod prometheus;

pub use events::{EventLog, EventRecord};

use super::feed::{Counts, Note};
use super::state::{State, StateFile};
use anyhow::Result;
use ballrace_twin::replay::outcome::OutputFigures;
use ballrace_twin::replay::second::Second;
use ballrace_twin::scene::units;
use health::Health;
use indicators::{HOUR, Indicators};
use prometheus::Prometheus;
use std::path::PathBuf;

/// Requested outputs.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct RequestedOutputs {
    /// Append events as JSON lines.
    #[arg(long, value_name = "FILE.jsonl")]
    pub events: Option<PathBuf>,
    /// Write indicators once per second to Parquet files of one hour: FOLDER/indicators-0001.parquet and so on.
    #[arg(long, value_name = "FOLDER")]
    pub indicators: Option<PathBuf>,
    /// Length of each indicator file, e.g. "10 min" [default: one hour].
    #[arg(long, value_name = "DURATION", requires = "indicators", value_parser = whole_seconds)]
    pub indicators_file_length: Option<usize>,
    /// Serve Prometheus metrics on this port of 127.0.0.1.
    #[arg(long, value_name = "PORT")]
    pub prometheus: Option<u16>,
    /// Publish indicators and events to an MQTT broker: mqtt://HOST:PORT/TOPIC.
    #[cfg(feature = "mqtt")]
    #[arg(long, value_name = "URL")]
    pub mqtt: Option<String>,
}

/// Most seconds of one indicators file: a day.
const LONGEST_FILE: f64 = 86_400.0;

fn whole_seconds(text: &str) -> Result<usize, String> {
    let seconds = units::parse(text, units::Dimension::Time).ok().filter(|s| (1.0..=LONGEST_FILE).contains(s));
    seconds
        .map(|seconds| seconds.round() as usize)
        .ok_or_else(|| format!("found {text:?}, allowed: a time from \"1 s\" to \"24 h\" with its unit"))
}

/// Network ends of the outputs, bound before any file is touched.
pub struct Network {
    prometheus: Option<Prometheus>,
    #[cfg(feature = "mqtt")]
    mqtt: Option<mqtt::Publisher>,
}

impl Network {
    /// Binds the requested ports.
    ///
    /// # Errors
    /// A port that is taken, an address that is none.
    pub fn bind(asked: &RequestedOutputs) -> Result<Self> {
        Ok(Self {
            prometheus: asked.prometheus.map(Prometheus::listen).transpose()?,
            #[cfg(feature = "mqtt")]
            mqtt: asked.mqtt.as_deref().map(mqtt::Publisher::connect).transpose()?,
        })
    }
}

/// Those under way. An output that cannot be written does not stop the monitor: what it lacks waits in memory up to a
/// bound, and is written later or counted as lost.
pub struct Outputs {
    events: Option<EventLog>,
    events_health: Health,
    indicators: Option<Indicators>,
    indicators_health: Health,
    state_health: Health,
    network: Network,
    /// Events about the outputs themselves.
    notes: Vec<Note>,
}

impl Outputs {
    /// Opens the requested files. `state` is the monitor's state before the start.
    ///
    /// # Errors
    /// A file that cannot be written or belongs to another monitor.
    pub fn open(asked: &RequestedOutputs, network: Network, state: Option<&State>) -> Result<Self> {
        let unconfirmed = state.map_or(&[][..], |state| &state.events);
        let owner = state.map_or("", |state| &state.id);
        let length = asked.indicators_file_length.unwrap_or(HOUR);
        let open = |folder: &PathBuf| Indicators::open(folder, owner, length);
        Ok(Self {
            events: asked.events.as_deref().map(|path| EventLog::open(path, unconfirmed)).transpose()?,
            events_health: Health::default(),
            indicators: asked.indicators.as_ref().map(open).transpose()?,
            indicators_health: Health::default(),
            state_health: Health::default(),
            network,
            notes: vec![],
        })
    }

    /// Takes in an event, to be written by [`Outputs::save_events`].
    ///
    /// # Errors
    /// None in practice.
    pub fn event(&mut self, told: &EventRecord) -> Result<()> {
        if let Some(log) = &mut self.events {
            log.add(told)?;
        }
        #[cfg(feature = "mqtt")]
        if let Some(publisher) = &mut self.network.mqtt {
            publisher.publish("events", &serde_json::to_string(told)?);
        }
        Ok(())
    }

    /// Takes in a second, to be written by [`Outputs::save_indicators`]; `next_index` is the number of the first sample
    /// after it.
    ///
    /// # Errors
    /// None in practice.
    pub fn second(&mut self, second: &Second, next_index: u64) -> Result<()> {
        if let Some(indicators) = &mut self.indicators {
            indicators.add(second, next_index);
        }
        #[cfg(feature = "mqtt")]
        if let Some(publisher) = &mut self.network.mqtt {
            publisher.publish("indicators", &serde_json::to_string(second)?);
        }
        Ok(())
    }

    /// Publishes the indicators of a second; the last one is served.
    pub fn show(&self, second: &Second, counts: &Counts, misses: u64) {
        if let Some(prometheus) = &self.network.prometheus {
            prometheus.show(second, counts, misses, &self.figures());
        }
    }

    /// Writes the seconds that wait; true where all of them are on disk.
    pub fn save_indicators(&mut self) -> bool {
        let Some(indicators) = &mut self.indicators else { return true };
        self.indicators_health.attempt(&mut self.notes, || indicators.save())
    }

    /// Writes the state, with the events that wait; true where it is on disk. Without a state nothing is to be done.
    pub fn save_state(&mut self, file: Option<&mut StateFile>) -> bool {
        let saved = file.is_none_or(|file| {
            file.state.events = self.events.as_ref().map(EventLog::unconfirmed).unwrap_or_default();
            self.state_health.attempt(&mut self.notes, || file.save())
        });
        // Where the state cannot be written, an event twice after a restart is better than none.
        if let Some(log) = &mut self.events {
            log.release();
        }
        saved
    }

    /// Appends the events that the state has; true where they are on disk.
    pub fn save_events(&mut self) -> bool {
        let Some(log) = &mut self.events else { return true };
        self.events_health.attempt(&mut self.notes, || log.append())
    }

    /// True where an output that failed is to be written again.
    #[must_use]
    pub fn is_retry_due(&self) -> bool {
        [&self.events_health, &self.indicators_health, &self.state_health].into_iter().any(Health::is_retry_due)
    }

    /// Makes the next attempt of every output that fails due now.
    pub fn retry_now(&mut self) {
        for health in [&mut self.events_health, &mut self.indicators_health, &mut self.state_health] {
            health.retry_now();
        }
    }

    /// Events about the outputs themselves, since the last call.
    pub fn take_notes(&mut self) -> Vec<Note> {
        std::mem::take(&mut self.notes)
    }

    /// Counts of events and seconds that are not on disk.
    fn figures(&self) -> OutputFigures {
        let [events_lost, events_waiting] = self.events.as_ref().map_or([0; 2], EventLog::lost_and_waiting);
        let [seconds_lost, seconds_waiting] = self.indicators.as_ref().map_or([0; 2], |i| [i.lost(), i.waiting()]);
        let is_lacking = |health: &Health, waiting: u64| if health.is_failing() { waiting } else { 0 };
        OutputFigures {
            events_not_written: events_lost + is_lacking(&self.events_health, events_waiting),
            seconds_not_written: seconds_lost + is_lacking(&self.indicators_health, seconds_waiting),
        }
    }

    /// Ends all of them; gives what could not be written.
    pub fn finish(mut self) -> OutputFigures {
        if let Some(indicators) = &mut self.indicators {
            self.indicators_health.attempt(&mut self.notes, || indicators.finish());
        }
        #[cfg(feature = "mqtt")]
        if let Some(publisher) = self.network.mqtt.take() {
            publisher.finish();
        }
        self.figures()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_files_are_times() {
        assert_eq!((whole_seconds("10 min"), whole_seconds("24 h")), (Ok(600), Ok(86_400)));
        for text in ["0 s", "25 h", "3 mm", "hour"] {
            assert!(whole_seconds(text).is_err_and(|e| e.contains("24 h")), "{text}");
        }
    }
}
