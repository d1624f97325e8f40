//! Outputs of a monitor; all are off by default.

#[cfg(feature = "mqtt")]
mod broker;
mod events;
mod health;
pub mod history;
mod indicators;
#[cfg(feature = "mqtt")]
mod mqtt;
#[cfg(feature = "opcua")]
mod opcua;
mod prometheus;
#[cfg(feature = "sparkplug")]
mod sparkplug;

pub use events::EventLog;

use super::feed::SourceCounters;
use super::state::{State, StateFile};
use anyhow::Result;
use ballrace_twin::record::{EventMessage, EventRecord, SecondRecord};
use ballrace_twin::replay::limits::LimitStatus;
use ballrace_twin::replay::outcome::OutputFigures;
use ballrace_twin::replay::second::Second;
use ballrace_twin::scene::units;
use health::OutputHealth;
use indicators::{HOUR, Indicators};
use prometheus::{Metrics, Prometheus};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::SystemTime;

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
    #[arg(long, value_name = "DURATION", requires = "indicators", value_parser = parse_file_length)]
    pub indicators_file_length: Option<usize>,
    /// Serve Prometheus metrics on this port of 127.0.0.1.
    #[arg(long, value_name = "PORT")]
    pub prometheus: Option<u16>,
    /// Serve indicators and events by OPC UA at this address and port, e.g. 127.0.0.1:4840; read-only, without encryption and password.
    #[cfg(feature = "opcua")]
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub opcua: Option<std::net::SocketAddr>,
    /// Connection to an MQTT broker.
    #[cfg(feature = "mqtt")]
    #[command(flatten)]
    pub broker: broker::BrokerArgs,
}

/// Maximum length of an indicator file, s: one day.
const MAX_FILE_LENGTH: f64 = 86_400.0;

/// Parses the length of an indicator file; returns whole seconds.
fn parse_file_length(text: &str) -> Result<usize, String> {
    let seconds = units::parse(text, units::Dimension::Time).ok().filter(|s| (1.0..=MAX_FILE_LENGTH).contains(s));
    seconds
        .map(|seconds| seconds.round() as usize)
        .ok_or_else(|| "expected a time from \"1 s\" to \"24 h\" with its unit".to_owned())
}

/// Kinds of events with a counter from the start, so that the first one is an increase from 0 in a monitoring system.
const COUNTED_FROM_START: [&str; 4] = ["fault-found", "limit-crossed", "output-failing", "source-silent"];

/// Network outputs, bound before any file is changed.
pub struct Network {
    prometheus: Option<Prometheus>,
    #[cfg(feature = "mqtt")]
    mqtt: Option<mqtt::Publisher>,
    #[cfg(feature = "sparkplug")]
    sparkplug: Option<sparkplug::EdgeNode>,
    #[cfg(feature = "opcua")]
    opcua: Option<opcua::Server>,
}

impl Network {
    /// Binds the requested ports. The metrics answer requests to the names `hosts` too.
    ///
    /// # Errors
    /// Returns an error if a port is in use or an address is invalid.
    pub fn bind(requested: &RequestedOutputs, hosts: &[String]) -> Result<Self> {
        #[cfg(feature = "mqtt")]
        let access = &requested.broker.access;
        Ok(Self {
            prometheus: requested.prometheus.map(|port| Prometheus::listen(port, hosts)).transpose()?,
            #[cfg(feature = "mqtt")]
            mqtt: requested.broker.mqtt.as_deref().map(|url| mqtt::Publisher::connect(url, access)).transpose()?,
            #[cfg(feature = "opcua")]
            opcua: requested.opcua.map(opcua::Server::listen).transpose()?,
            #[cfg(feature = "sparkplug")]
            sparkplug: {
                let url = requested.broker.sparkplug.as_deref();
                url.map(|url| sparkplug::EdgeNode::start(url, access)).transpose()?
            },
        })
    }
}

impl Network {
    /// Returns the number of messages that are lost or wait.
    fn not_delivered(&self) -> u64 {
        let counts: &[u64] = &[
            #[cfg(feature = "mqtt")]
            self.mqtt.as_ref().map_or(0, mqtt::Publisher::not_delivered),
            #[cfg(feature = "sparkplug")]
            self.sparkplug.as_ref().map_or(0, sparkplug::EdgeNode::not_delivered),
        ];
        counts.iter().sum()
    }

