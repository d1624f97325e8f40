//! Live page: the state of the machine in a browser, with server-sent events.
//!
//! The page runs on a thread of its own and reads the shared view, so that it does not block the monitor loop. Figures and
//! history are drawn on demand, one at a time.

mod access;
mod history;
mod state;

use super::Options;
use super::http::{self, Body, Client, Server, Service};
use super::view::SharedView;
use access::Access;
use anyhow::Result;
use ballrace_report::live::{LiveFigure, figures};
use ballrace_twin::scene::Scene;
use http_body_util::{BodyExt, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{
    ACCESS_CONTROL_ALLOW_ORIGIN, CACHE_CONTROL, CONTENT_SECURITY_POLICY, HeaderName, HeaderValue, ORIGIN,
    REFERRER_POLICY, VARY, X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use hyper::{Method, Request, Response, StatusCode};
use serde::Deserialize;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};
use tokio::sync::{Mutex, watch};

/// Interval between two events.
const INTERVAL: Duration = Duration::from_secs(1);
/// Shortest interval between two drawings of the figures.
const FIGURES_INTERVAL: Duration = Duration::from_secs(2);
/// Delay of the response to a wrong token.
const WRONG_TOKEN_DELAY: Duration = Duration::from_secs(1);
/// Maximum length of the body of a request, bytes.
const MAX_BODY_LENGTH: usize = 4096;
/// Maximum number of acknowledgements that wait for the monitor.
const MAX_ACKNOWLEDGEMENTS: usize = 64;

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const JSON: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

/// Options of the live page.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct HttpOptions {
    /// Serve a live page: PORT of 127.0.0.1, or ADDRESS:PORT.
    #[arg(long = "http", value_name = "ADDRESS:PORT", value_parser = access::parse_address)]
    pub address: Option<SocketAddr>,
    /// Allow users who know the token in this file to acknowledge alarms; the page is read-only without it.
    #[arg(long = "http-token-file", value_name = "FILE", requires = "address")]
    pub token_file: Option<PathBuf>,
    /// Accept requests to these host names as well, e.g. that of a reverse proxy.
    #[arg(long = "http-host", value_name = "NAME", value_delimiter = ',', requires = "address")]
    pub hosts: Vec<String>,
    /// Show the machines of these monitors as well, e.g. "http://127.0.0.1:8082".
    #[arg(long = "http-also", value_name = "URL", value_delimiter = ',', requires = "address", value_parser = access::parse_origin)]
    pub also: Vec<String>,
    /// Allow the page of these monitors, which name this one in --http-also, to show this machine.
    #[arg(long = "http-origin", value_name = "URL", value_delimiter = ',', requires = "address", value_parser = access::parse_origin)]
    pub origins: Vec<String>,
}

/// Live page, which ends on drop.
pub struct Page {
    acknowledgements: Receiver<String>,
    _server: Server,
}

impl Page {
    /// Starts the page; `None` if it is not requested.
    ///
    /// # Errors
    /// Returns an error if the address cannot be bound, or the token cannot be read.
    pub fn start(options: &Options, scene: &Scene, view: &SharedView) -> Result<Option<Self>> {
        let Some(address) = options.http.address else { return Ok(None) };
        let access = Access::try_new(options.http)?;
        let listener = http::bind("--http", address)?;
        let (sender, acknowledgements) = sync_channel(MAX_ACKNOWLEDGEMENTS);
        let description = state::Description::new(scene, &options.source, options.http, access.has_token());
        let first = Arc::from(description.state(&view.peek()));
        let site = Site(Arc::new(SiteData {
            policy: policy(&options.http.also)?,
            access,
            description,
            view: view.clone(),
            scene: scene.clone(),
            indicators: options.outputs.indicators.clone(),
            states: watch::Sender::new(first),
            drawn: Mutex::default(),
            acknowledgements: sender,
        }));
        let server = Server::start("page", listener, site.clone(), site.publish_states())?;
        Ok(Some(Self { acknowledgements, _server: server }))
    }

