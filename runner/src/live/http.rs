//! HTTP server with bounded clients, on a thread of its own.
//!
//! A header, a request and its response are bounded in size and time. Event streams have no time limit, but their number is
//! bounded, and a client that does not read its stream is disconnected.

use anyhow::{Context, Result};
use http_body_util::channel::{Channel, Sender};
use http_body_util::combinators::BoxBody;
use http_body_util::{BodyExt, Full};
use hyper::body::{Bytes, Incoming};
use hyper::header::{CONTENT_TYPE, HOST, HeaderValue};
use hyper::http::uri::Authority;
use hyper::{Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr};
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Notify, oneshot};
use tokio::task::AbortHandle;

/// Maximum number of clients besides event streams; a further client replaces the oldest one.
const MAX_CLIENTS: usize = 32;
/// Maximum number of event streams; a further one is refused.
pub const MAX_STREAMS: usize = 32;
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
    streams: Arc<AtomicUsize>,
}

/// State of a connection.
#[derive(Default)]
struct Connection {
    is_stream: AtomicBool,
    stalled: Notify,
}

/// An event stream to a client.
pub struct EventStream {
    sender: Sender<Bytes, Infallible>,
    connection: Arc<Connection>,
    streams: Arc<AtomicUsize>,
}

impl Client {
    /// Opens an event stream: the sender of its events and its response; `None` if there are too many streams.
    #[must_use]
    pub fn stream(self) -> Option<(EventStream, Response<Body>)> {
        let Self { connection, streams } = self;
        let increment = |count| (count < MAX_STREAMS).then_some(count + 1);
        streams.fetch_update(Ordering::Relaxed, Ordering::Relaxed, increment).ok()?;
        connection.is_stream.store(true, Ordering::Relaxed);
        let (sender, body) = Channel::new(1);
        let mut response = Response::new(body.boxed());
        response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("text/event-stream"));
        Some((EventStream { sender, connection, streams }, response))
    }
}

impl EventStream {
    /// Sends an event; returns `false` if the client has disconnected or does not read within the time limit.
    pub async fn send(&mut self, name: &str, data: &str) -> bool {
        let event = Bytes::from(format!("event: {name}\ndata: {data}\n\n"));
        matches!(tokio::time::timeout(STALL_TIMEOUT, self.sender.send_data(event)).await, Ok(Ok(())))
    }
}

impl Drop for EventStream {
    fn drop(&mut self) {
        self.streams.fetch_sub(1, Ordering::Relaxed);
        self.connection.stalled.notify_one();
    }
}

/// Accepts clients in an endless loop.
async fn accept(listener: TcpListener, service: impl Service) {
    let streams = Arc::new(AtomicUsize::new(0));
    let mut clients: VecDeque<(AbortHandle, Arc<Connection>)> = VecDeque::new();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(ACCEPT_PAUSE).await;
            continue;
        };
        clients.retain(|(task, _)| !task.is_finished());
        let is_short = |(_, connection): &(AbortHandle, Arc<Connection>)| !connection.is_stream.load(Ordering::Relaxed);
        if clients.iter().filter(|client| is_short(client)).count() >= MAX_CLIENTS
            && let Some((oldest, _)) = clients.iter().position(is_short).and_then(|at| clients.remove(at))
        {
            // Removed at once: a task that is aborted ends only when it runs again.
            oldest.abort();
        }
        let connection = Arc::new(Connection::default());
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
        () = tokio::time::sleep(CLIENT_TIMEOUT) => {}
    }
    if connection.is_stream.load(Ordering::Relaxed) {
        tokio::select! {
            _ = served => {}
            () = connection.stalled.notified() => {}
        }
    }
}
