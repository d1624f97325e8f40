//! Prometheus endpoint with the indicators of the latest second, on a port of 127.0.0.1.

use super::super::feed::SourceCounters;
use super::super::feed::lock;
use super::super::http::{self, Body, Client, Server, Service};
use anyhow::Result;
use ballrace_twin::replay::limits::LimitStatus;
use ballrace_twin::replay::outcome::{NumericField, OutputFigures};
use ballrace_twin::replay::second::{BearingSecond, ProbeSecond, Second, SensorSecond};
use hyper::body::Incoming;
use hyper::{Method, Request, Response, StatusCode};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

/// Format of the metrics.
const METRICS_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// Data of the metrics.
pub struct Metrics<'a> {
    /// Latest second.
    pub second: &'a Second,
    /// Limits of the scene.
    pub limits: &'a [LimitStatus],
    /// Counters of the source.
    pub counters: &'a SourceCounters,
    /// Missed deadlines.
    pub misses: u64,
    /// Records that outputs could not write.
    pub outputs: OutputFigures,
    /// Number of events of each kind.
    pub event_counts: &'a BTreeMap<&'static str, u64>,
}

/// HTTP endpoint, which ends on drop.
pub struct Prometheus {
    page: Page,
    _server: Server,
}

/// Latest metrics.
#[derive(Clone)]
struct Page {
    text: Arc<Mutex<String>>,
    /// Names to which a request may be, besides `localhost` and IP addresses.
    hosts: Arc<[String]>,
}

impl Prometheus {
    /// Listens on `port` of 127.0.0.1, for requests to `localhost`, to an IP address or to one of the names `hosts`.
    ///
    /// # Errors
    /// Returns an error if the port is in use.
    pub fn listen(port: u16, hosts: &[String]) -> Result<Self> {
        let listener = http::bind("--prometheus", SocketAddr::from((Ipv4Addr::LOCALHOST, port)))?;
        let page = Page { text: Arc::default(), hosts: hosts.into() };
        let server = Server::start("prometheus", listener, page.clone(), std::future::ready(()))?;
        Ok(Self { page, _server: server })
    }

    /// Replaces the served metrics.
    pub fn update(&self, metrics: &Metrics) {
        *lock(&self.page.text) = page(metrics);
    }
}

impl Service for Page {
    async fn respond(&self, request: Request<Incoming>, _: Client) -> Response<Body> {
        if !http::is_for_host(&request, &self.hosts) {
            let reason = "unknown host name, expected localhost, an IP address or a name in --http-host\n";
            return http::text(StatusCode::FORBIDDEN, METRICS_TYPE, reason);
        }
        match (request.method(), request.uri().path()) {
            (&Method::GET | &Method::HEAD, "/metrics" | "/") => {
                let page = lock(&self.text).clone();
                http::text(StatusCode::OK, METRICS_TYPE, page)
            }
            (&Method::GET | &Method::HEAD, _) => http::text(StatusCode::NOT_FOUND, METRICS_TYPE, "see /metrics\n"),
            _ => http::text(StatusCode::METHOD_NOT_ALLOWED, METRICS_TYPE, "expected GET\n"),
        }
    }
}

/// Name, description and type of a metric.
struct Metric<'a> {
    name: &'a str,
    help: &'a str,
    kind: &'a str,
}

impl Metric<'_> {
    /// Appends the metric with its samples, pairs of labels and value.
    fn write(&self, page: &mut String, samples: impl IntoIterator<Item = (String, f64)>) {
        let Self { name, help, kind } = self;
        let _ = writeln!(page, "# HELP {name} {help}\n# TYPE {name} {kind}");
        for (labels, value) in samples {
            let _ = writeln!(page, "{name}{labels} {value}");
        }
    }
}

/// Escapes the value of a label.
fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

/// Appends one gauge for each field, with a sample for each object; nothing without an object.
fn write_gauges<T>(
    page: &mut String,
    prefix: &str,
    fields: &[NumericField<T>],
    objects: &[T],
    labels: impl Fn(&T) -> String,
) {
    for field in fields.iter().filter(|_| !objects.is_empty()) {
        let samples = objects.iter().map(|of| (labels(of), (field.value)(of)));
        let name = format!("{prefix}_{}", field.key);
        Metric { name: &name, help: field.help, kind: "gauge" }.write(page, samples);
    }
}

/// Returns the labels of a limit, and 1 where it is exceeded.
fn limit_series(status: &LimitStatus) -> (String, f64) {
    let LimitStatus { indicator, probe, bearing, limit, .. } = status;
    let bearing = bearing.as_ref().map_or_else(String::new, |name| format!(",bearing=\"{}\"", escaped(name)));
    let labels = format!("{{indicator=\"{indicator}\",probe=\"{}\",limit=\"{limit}\"{bearing}}}", escaped(probe));
    (labels, f64::from(u8::from(status.exceeded_since_s.is_some())))
}