    /// Returns the identifier of an alarm that a user has acknowledged since the last call.
    #[must_use]
    pub fn next_acknowledgement(&self) -> Option<String> {
        self.acknowledgements.try_recv().ok()
    }
}

/// Returns the content security policy: the page's own files, and the events of the monitors `also`.
fn policy(also: &[String]) -> Result<HeaderValue> {
    let others: String = also.iter().map(|origin| format!(" {origin}")).collect();
    Ok(HeaderValue::try_from(format!(
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'{others}; base-uri 'none'; \
         form-action 'none'; frame-ancestors 'none'"
    ))?)
}

#[derive(Clone)]
struct Site(Arc<SiteData>);

struct SiteData {
    policy: HeaderValue,
    access: Access,
    description: state::Description,
    view: SharedView,
    scene: Scene,
    indicators: Option<PathBuf>,
    /// State as JSON, replaced once per second.
    states: watch::Sender<Arc<str>>,
    /// Figures as JSON, and the time at which they were drawn. The lock admits one drawing at a time.
    drawn: Mutex<Option<(Instant, Bytes)>>,
    acknowledgements: SyncSender<String>,
}

/// Body of an acknowledgement.
#[derive(Deserialize)]
struct Acknowledgement {
    alarm: String,
}

impl Service for Site {
    async fn respond(&self, request: Request<Incoming>, client: Client) -> Response<Body> {
        let site = &self.0;
        let origin = request.headers().get(ORIGIN).filter(|origin| site.access.allows_origin(origin)).cloned();
        let mut response = if site.access.allows_host(&request) {
            self.route(request, client).await
        } else {
            http::text(StatusCode::FORBIDDEN, TEXT, "unknown host name; --http-host NAME allows it\n")
        };
        let headers = response.headers_mut();
        let fixed: [(HeaderName, &'static str); 4] = [
            (CACHE_CONTROL, "no-store"),
            (X_CONTENT_TYPE_OPTIONS, "nosniff"),
            (REFERRER_POLICY, "no-referrer"),
            (X_FRAME_OPTIONS, "DENY"),
        ];
        headers.extend(fixed.map(|(name, value)| (name, HeaderValue::from_static(value))));
        headers.insert(CONTENT_SECURITY_POLICY, site.policy.clone());
        headers.insert(VARY, HeaderValue::from_static("Origin"));
        if let Some(origin) = origin {
            headers.insert(ACCESS_CONTROL_ALLOW_ORIGIN, origin);
        }
        response
    }
}

impl Site {
    async fn route(&self, request: Request<Incoming>, client: Client) -> Response<Body> {
        let is_read = matches!(*request.method(), Method::GET | Method::HEAD);
        match request.uri().path() {
            "/" if is_read => http::text(StatusCode::OK, HTML, include_str!("page.html")),
            "/page.js" if is_read => http::text(StatusCode::OK, SCRIPT, include_str!("page.js")),
            "/page.css" if is_read => http::text(StatusCode::OK, STYLE, include_str!("page.css")),
            "/events" if *request.method() == Method::GET => self.events(client),
            "/state" if is_read => {
                let state = self.0.states.borrow().to_string();
                http::text(StatusCode::OK, JSON, state)
            }
            "/figures" if is_read => self.figures().await,
            "/history" if is_read => self.history(request.uri().query().unwrap_or_default()).await,
            "/acknowledge" if *request.method() == Method::POST => self.acknowledge(request).await,
            "/" | "/page.js" | "/page.css" | "/events" | "/state" | "/figures" | "/history" => {
                http::text(StatusCode::METHOD_NOT_ALLOWED, TEXT, "expected GET\n")
            }
            "/acknowledge" => http::text(StatusCode::METHOD_NOT_ALLOWED, TEXT, "expected POST\n"),
            _ => http::text(StatusCode::NOT_FOUND, TEXT, "see /\n"),
        }
    }

    /// Computes and publishes the state once per second, in an endless loop.
    async fn publish_states(self) {
        let mut ticks = tokio::time::interval(INTERVAL);
        loop {
            ticks.tick().await;
            self.0.states.send_replace(Arc::from(self.0.description.state(&self.0.view.peek())));
        }
    }