    /// Ends the connections to brokers; returns the number of messages that were not delivered.
    fn finish(&mut self) -> u64 {
        let counts: &[u64] = &[
            #[cfg(feature = "mqtt")]
            self.mqtt.take().map_or(0, mqtt::Publisher::finish),
            #[cfg(feature = "sparkplug")]
            self.sparkplug.take().map_or(0, sparkplug::EdgeNode::finish),
        ];
        counts.iter().sum()
    }
}

/// Open outputs.
///
/// An output that cannot be written does not stop the monitor: its data are kept in memory up to a limit, and are written
/// later or counted as lost.
pub struct Outputs {
    events: Option<EventLog>,
    events_health: OutputHealth,
    indicators: Option<Indicators>,
    indicators_health: OutputHealth,
    state_health: OutputHealth,
    network: Network,
    /// Events about the outputs themselves.
    output_events: Vec<EventMessage>,
    /// Number of events of each kind.
    event_counts: BTreeMap<&'static str, u64>,
}

impl Outputs {
    /// Opens the requested files. `state` is the state of the monitor before this start.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written or is locked by another monitor.
    pub fn open(requested: &RequestedOutputs, network: Network, state: Option<&State>) -> Result<Self> {
        let unconfirmed = state.map_or(&[][..], |state| &state.events);
        let owner = state.map_or("", |state| &state.id);
        let length = requested.indicators_file_length.unwrap_or(HOUR);
        let open = |folder: &PathBuf| Indicators::open(folder, owner, length);
        Ok(Self {
            events: requested.events.as_deref().map(|path| EventLog::open(path, unconfirmed)).transpose()?,
            events_health: OutputHealth::default(),
            indicators: requested.indicators.as_ref().map(open).transpose()?,
            indicators_health: OutputHealth::default(),
            state_health: OutputHealth::default(),
            network,
            output_events: vec![],
            event_counts: COUNTED_FROM_START.map(|kind| (kind, 0)).into(),
        })
    }

    /// Removes and returns the sentence about an indicator journal that was damaged.
    pub fn take_damage(&mut self) -> Option<String> {
        self.indicators.as_mut().and_then(Indicators::take_damage)
    }

    /// Adds an event, which [`Outputs::save_events`] writes.
    ///
    /// # Errors
    /// Returns an error if the event cannot be serialised.
    pub fn add_event(&mut self, event: &EventRecord) -> Result<()> {
        *self.event_counts.entry(event.kind).or_default() += 1;
        if let Some(log) = &mut self.events {
            log.add(event)?;
        }
        #[cfg(feature = "mqtt")]
        if let Some(publisher) = &self.network.mqtt {
            publisher.publish("events", &serde_json::to_string(event)?);
        }
        #[cfg(feature = "sparkplug")]
        if let Some(node) = &self.network.sparkplug {
            node.publish_event(serde_json::to_string(event)?);
        }
        #[cfg(feature = "opcua")]
        if let Some(server) = &self.network.opcua {
            server.publish_event(serde_json::to_string(event)?);
        }
        Ok(())
    }

    /// Adds the indicators of a second, which [`Outputs::save_indicators`] writes. `next_index` is the number of the first
    /// sample after the second.
    ///
    /// # Errors
    /// Returns an error if the second cannot be serialised.
    pub fn add_second(&mut self, second: &Second, next_index: u64) -> Result<()> {
        let record = SecondRecord { at: SystemTime::now(), second };
        if let Some(indicators) = &mut self.indicators {
            indicators.add(&record, next_index);
        }
        #[cfg(feature = "mqtt")]
        if let Some(publisher) = &self.network.mqtt {
            publisher.publish("indicators", &serde_json::to_string(&record)?);
        }
        #[cfg(feature = "sparkplug")]
        if let Some(node) = &self.network.sparkplug {
            node.publish_second(&record);
        }
        #[cfg(feature = "opcua")]
        if let Some(server) = &mut self.network.opcua {
            server.publish_second(&record);
        }
        Ok(())
    }

