//! Prometheus endpoint with the indicators of the latest second, on a port of 127.0.0.1.

use super::super::feed::SourceCounters;
use super::super::source::lock;
use anyhow::{Context, Result};
use ballrace_twin::replay::outcome::{LimitLine, OutputFigures};
use ballrace_twin::replay::second::{BearingSecond, ProbeSecond, Second, SecondFigure, SensorSecond};
use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{CONTENT_TYPE, HeaderValue};
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;
use std::fmt::Write;
use std::net::Ipv4Addr;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::task::AbortHandle;

/// Maximum number of clients; a further client replaces the oldest one.
const MAX_CLIENTS: usize = 32;
/// Time limit for the header of a request.
const HEADER_TIMEOUT: Duration = Duration::from_secs(5);
/// Time limit for a request and its response.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(10);
/// Maximum length of a request header, bytes.
const MAX_HEADER_LENGTH: usize = 16 << 10;
/// Pause after a failed accept, for example without free file descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

type Page = Arc<Mutex<String>>;

/// Data of the metrics.
pub struct Metrics<'a> {
    /// Latest second.
    pub second: &'a Second,
    /// Limits of the scene, and whether they are exceeded.
    pub limits: &'a [(LimitLine, bool)],
    /// Counters of the source.
    pub counters: &'a SourceCounters,
    /// Missed deadlines.
    pub misses: u64,
    /// Records that outputs could not write.
    pub outputs: OutputFigures,
    /// Number of events of each kind.
    pub event_counts: &'a BTreeMap<&'static str, u64>,
}

/// HTTP endpoint on a thread of its own, which ends on drop.
pub struct Prometheus {
    page: Page,
    _stop: oneshot::Sender<()>,
}

impl Prometheus {
    /// Listens on `port` of 127.0.0.1.
    ///
    /// # Errors
    /// Returns an error if the port is in use.
    pub fn listen(port: u16) -> Result<Self> {
        let cannot_listen = || format!("--prometheus: cannot listen on this port: {port}, expected a free port");
        let listener = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, port)).with_context(cannot_listen)?;
        listener.set_nonblocking(true).with_context(cannot_listen)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build()?;
        let listener = {
            let _entered = runtime.enter();
            TcpListener::from_std(listener).with_context(cannot_listen)?
        };
        let page = Page::default();
        let (stop, stopped) = oneshot::channel();
        let served_page = page.clone();
        let serve = move || {
            runtime.block_on(async {
                tokio::select! {
                    // Completes as well when the sender is dropped.
                    _ = stopped => {}
                    () = accept(listener, served_page) => {}
                }
            });
        };
        std::thread::Builder::new().name("prometheus".to_owned()).spawn(serve)?;
        Ok(Self { page, _stop: stop })
    }

    /// Replaces the served metrics.
    pub fn update(&self, metrics: &Metrics) {
        *lock(&self.page) = page(metrics);
    }
}

/// Accepts clients in an endless loop.
async fn accept(listener: TcpListener, page: Page) {
    let mut clients: VecDeque<AbortHandle> = VecDeque::new();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(ACCEPT_PAUSE).await;
            continue;
        };
        clients.retain(|client| !client.is_finished());
        if clients.len() >= MAX_CLIENTS
            && let Some(oldest) = clients.pop_front()
        {
            oldest.abort();
        }
        let task = tokio::time::timeout(CLIENT_TIMEOUT, serve_client(stream, page.clone()));
        clients.push_back(tokio::spawn(task).abort_handle());
    }
}

/// Serves one request. The body of the request is not read.
async fn serve_client(stream: TcpStream, page: Page) {
    let service = hyper::service::service_fn(|request: Request<hyper::body::Incoming>| {
        let response = response(request.method(), request.uri().path(), &page);
        async { Ok::<_, Infallible>(response) }
    });
    // An error of one client does not affect the others.
    let _ = hyper::server::conn::http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIMEOUT)
        .max_buf_size(MAX_HEADER_LENGTH)
        .keep_alive(false)
        .serve_connection(TokioIo::new(stream), service)
        .await;
}

