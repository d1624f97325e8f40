//! Prometheus endpoint with the indicators of the latest second, on a port of 127.0.0.1.

use super::super::feed::SourceCounters;
use super::super::http::{self, Body, Client, Server, Service};
use super::super::source::lock;
use anyhow::Result;
use ballrace_twin::replay::outcome::OutputFigures;
use ballrace_twin::replay::second::{ProbeSecond, Second, SensorSecond};
use hyper::body::Incoming;
use hyper::{Method, Request, Response, StatusCode};
use std::fmt::Write;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

/// Format of the metrics.
const METRICS_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// HTTP endpoint, which ends on drop.
pub struct Prometheus {
    page: Page,
    _server: Server,
}

/// Latest metrics.
#[derive(Clone, Default)]
struct Page(Arc<Mutex<String>>);

impl Prometheus {
    /// Listens on `port` of 127.0.0.1.
    ///
    /// # Errors
    /// Returns an error if the port is in use.
    pub fn listen(port: u16) -> Result<Self> {
        let listener = http::bind("--prometheus", SocketAddr::from((Ipv4Addr::LOCALHOST, port)))?;
        let page = Page::default();
        let server = Server::start("prometheus", listener, page.clone(), std::future::ready(()))?;
        Ok(Self { page, _server: server })
    }

    /// Replaces the served metrics.
    pub fn update(&self, second: &Second, counters: &SourceCounters, misses: u64, outputs: &OutputFigures) {
        *lock(&self.page.0) = page(second, counters, misses, outputs);
    }
}

impl Service for Page {
    async fn respond(&self, request: Request<Incoming>, _: Client) -> Response<Body> {
        match (request.method(), request.uri().path()) {
            (&Method::GET | &Method::HEAD, "/metrics" | "/") => {
                let page = lock(&self.0).clone();
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

/// Returns the value of an indicator.
type IndicatorValue = fn(&ProbeSecond) -> f64;
/// Returns the value of an indicator of a vibration sensor.
type SensorValue = fn(&SensorSecond) -> f64;

/// Returns the metrics in the Prometheus text format.
fn page(second: &Second, counters: &SourceCounters, misses: u64, outputs: &OutputFigures) -> String {
    let mut page = String::new();
    let gauge = |name, help| Metric { name, help, kind: "gauge" };
    gauge("ballrace_time_seconds", "End of the latest second, in the time of the recording.")
        .write(&mut page, [(String::new(), second.time_s)]);
    gauge("ballrace_shaft_speed_rpm", "Mean shaft speed.").write(&mut page, [(String::new(), second.speed_rpm)]);
    gauge("ballrace_innovation_ratio", "Normalised innovation squared over its expectation; 1 for an exact model.")
        .write(&mut page, [(String::new(), second.innovation)]);
    let probe_metrics: [(&str, &str, IndicatorValue); 8] = [
        ("ballrace_probe_mean_um", "Mean position.", |p| p.mean_um),
        ("ballrace_probe_peak_to_peak_um", "Peak-to-peak displacement.", |p| p.peak_to_peak_um),
        ("ballrace_probe_rms_um", "RMS displacement about the mean.", |p| p.rms_um),
        ("ballrace_probe_crest_factor", "Largest deviation from the mean over the RMS.", |p| p.crest_factor),
        ("ballrace_probe_kurtosis", "Kurtosis: 3 for Gaussian noise, 1.5 for a sine.", |p| p.kurtosis),
        ("ballrace_probe_residual_rms_um", "RMS of measured minus twin, about its mean.", |p| p.residual_rms_um),
        ("ballrace_probe_1x_um", "1X amplitude, zero to peak.", |p| p.one_x_um),
        ("ballrace_probe_1x_phase_lag_degrees", "1X phase lag behind the keyphasor mark.", |p| p.one_x_phase_lag_deg),
    ];
    for (name, help, value) in probe_metrics {
        let samples = second.probes.iter().map(|p| (format!("{{probe=\"{}\"}}", escaped(&p.name)), value(p)));
        gauge(name, help).write(&mut page, samples);
    }
    let sensor_metrics: [(&str, &str, SensorValue); 4] = [
        ("ballrace_sensor_rms", "RMS vibration about the mean.", |s| s.rms),
        ("ballrace_sensor_peak", "Largest deviation of the vibration from its mean.", |s| s.peak),
        ("ballrace_sensor_crest_factor", "Peak of the vibration over its RMS.", |s| s.crest_factor),
        ("ballrace_sensor_kurtosis", "Kurtosis of the vibration: 3 for Gaussian noise.", |s| s.kurtosis),
    ];
    // A scene without sensors has none of these metrics.
    for (name, help, value) in sensor_metrics.into_iter().filter(|_| !second.sensors.is_empty()) {
        let labels = |s: &SensorSecond| format!("{{sensor=\"{}\",unit=\"{}\"}}", escaped(&s.name), escaped(&s.unit));
        gauge(name, help).write(&mut page, second.sensors.iter().map(|s| (labels(s), value(s))));
    }
    let forces = second.bearings.iter().flat_map(|b| {
        let labels = |axis: &str| format!("{{bearing=\"{}\",axis=\"{axis}\"}}", escaped(&b.name));
        ["x", "y", "z"].map(labels).into_iter().zip(b.force_n).collect::<Vec<_>>()
    });
    gauge("ballrace_bearing_force_newtons", "Mean force on the inner ring.").write(&mut page, forces);
    let largest = second.bearings.iter();
    let largest = largest.map(|b| (format!("{{bearing=\"{}\"}}", escaped(&b.name)), b.largest_radial_n));
    gauge("ballrace_bearing_largest_radial_newtons", "Largest radial force in the second.").write(&mut page, largest);
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
    deadline_misses.write(&mut page, [(String::new(), misses as f64)]);
    let not_written = [
        (
            "ballrace_events_not_written",
            "Events that are not on disk because the log cannot be written.",
            outputs.events_not_written,
        ),
        ("ballrace_seconds_not_written", "Seconds of indicators that are not on disk.", outputs.seconds_not_written),
    ];
    for (name, help, value) in not_written {
        gauge(name, help).write(&mut page, [(String::new(), value as f64)]);
    }
    page
}
