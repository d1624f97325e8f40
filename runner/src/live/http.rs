//! HTTP server with bounded clients, on a thread of its own.
//!
//! A header, a request and its response are bounded in size and time. Event streams have no time limit, but their number is
//! bounded, and a client that does not read its stream is disconnected. A further stream replaces an old one, so that clients that do
//! not read, or whose network path was lost, do not lock out the others.

use super::feed::lock;
use anyhow::{Context, Result};
use http_body_util::channel::{Channel, Sender};
use http_body_util::combinators::BoxBody;
use http_body_util::{BodyExt, Full};
use hyper::body::{Bytes, Incoming};
use hyper::header::{CONTENT_TYPE, HOST, HeaderValue};
use hyper::http::uri::Authority;
use hyper::{Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use socket2::SockRef;
use std::cmp::Reverse;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr};
use std::pin::pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Notify, oneshot};
use tokio::task::AbortHandle;

/// Maximum number of clients besides event streams; a further client replaces the oldest one.
const MAX_CLIENTS: usize = 32;
/// Maximum number of event streams; a further one replaces the one to which no event was sent for the longest time, or the
/// oldest one.
const MAX_STREAMS: usize = 32;
/// Time without a sent event that makes a difference between two streams.
const STREAM_INTERVAL: Duration = Duration::from_secs(3);
/// Send buffer of a connection, bytes: what a client that does not read can hold.
const SEND_BUFFER: usize = 64 << 10;
/// Time limit for the header of a request.
const HEADER_TIMEOUT: Duration = Duration::from_secs(5);
/// Time limit for a request and its response.
const CLIENT_TIMEOUT: Duration = Duration::from_secs(10);
/// Time limit for sending one event to a client.
const STALL_TIMEOUT: Duration = Duration::from_secs(10);
/// Maximum length of a request header, bytes.
const MAX_HEADER_LENGTH: usize = 16 << 10;
/// Pause after a failed accept, for example without free file descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Body of a response.
pub type Body = BoxBody<Bytes, Infallible>;

/// Responses to the requests of clients.
pub trait Service: Clone + Send + 'static {
    /// Returns the response to a request. The body of the request is read only by the service.
    fn respond(&self, request: Request<Incoming>, client: Client) -> impl Future<Output = Response<Body>> + Send;
}

/// Server, which ends on drop.
pub struct Server {
    _stop: oneshot::Sender<()>,
}

impl Server {
    /// Serves `listener` on a thread called `name`, beside the task `background`.
    ///
    /// # Errors
    /// Returns an error if the thread cannot be started.
    pub fn start(
        name: &str,
        listener: std::net::TcpListener,
        service: impl Service,
        background: impl Future<Output = ()> + Send + 'static,
    ) -> Result<Self> {
        listener.set_nonblocking(true)?;
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .max_blocking_threads(1)
            .thread_name(name)
            .build()?;
        let listener = {
            let _entered = runtime.enter();
            TcpListener::from_std(listener)?
        };
        let (stop, stopped) = oneshot::channel();
        let serve = move || {
            runtime.block_on(async {
                tokio::spawn(background);
                tokio::select! {
                    // Completes as well when the sender is dropped.
                    _ = stopped => {}
                    () = accept(listener, service) => {}
                }
            });
        };
        std::thread::Builder::new().name(name.to_owned()).spawn(serve)?;
        Ok(Self { _stop: stop })
    }
}

/// Binds the address of the option `option`.
///
/// # Errors
/// Returns an error if the address is not one of this machine, or its port is in use.
pub fn bind(option: &str, address: SocketAddr) -> Result<std::net::TcpListener> {
    std::net::TcpListener::bind(address).with_context(|| {
        format!("{option}: cannot listen on {address}, expected an address of this machine and a free port")
    })
}

/// Returns a response with a text.
pub fn text(status: StatusCode, content_type: &'static str, text: impl Into<Bytes>) -> Response<Body> {
    let mut response = Response::new(Full::new(text.into()).boxed());
    *response.status_mut() = status;
    response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(content_type));
    response
}

/// Returns `true` for a request to an IP address, to `localhost` or to one of the names `hosts`. A request of a foreign page,
/// whose name resolves to this machine (DNS rebinding), has another name.
pub fn is_for_host<T>(request: &Request<T>, hosts: &[String]) -> bool {
    let header = request.headers().get(HOST).and_then(|host| host.to_str().ok());
    let Some(authority) = header.and_then(|host| host.parse::<Authority>().ok()) else { return false };
    let host = authority.host();
    let is_address = host.trim_start_matches('[').trim_end_matches(']').parse::<IpAddr>().is_ok();
    is_address || host.eq_ignore_ascii_case("localhost") || hosts.iter().any(|name| name.eq_ignore_ascii_case(host))
}

