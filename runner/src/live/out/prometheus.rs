//! The last second's indicators as Prometheus reads them, at a port of this machine.

use super::super::feed::Counts;
use super::super::source::lock;
use ballrace_twin::replay::second::{ProbeSecond, Second};
use anyhow::{Result, anyhow};
use std::fmt::Write;
use std::net::Ipv4Addr;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use tiny_http::{Header, Response, Server};

/// Answers in a thread of its own.
pub struct Prometheus {
    page: Arc<Mutex<String>>,
    server: Arc<Server>,
}

impl Prometheus {
    /// Listens at `port` of 127.0.0.1.
    ///
    /// # Errors
    /// A port that is taken.
    pub fn listen(port: u16) -> Result<Self> {
        let server = Server::http((Ipv4Addr::LOCALHOST, port))
            .map_err(|e| anyhow!("--prometheus {port}: cannot be listened at ({e}), allowed: a free port"))?;
        let server = Arc::new(server);
        let page = Arc::new(Mutex::new(String::new()));
        let (answering, shown) = (server.clone(), page.clone());
        std::thread::Builder::new().name("prometheus".to_owned()).spawn(move || answer(&answering, &shown))?;
        Ok(Self { page, server })
    }

    /// Shows a second.
    pub fn show(&self, second: &Second, counts: &Counts, misses: u64) {
        *lock(&self.page) = page(second, counts, misses);
    }
}

impl Drop for Prometheus {
    fn drop(&mut self) {
        self.server.unblock();
    }
}

fn answer(server: &Server, page: &Mutex<String>) {
    let kind = Header::from_bytes("Content-Type", "text/plain; version=0.0.4; charset=utf-8").ok();
    for request in server.incoming_requests() {
        let known = request.url() == "/metrics" || request.url() == "/";
        let mut response = Response::from_string(if known { lock(page).clone() } else { "see /metrics\n".to_owned() });
        response = response.with_status_code(if known { 200 } else { 404 });
        if let Some(kind) = &kind {
            response.add_header(kind.clone());
        }
        // Whoever asked may have gone.
        let _ = request.respond(response);
    }
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

/// A label's value as the format wants it.
fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

type Figure = fn(&ProbeSecond) -> f64;

fn page(second: &Second, counts: &Counts, misses: u64) -> String {
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
        ("ballrace_probe_residual_rms_um", "Of what the twin leaves, about its mean.", |p| p.residual_rms_um),
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
    page
}
