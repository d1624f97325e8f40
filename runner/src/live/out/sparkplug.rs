//! Edge node of Sparkplug B on a thread of its own: the monitor is the node, its machine the device.
//!
//! The library keeps the state of node and device: NBIRTH, the last will NDEATH with its `bdSeq`, sequence numbers, rebirth on request.
//! DBIRTH has every indicator, DDATA those of one second or one event. Sparkplug stores no message for a broker that does not answer: those
//! seconds are lost; events wait.

use super::super::feed::lock;
use super::broker::{Access, Url};
use crate::error::UsageError;
use anyhow::{Result, bail};
use async_trait::async_trait;
use ballrace_twin::record::{ColumnName, EventMessage, SecondRecord};
use rumqttc::{AsyncClient, Event, MqttOptions, Outgoing, Packet, QoS};
use srad_client::{LastWill, StatePayload, topic_and_payload_to_event};
use srad_eon::{
    BirthInitializer, BirthMetricDetails, DeviceHandle, DeviceMetricManager, EoNBuilder, MetricManager,
    MetricPublisher, MetricToken, NodeMetricManager, PublishMetric,
};
use srad_types::PropertySet;
use srad_types::payload::{DataType, Message as _, Payload};
use srad_types::topic::{DeviceTopic, NodeMessage, NodeTopic, StateTopic, TopicFilter};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

/// Messages that the client of the library buffers.
const BUFFER: usize = 64;
/// Interval between two connection attempts.
const RETRY_INTERVAL: Duration = Duration::from_secs(1);
/// Time for the death certificate at the end.
const FLUSH_TIME: Duration = Duration::from_secs(2);
/// Maximum number of events that wait for a connection.
const MAX_EVENTS: usize = 1000;
/// Metric of the events, JSON as in the event log.
const EVENT: &str = "event";
/// Property with the unit of a metric.
const UNIT: &str = "engUnit";

/// What passes from the monitor to the thread.
enum Message {
    Second { columns: Vec<ColumnName>, values: Vec<f64>, at: u64 },
    Event(String),
}

/// State of the connection, for the monitor.
#[derive(Default)]
struct Connection {
    events: Mutex<Vec<EventMessage>>,
    /// Seconds that were not published, and events that wait.
    not_delivered: AtomicU64,
}

/// Edge node on a thread of its own.
pub struct EdgeNode {
    sender: UnboundedSender<Message>,
    connection: Arc<Connection>,
    thread: JoinHandle<()>,
}

impl EdgeNode {
    /// Starts the node of the URL of `--sparkplug`.
    ///
    /// # Errors
    /// Returns an error if the URL is invalid or a file cannot be read. A broker that cannot be reached is not an error.
    pub fn start(url: &str, access: &Access) -> Result<Self> {
        const OPTION: &str = "--sparkplug";
        const PATH: &str = "GROUP/NODE/DEVICE";
        let parsed = Url::parse(OPTION, PATH, url)?;
        let names: Vec<String> = parsed.topic.split('/').map(str::to_owned).collect();
        let Ok([group, node, device]) = <[String; 3]>::try_from(names) else {
            bail!(UsageError(format!("{OPTION}: invalid URL: {url:?}, expected mqtt://HOST:PORT/{PATH}")))
        };
        if [&group, &node, &device].into_iter().any(String::is_empty) {
            bail!(UsageError(format!("{OPTION}: empty name: {url:?}, expected mqtt://HOST:PORT/{PATH}")));
        }
        let options = access.options(&parsed)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (sender, receiver) = unbounded_channel();
        let connection = Arc::<Connection>::default();
        let of_thread = connection.clone();
        let run = move || {
            let work = run(options, [group, node, device], receiver, &of_thread);
            if let Err(error) = runtime.block_on(work) {
                of_thread.report("output-failing", format!("Sparkplug: {error}; the monitor continues without it."));
            }
        };
        let thread = std::thread::Builder::new().name("sparkplug".to_owned()).spawn(run)?;
        Ok(Self { sender, connection, thread })
    }