/// Client of a request.
#[derive(Clone)]
pub struct Client {
    connection: Arc<Connection>,
    streams: Streams,
}

/// Open event streams, oldest first.
type Streams = Arc<Mutex<VecDeque<Arc<Connection>>>>;

/// State of a connection.
struct Connection {
    is_stream: AtomicBool,
    /// The connection is to be closed.
    closed: Notify,
    /// Time at which the last event was sent.
    sent_at: Mutex<Instant>,
}

impl Connection {
    fn new() -> Self {
        Self { is_stream: AtomicBool::new(false), closed: Notify::new(), sent_at: Mutex::new(Instant::now()) }
    }

    /// Returns the time since the last sent event in units of the interval.
    fn age(&self) -> u128 {
        lock(&self.sent_at).elapsed().as_millis() / STREAM_INTERVAL.as_millis()
    }
}

/// An event stream to a client.
pub struct EventStream {
    sender: Sender<Bytes, Infallible>,
    connection: Arc<Connection>,
    streams: Streams,
}

impl Client {
    /// Opens an event stream: the sender of its events and its response. If there are too many streams, another one ends.
    #[must_use]
    pub fn stream(self) -> (EventStream, Response<Body>) {
        let Self { connection, streams } = self;
        {
            let mut streams = lock(&streams);
            // Among equal ages the first one is the oldest stream.
            let replaced = (0..streams.len()).min_by_key(|i| Reverse(streams.get(*i).map(|stream| stream.age())));
            if streams.len() >= MAX_STREAMS
                && let Some(replaced) = replaced.and_then(|i| streams.remove(i))
            {
                replaced.closed.notify_one();
            }
            streams.push_back(connection.clone());
        }
        connection.is_stream.store(true, Ordering::Relaxed);
        let (sender, body) = Channel::new(1);
        let mut response = Response::new(body.boxed());
        response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("text/event-stream"));
        (EventStream { sender, connection, streams }, response)
    }
}

impl EventStream {
    /// Sends an event; returns `false` if the client has disconnected or does not read within the time limit.
    pub async fn send(&mut self, name: &str, data: &str) -> bool {
        let event = Bytes::from(format!("event: {name}\ndata: {data}\n\n"));
        let is_sent = matches!(tokio::time::timeout(STALL_TIMEOUT, self.sender.send_data(event)).await, Ok(Ok(())));
        if is_sent {
            *lock(&self.connection.sent_at) = Instant::now();
        }
        is_sent
    }
}

impl Drop for EventStream {
    fn drop(&mut self) {
        lock(&self.streams).retain(|stream| !Arc::ptr_eq(stream, &self.connection));
        self.connection.closed.notify_one();
    }
}

/// Accepts clients in an endless loop.
async fn accept(listener: TcpListener, service: impl Service) {
    let streams = Streams::default();
    let mut clients: VecDeque<(AbortHandle, Arc<Connection>)> = VecDeque::new();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(ACCEPT_PAUSE).await;
            continue;
        };
        // An error is ignored: the system's buffer is larger then.
        let _ = SockRef::from(&stream).set_send_buffer_size(SEND_BUFFER);
        clients.retain(|(task, _)| !task.is_finished());
        let is_short = |(_, connection): &(AbortHandle, Arc<Connection>)| !connection.is_stream.load(Ordering::Relaxed);
        if clients.iter().filter(|client| is_short(client)).count() >= MAX_CLIENTS
            && let Some((oldest, _)) = clients.iter().position(is_short).and_then(|at| clients.remove(at))
        {
            // Removed at once: a task that is aborted ends only when it runs again.
            oldest.abort();
        }
        let connection = Arc::new(Connection::new());
        let client = Client { connection: connection.clone(), streams: streams.clone() };
        let task = tokio::spawn(serve_client(stream, service.clone(), client));
        clients.push_back((task.abort_handle(), connection));
    }
}

/// Serves one request.
async fn serve_client(stream: TcpStream, service: impl Service, client: Client) {
    let connection = client.connection.clone();
    let service = hyper::service::service_fn(move |request| {
        let (service, client) = (service.clone(), client.clone());
        async move { Ok::<_, Infallible>(service.respond(request, client).await) }
    });
    let mut builder = hyper::server::conn::http1::Builder::new();
    builder.timer(TokioTimer::new()).header_read_timeout(HEADER_TIMEOUT).max_buf_size(MAX_HEADER_LENGTH);
    let mut served = pin!(builder.keep_alive(false).serve_connection(TokioIo::new(stream), service));
    tokio::select! {
        // An error of one client does not affect the others.
        _ = &mut served => return,
        () = connection.closed.notified() => return,
        () = tokio::time::sleep(CLIENT_TIMEOUT) => {}
    }
    if connection.is_stream.load(Ordering::Relaxed) {
        tokio::select! {
            _ = served => {}
            () = connection.closed.notified() => {}
        }
    }
}
