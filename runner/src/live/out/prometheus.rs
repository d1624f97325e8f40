//! The last second's indicators as Prometheus reads them, at a port of this machine.

use super::super::feed::Counts;
use super::super::source::lock;
use anyhow::{Context, Result};
use ballrace_twin::replay::outcome::OutputFigures;
use ballrace_twin::replay::second::{ProbeSecond, Second};
use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{CONTENT_TYPE, HeaderValue};
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::fmt::Write;
use std::net::Ipv4Addr;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::task::AbortHandle;

/// Most clients at a time; a further one takes the place of the oldest.
const MOST_CLIENTS: usize = 32;
/// Time for a client to send its header.
const HEADER_TIMEOUT: Duration = Duration::from_secs(5);
/// Time for a client to be done.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(10);
/// Largest header, bytes.
const MOST_HEADER: usize = 16 << 10;
/// Pause after a connection that could not be accepted, such as for want of descriptors.
const PAUSE: Duration = Duration::from_millis(100);

type Page = Arc<Mutex<String>>;

/// An HTTP endpoint with a thread of its own, which ends when this is dropped.
pub struct Prometheus {
    page: Page,
    _stop: oneshot::Sender<()>,
}

impl Prometheus {
    /// Listens at `port` of 127.0.0.1.
    ///
    /// # Errors
    /// A port that is taken.
    pub fn listen(port: u16) -> Result<Self> {
        let refused = || format!("--prometheus {port}: cannot be listened at, allowed: a free port");
        let listener = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, port)).with_context(refused)?;
        listener.set_nonblocking(true).with_context(refused)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build()?;
        let listener = {
            let _entered = runtime.enter();
            TcpListener::from_std(listener).with_context(refused)?
        };
        let page = Page::default();
        let (stop, stopped) = oneshot::channel();
        let shown = page.clone();
        let serve = move || {
            runtime.block_on(async {
                tokio::select! {
                    // Also where the other end is dropped.
                    _ = stopped => {}
                    () = accept(listener, shown) => {}
                }
            });
        };
        std::thread::Builder::new().name("prometheus".to_owned()).spawn(serve)?;
        Ok(Self { page, _stop: stop })
    }

    /// Shows a second.
    pub fn show(&self, second: &Second, counts: &Counts, misses: u64, outputs: &OutputFigures) {
        *lock(&self.page) = page(second, counts, misses, outputs);
    }
}

/// Accepts clients for ever.
async fn accept(listener: TcpListener, page: Page) {
    let mut clients: VecDeque<AbortHandle> = VecDeque::new();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        clients.retain(|client| !client.is_finished());
        if clients.len() >= MOST_CLIENTS
            && let Some(oldest) = clients.pop_front()
        {
            oldest.abort();
        }
        let answered = tokio::time::timeout(CLIENT_TIMEOUT, answer(stream, page.clone()));
        clients.push_back(tokio::spawn(answered).abort_handle());
    }
}

/// One request and its answer. A body is not read.
async fn answer(stream: TcpStream, page: Page) {
    let service = hyper::service::service_fn(|request: Request<hyper::body::Incoming>| {
        let response = response(request.method(), request.uri().path(), &page);
        async { Ok::<_, Infallible>(response) }
    });
    // A client that goes away or sends no HTTP concerns nobody else.
    let _ = hyper::server::conn::http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIMEOUT)
        .max_buf_size(MOST_HEADER)
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

/// One metric with its description and all its samples.
struct Metric<'a> {
    name: &'a str,
    help: &'a str,
    kind: &'a str,
}

impl Metric<'_> {
    fn write(&self, page: &mut String, samples: impl IntoIterator<Item = (String, f64)>) {
        let Self { name, help, kind } = self;
        let _ = writeln!(page, "# HELP {name} {help}\n# TYPE {name} {kind}");
        for (labels, value) in samples {
            let _ = writeln!(page, "{name}{labels} {value}");
        }
    }
}

/// Escapes a label's value as the format requires.
fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

type Figure = fn(&ProbeSecond) -> f64;

fn page(second: &Second, counts: &Counts, misses: u64, outputs: &OutputFigures) -> String {
    let mut page = String::new();
    let gauge = |name, help| Metric { name, help, kind: "gauge" };
    gauge("ballrace_time_seconds", "End of the second shown, in the recording's time.")
        .write(&mut page, [(String::new(), second.time_s)]);
    gauge("ballrace_shaft_speed_rpm", "Mean speed.").write(&mut page, [(String::new(), second.speed_rpm)]);
    gauge(
        "ballrace_innovation_ratio",
        "Normalised innovation squared over its expectation; 1 where the model is true.",
    )
    .write(&mut page, [(String::new(), second.innovation)]);
    let of_probes: [(&str, &str, Figure); 8] = [
        ("ballrace_probe_mean_um", "Mean position.", |p| p.mean_um),
        ("ballrace_probe_peak_to_peak_um", "Greatest less least reading.", |p| p.peak_to_peak_um),
        ("ballrace_probe_rms_um", "About the mean.", |p| p.rms_um),
        ("ballrace_probe_crest_factor", "Greatest distance from the mean over the rms.", |p| p.crest_factor),
        ("ballrace_probe_kurtosis", "3 of noise, 1.5 of a sine.", |p| p.kurtosis),
        ("ballrace_probe_residual_rms_um", "RMS of measured minus twin, about its mean.", |p| p.residual_rms_um),
        ("ballrace_probe_1x_um", "1X amplitude, zero to peak.", |p| p.one_x_um),
        ("ballrace_probe_1x_phase_lag_degrees", "Behind the keyphasor mark.", |p| p.one_x_phase_lag_deg),
    ];
    for (name, help, value) in of_probes {
        let samples = second.probes.iter().map(|p| (format!("{{probe=\"{}\"}}", escaped(&p.name)), value(p)));
        gauge(name, help).write(&mut page, samples);
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
        ("ballrace_rows_total", "Samples read.", &counts.rows),
        ("ballrace_frames_lost_total", "Frames that never came.", &counts.lost),
        ("ballrace_frames_repeated_total", "Frames that came twice or too late.", &counts.repeated),
        ("ballrace_frames_malformed_total", "Frames or datagrams of a wrong size.", &counts.malformed),
        ("ballrace_rows_dropped_total", "Samples that found the ring full.", &counts.dropped),
        ("ballrace_connections_total", "Connections of sources.", &counts.connections),
    ];
    for (name, help, counter) in totals {
        let value = counter.load(Ordering::Relaxed) as f64;
        Metric { name, help, kind: "counter" }.write(&mut page, [(String::new(), value)]);
    }
    let missed =
        Metric { name: "ballrace_deadline_misses_total", help: "Blocks that were not done in time.", kind: "counter" };
    missed.write(&mut page, [(String::new(), misses as f64)]);
    let not_written = [
        (
            "ballrace_events_not_written",
            "Events that are not on disk because their log fails.",
            outputs.events_not_written,
        ),
        ("ballrace_seconds_not_written", "Seconds of indicators that are not on disk.", outputs.seconds_not_written),
    ];
    for (name, help, value) in not_written {
        gauge(name, help).write(&mut page, [(String::new(), value as f64)]);
    }
    page
}