    fn send(&self, message: Message) {
        if self.sender.send(message).is_err() {
            self.connection.not_delivered.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Publishes the indicators of a second.
    pub fn publish_second(&self, record: &SecondRecord) {
        let (columns, values) = record.columns();
        self.send(Message::Second { columns, values, at: milliseconds(record.at) });
    }

    /// Publishes an event, JSON.
    pub fn publish_event(&self, event: String) {
        self.send(Message::Event(event));
    }

    /// Removes and returns the events about the connection.
    pub fn take_events(&self) -> Vec<EventMessage> {
        std::mem::take(&mut lock(&self.connection.events))
    }

    /// Returns the number of seconds that are lost and of events that wait.
    #[must_use]
    pub fn not_delivered(&self) -> u64 {
        self.connection.not_delivered.load(Ordering::Relaxed)
    }

    /// Publishes the death certificate and disconnects; returns [`EdgeNode::not_delivered`].
    pub fn finish(self) -> u64 {
        let Self { sender, connection, thread } = self;
        drop(sender);
        let _ = thread.join();
        connection.not_delivered.load(Ordering::Relaxed)
    }
}

impl Connection {
    fn report(&self, kind: &'static str, sentence: String) {
        lock(&self.events).push(EventMessage { kind, sentence });
    }
}

fn milliseconds(at: SystemTime) -> u64 {
    at.duration_since(UNIX_EPOCH).unwrap_or_default().as_millis() as u64
}

/// Runs the node until the monitor ends.
///
/// # Errors
/// Names that the library refuses.
async fn run(
    options: MqttOptions,
    [group, node, device]: [String; 3],
    mut receiver: UnboundedReceiver<Message>,
    connection: &Arc<Connection>,
) -> Result<(), String> {
    let (host, port) = options.broker_address();
    let (client, inner) = AsyncClient::new(options, BUFFER);
    let event_loop = EventLoop {
        inner,
        broker: format!("{host}:{port}"),
        is_online: false,
        lost: None,
        connection: connection.clone(),
    };
    let builder = EoNBuilder::new(event_loop, Client(client)).with_group_id(group).with_node_id(node);
    let (running, node) = builder.with_metric_manager(Version).build()?;
    let running = tokio::spawn(running.run());
    let machine = Machine::default();
    let device = node.register_device(device, machine.clone()).map_err(|e| e.to_string())?;
    let mut publisher = DevicePublisher { device, machine, events: VecDeque::new(), lost: 0 };
    while let Some(message) = receiver.recv().await {
        publisher.take(message).await;
        connection.not_delivered.store(publisher.lost + publisher.events.len() as u64, Ordering::Relaxed);
    }
    node.cancel().await;
    let _ = tokio::time::timeout(FLUSH_TIME, running).await;
    Ok(())
}

/// Metrics of the node.
struct Version;

impl MetricManager for Version {
    fn initialise_birth(&self, birth: &mut BirthInitializer) {
        let version = BirthMetricDetails::new_with_initial_value("version", env!("CARGO_PKG_VERSION").to_owned());
        let _ = birth.register_metric(version);
    }
}

impl NodeMetricManager for Version {}

/// Metrics of the device: the latest second.
#[derive(Default)]
struct Latest {
    columns: Vec<ColumnName>,
    values: Vec<f64>,
    /// Metric of each column, once the device is born.
    metrics: Vec<Option<MetricToken<f64>>>,
    event: Option<MetricToken<String>>,
}

#[derive(Clone, Default)]
struct Machine(Arc<Mutex<Latest>>);

impl MetricManager for Machine {
    fn initialise_birth(&self, birth: &mut BirthInitializer) {
        let mut latest = lock(&self.0);
        let Latest { columns, values, metrics, event } = &mut *latest;
        let mut metric = |column: &ColumnName, value: f64| {
            let name = column.name.as_str();
            let details = if value.is_finite() {
                BirthMetricDetails::new_with_initial_value(name, value)
            } else {
                BirthMetricDetails::new_without_initial_value(name, DataType::Double).ok()?
            };
            let details = match &column.unit {
                Some(unit) => {
                    let mut properties = PropertySet::new();
                    properties.insert(UNIT, Some(unit.clone())).ok()?;
                    details.with_properties(properties)
                }
                None => details,
            };
            birth.register_metric(details).ok()
        };
        *metrics = columns.iter().zip(&*values).map(|(column, value)| metric(column, *value)).collect();
        let details = BirthMetricDetails::<String>::new_without_initial_value(EVENT, DataType::String);
        *event = details.ok().and_then(|details| birth.register_metric(details).ok());
    }
}

impl DeviceMetricManager for Machine {}

/// Publisher of the device's data.
struct DevicePublisher {
    device: DeviceHandle,
    machine: Machine,
    /// Events that wait for a connection.
    events: VecDeque<String>,
    /// Seconds and events that are lost.
    lost: u64,
}

impl DevicePublisher {
    async fn take(&mut self, message: Message) {
        match message {
            Message::Event(event) => {
                if self.events.len() >= MAX_EVENTS {
                    self.events.pop_front();
                    self.lost += 1;
                }
                self.events.push_back(event);
            }
            Message::Second { columns, values, at } => self.second(columns, values, at).await,
        }
        while let Some(event) = self.events.front() {
            let metric =
                lock(&self.machine.0).event.as_ref().map(|token| token.create_publish_metric(Some(event.clone())));
            let Some(metric) = metric else { break };
            if self.device.try_publish_metric(metric).await.is_err() {
                break;
            }
            self.events.pop_front();
        }
    }

    /// Publishes the values that are numbers; the first second, and one with other columns, is a birth.
    async fn second(&mut self, columns: Vec<ColumnName>, values: Vec<f64>, at: u64) {
        let metrics: Vec<PublishMetric> = {
            let mut latest = lock(&self.machine.0);
            let is_first = latest.columns.is_empty();
            let is_new = latest.columns != columns;
            latest.values.clone_from(&values);
            if is_new {
                latest.columns = columns;
                if is_first {
                    self.device.enable()
                } else {
                    self.device.rebirth()
                }
                return;
            }
            let metric = |(token, value): (&Option<MetricToken<f64>>, f64)| {
                let value = Some(value).filter(|value| value.is_finite());
                Some(token.as_ref()?.create_publish_metric(value).timestamp(at))
            };
            latest.metrics.iter().zip(values).filter_map(metric).collect()
        };
        if self.device.try_publish_metrics_unsorted(metrics).await.is_err() {
            self.lost += 1;
        }
    }
}

/// Client of the library on rumqttc.
struct Client(AsyncClient);

const fn quality(qos: &srad_types::topic::QoS) -> QoS {
    match qos {
        srad_types::topic::QoS::AtMostOnce => QoS::AtMostOnce,
        srad_types::topic::QoS::AtLeastOnce => QoS::AtLeastOnce,
    }
}

/// Adds the type of `bdSeq`, which the library omits in a death and some hosts need.
fn with_type(mut payload: Payload) -> Payload {
    for metric in payload.metrics.iter_mut().filter(|metric| metric.datatype.is_none()) {
        metric.set_datatype(DataType::Int64);
    }
    payload
}

/// Marks the metrics without a value as null, which the library omits in data messages.
fn with_nulls(mut payload: Payload) -> Payload {
    for metric in payload.metrics.iter_mut().filter(|metric| metric.value.is_none()) {
        metric.set_null();
    }
    payload
}

impl Client {
    async fn publish(
        &self,
        topic: String,
        qos: srad_types::topic::QoS,
        retain: bool,
        payload: Vec<u8>,
    ) -> Result<(), ()> {
        self.0.publish(topic, quality(&qos), retain, payload).await.map_err(drop)
    }

    fn try_publish(
        &self,
        topic: String,
        qos: srad_types::topic::QoS,
        retain: bool,
        payload: Vec<u8>,
    ) -> Result<(), ()> {
        self.0.try_publish(topic, quality(&qos), retain, payload).map_err(drop)
    }
}

#[async_trait]
impl srad_client::Client for Client {
    async fn disconnect(&self) -> Result<(), ()> {
        self.0.disconnect().await.map_err(drop)
    }

    /// An edge node publishes no state of a host.
    async fn publish_state_message(&self, _: StateTopic, _: StatePayload) -> Result<(), ()> {
        Err(())
    }

    async fn try_publish_state_message(&self, _: StateTopic, _: StatePayload) -> Result<(), ()> {
        Err(())
    }

    async fn publish_node_message(&self, topic: NodeTopic, payload: Payload) -> Result<(), ()> {
        let (qos, retain) = topic.get_publish_quality_retain();
        self.publish(topic.topic, qos, retain, payload.into()).await
    }

    async fn try_publish_node_message(&self, topic: NodeTopic, payload: Payload) -> Result<(), ()> {
        let (qos, retain) = topic.get_publish_quality_retain();
        let payload = if topic.message_type == NodeMessage::NDeath { with_type(payload) } else { payload };
        self.try_publish(topic.topic, qos, retain, payload.into())
    }

    async fn publish_device_message(&self, topic: DeviceTopic, payload: Payload) -> Result<(), ()> {
        let (qos, retain) = topic.get_publish_quality_retain();
        self.publish(topic.topic, qos, retain, with_nulls(payload).into()).await
    }

    async fn try_publish_device_message(&self, topic: DeviceTopic, payload: Payload) -> Result<(), ()> {
        let (qos, retain) = topic.get_publish_quality_retain();
        self.try_publish(topic.topic, qos, retain, with_nulls(payload).into())
    }

    async fn subscribe_many(&self, topics: Vec<TopicFilter>) -> Result<(), ()> {
        for filter in topics {
            self.0.subscribe(filter.topic, quality(&filter.qos)).await.map_err(drop)?;
        }
        Ok(())
    }
}

/// Event loop of the library on rumqttc.
struct EventLoop {
    inner: rumqttc::EventLoop,
    broker: String,
    is_online: bool,
    /// Time at which the connection was lost.
    lost: Option<Instant>,
    connection: Arc<Connection>,
}

impl EventLoop {
    fn connected(&mut self) {
        self.is_online = true;
        if let Some(since) = self.lost.take() {
            let seconds = since.elapsed().as_secs_f64();
            self.connection
                .report("output-recovered", format!("The MQTT broker responds again, after {seconds:.0} s."));
        }
    }

    /// Reports an error once; returns true where it ends a connection.
    fn failed(&mut self, error: &rumqttc::ConnectionError) -> bool {
        if self.lost.is_none() {
            self.lost = Some(Instant::now());
            let sentence =
                format!("MQTT broker {}: {error}; the monitor continues and retries every second.", self.broker);
            self.connection.report("output-failing", sentence);
        }
        std::mem::take(&mut self.is_online)
    }
}

#[async_trait]
impl srad_client::EventLoop for EventLoop {
    async fn poll(&mut self) -> srad_client::Event {
        loop {
            match self.inner.poll().await {
                Ok(Event::Incoming(Packet::ConnAck(_))) => {
                    self.connected();
                    return srad_client::Event::Online;
                }
                Ok(Event::Incoming(Packet::Publish(message))) => {
                    return topic_and_payload_to_event(message.topic.into_bytes(), message.payload.to_vec());
                }
                Ok(Event::Outgoing(Outgoing::Disconnect)) => return srad_client::Event::Offline,
                Ok(_) => {}
                Err(error) => {
                    if self.failed(&error) {
                        return srad_client::Event::Offline;
                    }
                    tokio::time::sleep(RETRY_INTERVAL).await;
                }
            }
        }
    }

    fn set_last_will(&mut self, will: LastWill) {
        let LastWill { topic, retain, qos, payload } = will;
        let payload = Payload::decode(payload.as_slice()).map_or(payload, |death| with_type(death).into());
        self.inner.mqtt_options.set_last_will(rumqttc::LastWill::new(topic, payload, quality(&qos), retain));
    }
}