    /// Opens a stream of states. A slow client does not receive every state, but always the latest one.
    fn events(&self, client: Client) -> Response<Body> {
        let (mut stream, response) = client.stream();
        let mut states = self.0.states.subscribe();
        tokio::spawn(async move {
            loop {
                let state = states.borrow_and_update().clone();
                if !stream.send("state", &state).await || states.changed().await.is_err() {
                    break;
                }
            }
        });
        response
    }

    async fn figures(&self) -> Response<Body> {
        let mut drawn = self.0.drawn.lock().await;
        // Reading the view requests a snapshot from the monitor.
        let view = self.0.view.get();
        let is_recent = |drawn: &&(Instant, Bytes)| drawn.0.elapsed() < FIGURES_INTERVAL;
        if let Some((_, figures)) = drawn.as_ref().filter(is_recent) {
            return http::text(StatusCode::OK, JSON, figures.clone());
        }
        let site = self.0.clone();
        let result = on_drawing_thread(move || Ok(figures(&site.scene, &view.snapshot))).await;
        if let Ok(figures) = &result {
            *drawn = Some((Instant::now(), figures.clone()));
        }
        drawing_response(result)
    }

    async fn history(&self, query: &str) -> Response<Body> {
        let Some(hours) = history::parse_hours(query) else {
            let expected = "expected /history?hours=N with N from 0.1 to 168\n";
            return http::text(StatusCode::BAD_REQUEST, TEXT, expected);
        };
        let _drawing = self.0.drawn.lock().await;
        let (site, view) = (self.0.clone(), self.0.view.peek());
        let draw = move || history::figures(&site.scene, site.indicators.as_deref(), &view, hours);
        drawing_response(on_drawing_thread(draw).await)
    }

    async fn acknowledge(&self, request: Request<Incoming>) -> Response<Body> {
        if !self.0.access.has_token() {
            let reason = "read-only: the monitor was started without --http-token-file\n";
            return http::text(StatusCode::FORBIDDEN, TEXT, reason);
        }
        if !self.0.access.has_valid_token(&request) {
            tokio::time::sleep(WRONG_TOKEN_DELAY).await;
            let reason = "wrong or missing token, expected Authorization: Bearer TOKEN\n";
            return http::text(StatusCode::FORBIDDEN, TEXT, reason);
        }
        let Ok(body) = Limited::new(request.into_body(), MAX_BODY_LENGTH).collect().await else {
            return http::text(StatusCode::PAYLOAD_TOO_LARGE, TEXT, "expected at most 4096 bytes\n");
        };
        let Ok(Acknowledgement { alarm }) = serde_json::from_slice(&body.to_bytes()) else {
            return http::text(StatusCode::BAD_REQUEST, TEXT, "expected {\"alarm\": \"ID\"}\n");
        };
        let view = self.0.view.peek();
        if !view.alarms.alarms().iter().any(|known| known.id == alarm && known.is_unacknowledged()) {
            return http::text(StatusCode::NOT_FOUND, TEXT, "no such alarm, or it is acknowledged already\n");
        }
        match self.0.acknowledgements.try_send(alarm) {
            Ok(()) => http::text(StatusCode::ACCEPTED, TEXT, "accepted\n"),
            Err(_) => http::text(StatusCode::SERVICE_UNAVAILABLE, TEXT, "the monitor is busy\n"),
        }
    }
}

/// Runs `draw` on the thread for drawings; returns its figures as JSON.
async fn on_drawing_thread(draw: impl FnOnce() -> Result<Vec<LiveFigure>> + Send + 'static) -> Result<Bytes> {
    let json = move || Ok(Bytes::from(serde_json::to_vec(&draw()?)?));
    tokio::task::spawn_blocking(json).await?
}

fn drawing_response(figures: Result<Bytes>) -> Response<Body> {
    match figures {
        Ok(figures) => http::text(StatusCode::OK, JSON, figures),
        Err(error) => http::text(StatusCode::INTERNAL_SERVER_ERROR, TEXT, format!("{error:#}\n")),
    }
}