    /// Updates the Prometheus metrics.
    pub fn publish(&self, second: &Second, limits: &[LimitStatus], counters: &SourceCounters, misses: u64) {
        if let Some(prometheus) = &self.network.prometheus {
            let outputs = self.figures();
            prometheus.update(&Metrics { second, limits, counters, misses, outputs, event_counts: &self.event_counts });
        }
    }

    /// Writes the pending seconds; returns `true` if all of them are on disk.
    pub fn save_indicators(&mut self) -> bool {
        let Some(indicators) = &mut self.indicators else { return true };
        self.indicators_health.attempt(&mut self.output_events, || indicators.save())
    }

    /// Writes the state with the pending events; returns `true` if it is on disk or the monitor has no state.
    pub fn save_state(&mut self, file: Option<&mut StateFile>) -> bool {
        let saved = file.is_none_or(|file| {
            file.state.events = self.events.as_ref().map(EventLog::unconfirmed).unwrap_or_default();
            self.state_health.attempt(&mut self.output_events, || file.save())
        });
        // The events are released even if the state cannot be written: after a restart, a repeated event is preferable to a
        // missing one.
        if let Some(log) = &mut self.events {
            log.release();
        }
        saved
    }

    /// Appends the released events; returns `true` if they are on disk.
    pub fn save_events(&mut self) -> bool {
        let Some(log) = &mut self.events else { return true };
        self.events_health.attempt(&mut self.output_events, || log.append())
    }

    /// Reopens the event log if its path names another file or none.
    pub fn reopen(&mut self) {
        if let Some(log) = &mut self.events {
            self.events_health.attempt(&mut self.output_events, || log.reopen());
        }
    }

    /// Returns `true` if the next attempt of a failing output is due.
    #[must_use]
    pub fn is_retry_due(&self) -> bool {
        [&self.events_health, &self.indicators_health, &self.state_health].into_iter().any(OutputHealth::is_retry_due)
    }

    /// Makes the next attempt of every failing output due immediately.
    pub fn retry_now(&mut self) {
        for health in [&mut self.events_health, &mut self.indicators_health, &mut self.state_health] {
            health.retry_now();
        }
    }

    /// Removes and returns the events about the outputs themselves.
    pub fn take_events(&mut self) -> Vec<EventMessage> {
        #[cfg(feature = "mqtt")]
        self.output_events.extend(self.network.mqtt.iter().flat_map(mqtt::Publisher::take_events));
        #[cfg(feature = "sparkplug")]
        self.output_events.extend(self.network.sparkplug.iter().flat_map(sparkplug::EdgeNode::take_events));
        std::mem::take(&mut self.output_events)
    }

    /// Returns the numbers of events and seconds that are not on disk.
    fn figures(&self) -> OutputFigures {
        let [events_lost, events_pending] = self.events.as_ref().map_or([0; 2], EventLog::lost_and_pending);
        let [seconds_lost, seconds_pending] = self.indicators.as_ref().map_or([0; 2], |i| [i.lost(), i.pending()]);
        let overdue = |health: &OutputHealth, pending: u64| if health.is_failing() { pending } else { 0 };
        OutputFigures {
            events_not_written: events_lost + overdue(&self.events_health, events_pending),
            seconds_not_written: seconds_lost + overdue(&self.indicators_health, seconds_pending),
            messages_not_delivered: self.network.not_delivered(),
        }
    }

    /// Closes the outputs; returns the numbers of records that were not written or delivered.
    pub fn finish(mut self) -> OutputFigures {
        if let Some(indicators) = &mut self.indicators {
            self.indicators_health.attempt(&mut self.output_events, || indicators.finish());
        }
        let messages_not_delivered = self.network.finish();
        OutputFigures { messages_not_delivered, ..self.figures() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_lengths_are_times() {
        assert_eq!((parse_file_length("10 min"), parse_file_length("24 h")), (Ok(600), Ok(86_400)));
        for text in ["0 s", "25 h", "3 mm", "hour"] {
            assert!(parse_file_length(text).is_err_and(|e| e.contains("24 h")), "{text}");
        }
    }
}