fn response(method: &Method, path: &str, page: &Page) -> Response<Full<Bytes>> {
    let (status, text) = match (method, path) {
        (&Method::GET | &Method::HEAD, "/metrics" | "/") => (StatusCode::OK, lock(page).clone()),
        (&Method::GET | &Method::HEAD, _) => (StatusCode::NOT_FOUND, "see /metrics\n".to_owned()),
        _ => (StatusCode::METHOD_NOT_ALLOWED, "expected GET\n".to_owned()),
    };
    let mut response = Response::new(Full::from(text));
    *response.status_mut() = status;
    let kind = HeaderValue::from_static("text/plain; version=0.0.4; charset=utf-8");
    response.headers_mut().insert(CONTENT_TYPE, kind);
    response
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

/// Figures of one labelled object: labels and figures.
type Labelled = (String, Vec<SecondFigure>);

/// Appends one gauge for each figure, with a sample for each object; nothing without an object.
fn write_gauges(page: &mut String, prefix: &str, objects: &[Labelled]) {
    let Some((_, first)) = objects.first() else { return };
    for (i, figure) in first.iter().enumerate() {
        let samples = objects.iter().filter_map(|(labels, all)| Some((labels.clone(), all.get(i)?.value)));
        let name = format!("{prefix}_{}", figure.name);
        Metric { name: &name, help: figure.help, kind: "gauge" }.write(page, samples);
    }
}

/// Returns the labels of a limit, and 1 where it is exceeded.
fn limit_series((line, is_exceeded): &(LimitLine, bool)) -> (String, f64) {
    let bearing = line.bearing.as_ref().map_or_else(String::new, |name| format!(",bearing=\"{}\"", escaped(name)));
    let LimitLine { indicator, probe, max, .. } = line;
    let labels = format!("{{indicator=\"{indicator}\",probe=\"{}\",max=\"{max}\"{bearing}}}", escaped(probe));
    (labels, f64::from(u8::from(*is_exceeded)))
}

/// Returns the metrics in the Prometheus text format. A figure has the name of its JSON key and of its Parquet column.
fn page(metrics: &Metrics) -> String {
    let Metrics { second, limits, counters, misses, outputs, event_counts } = metrics;
    let mut page = String::new();
    let gauge = |name, help| Metric { name, help, kind: "gauge" };
    write_gauges(&mut page, "ballrace", &[(String::new(), second.figures().to_vec())]);
    let probe = |p: &ProbeSecond| (format!("{{probe=\"{}\"}}", escaped(&p.name)), p.figures().to_vec());
    write_gauges(&mut page, "ballrace_probe", &second.probes.iter().map(probe).collect::<Vec<_>>());
    let sensor = |s: &SensorSecond| {
        let labels = format!("{{sensor=\"{}\",unit=\"{}\"}}", escaped(&s.name), escaped(&s.unit));
        (labels, s.figures().to_vec())
    };
    write_gauges(&mut page, "ballrace_sensor", &second.sensors.iter().map(sensor).collect::<Vec<_>>());
    let bearing = |b: &BearingSecond| (format!("{{bearing=\"{}\"}}", escaped(&b.name)), b.figures().to_vec());
    write_gauges(&mut page, "ballrace_bearing", &second.bearings.iter().map(bearing).collect::<Vec<_>>());
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
        let limit = |max: f64| LimitLine {
            indicator: "rms",
            probe: "DE".to_owned(),
            bearing: Some("NDE".to_owned()),
            max,
            largest: None,
        };
        page(&Metrics {
            second: &second,
            limits: &[(limit(4.0), true), (limit(4.0), true), (limit(8.0), false)],
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
            "ballrace_limit_exceeded{indicator=\"rms\",probe=\"DE\",max=\"4\",bearing=\"NDE\"} 1\n",
            "ballrace_limit_exceeded{indicator=\"rms\",probe=\"DE\",max=\"8\",bearing=\"NDE\"} 0\n",
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