/// Returns the metrics in the Prometheus text format. A field has the name of its JSON key and of its Parquet column.
fn page(metrics: &Metrics) -> String {
    let Metrics { second, limits, counters, misses, outputs, event_counts } = metrics;
    let mut page = String::new();
    let gauge = |name, help| Metric { name, help, kind: "gauge" };
    write_gauges(&mut page, "ballrace", &Second::FIELDS, std::slice::from_ref(*second), |_| String::new());
    write_gauges(&mut page, "ballrace_probe", &ProbeSecond::FIELDS, &second.probes, |probe| {
        format!("{{probe=\"{}\"}}", escaped(&probe.name))
    });
    write_gauges(&mut page, "ballrace_sensor", &SensorSecond::FIELDS, &second.sensors, |sensor| {
        format!("{{sensor=\"{}\",unit=\"{}\"}}", escaped(&sensor.name), escaped(&sensor.unit))
    });
    write_gauges(&mut page, "ballrace_bearing", &BearingSecond::FIELDS, &second.bearings, |bearing| {
        format!("{{bearing=\"{}\"}}", escaped(&bearing.name))
    });
    if !limits.is_empty() {
        // Equal limits of a scene are one series.
        let series: BTreeMap<String, f64> = limits.iter().map(limit_series).collect();
        gauge("ballrace_limit_exceeded", "1 where a limit of the scene is exceeded.").write(&mut page, series);
    }
    let events = event_counts.iter().map(|(kind, count)| (format!("{{kind=\"{kind}\"}}"), *count as f64));
    Metric { name: "ballrace_events_total", help: "Events since the start.", kind: "counter" }.write(&mut page, events);
    let totals = [
        ("ballrace_rows_total", "Samples read.", &counters.rows),
        ("ballrace_frames_lost_total", "Frames missing between received frames.", &counters.lost),
        ("ballrace_frames_repeated_total", "Frames that arrived twice or too late.", &counters.repeated),
        ("ballrace_frames_malformed_total", "Frames or datagrams of a wrong size.", &counters.malformed),
        ("ballrace_rows_dropped_total", "Samples dropped because the ring was full.", &counters.dropped),
        ("ballrace_connections_total", "Connections of sources.", &counters.connections),
    ];
    for (name, help, counter) in totals {
        let value = counter.load(Ordering::Relaxed) as f64;
        Metric { name, help, kind: "counter" }.write(&mut page, [(String::new(), value)]);
    }
    let deadline_misses =
        Metric { name: "ballrace_deadline_misses_total", help: "Missed deadlines of blocks.", kind: "counter" };
    deadline_misses.write(&mut page, [(String::new(), *misses as f64)]);
    let not_written = [
        (
            "ballrace_events_not_written",
            "Events that are not on disk because the log cannot be written.",
            outputs.events_not_written,
        ),
        ("ballrace_seconds_not_written", "Seconds of indicators that are not on disk.", outputs.seconds_not_written),
        (
            "ballrace_messages_not_delivered",
            "Messages that wait for the MQTT broker or are lost.",
            outputs.messages_not_delivered,
        ),
    ];
    for (name, help, value) in not_written {
        gauge(name, help).write(&mut page, [(String::new(), value as f64)]);
    }
    page
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Metrics of a scene with everything.
    fn served() -> String {
        let second = Second {
            probes: vec![ProbeSecond { name: "DE \"X\"".to_owned(), one_x_um: 2.5, ..ProbeSecond::default() }],
            bearings: vec![BearingSecond { name: "DE".to_owned(), fx_n: -30.0, ..BearingSecond::default() }],
            sensors: vec![SensorSecond { unit: "m/s^2".to_owned(), ..SensorSecond::default() }],
            ..Second::default()
        };
        let limit = |limit: f64, exceeded_since_s: Option<f64>| LimitStatus {
            indicator: "rms",
            probe: "DE".to_owned(),
            bearing: Some("NDE".to_owned()),
            unit: "um",
            value: None,
            limit,
            exceeded_since_s,
        };
        page(&Metrics {
            second: &second,
            limits: &[limit(4.0, Some(1.0)), limit(4.0, Some(1.0)), limit(8.0, None)],
            counters: &SourceCounters::default(),
            misses: 3,
            outputs: OutputFigures::default(),
            event_counts: &BTreeMap::from([("fault-found", 0)]),
        })
    }

    /// Names of metrics in a text.
    fn names(text: &str) -> BTreeSet<String> {
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let words = text.split(|c: char| !is_part(c));
        words.filter(|word| word.starts_with("ballrace_")).map(str::to_owned).collect()
    }

    #[test]
    fn each_figure_is_a_gauge_with_its_labels() {
        let page = served();
        for line in [
            "ballrace_probe_one_x_um{probe=\"DE \\\"X\\\"\"} 2.5\n",
            "ballrace_bearing_FX_N{bearing=\"DE\"} -30\n",
            "ballrace_sensor_rms{sensor=\"\",unit=\"m/s^2\"} 0\n",
            "ballrace_limit_exceeded{indicator=\"rms\",probe=\"DE\",limit=\"4\",bearing=\"NDE\"} 1\n",
            "ballrace_limit_exceeded{indicator=\"rms\",probe=\"DE\",limit=\"8\",bearing=\"NDE\"} 0\n",
            "ballrace_events_total{kind=\"fault-found\"} 0\n",
            "ballrace_deadline_misses_total 3\n",
        ] {
            assert_eq!(page.matches(line).count(), 1, "{line} in {page}");
        }
    }

    /// The rules and the dashboard use metrics that exist, and the documentation lists all of them and no other.
    #[test]
    fn documents_name_the_metrics_that_are_served() {
        let served: BTreeSet<String> = served()
            .lines()
            .filter_map(|line| Some(line.strip_prefix("# TYPE ")?.split(' ').next()?.to_owned()))
            .collect();
        let read =
            |name: &str| std::fs::read_to_string(format!("{}/../docs/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        for file in ["deploy/prometheus-rules.yml", "deploy/prometheus-rules-test.yml", "deploy/grafana-dashboard.json"]
        {
            let used = names(&read(file));
            let unknown: Vec<_> = used.difference(&served).collect();
            assert!(!used.is_empty() && unknown.is_empty(), "{file}: {unknown:?}");
        }
        assert_eq!(names(&read("src/live.md")), served);
    }
}
