//! OPC UA server with the indicators of the latest second and the last event, for clients that read and subscribe.

use super::super::http;
use anyhow::{Context, Result, anyhow};
use ballrace_twin::record::{ColumnName, SecondRecord};
use opcua::nodes::Variable;
use opcua::server::diagnostics::NamespaceMetadata;
use opcua::server::node_manager::memory::{SimpleNodeManager, simple_node_manager};
use opcua::server::{ANONYMOUS_USER_TOKEN_ID, ServerBuilder, ServerEndpoint, ServerHandle};
use opcua::types::{DataValue, DateTime, NodeId, QualifiedName, StatusCode};
use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{SystemTime, UNIX_EPOCH};
use tempfile::TempDir;

/// Namespace of the nodes.
const NAMESPACE: &str = "urn:ballrace:monitor";
/// Folder of all nodes.
const FOLDER: &str = "machine";
/// Node of the last event, JSON as in the event log.
const EVENT: &str = "event";

/// OPC UA server on a thread of its own, which ends on drop.
pub struct Server {
    handle: ServerHandle,
    nodes: Arc<SimpleNodeManager>,
    namespace: u16,
    /// Columns that have a node.
    columns: Vec<ColumnName>,
    thread: Option<JoinHandle<()>>,
    /// Folder that the library has for certificates; none are used.
    _certificates: TempDir,
}

impl Server {
    /// Listens on an address.
    ///
    /// # Errors
    /// Returns an error if the port is in use or the library refuses its options.
    pub fn listen(address: SocketAddr) -> Result<Self> {
        let listener = http::bind("--opcua", address)?;
        listener.set_nonblocking(true)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let certificates = tempfile::tempdir()?;
        let metadata = NamespaceMetadata { namespace_uri: NAMESPACE.to_owned(), ..NamespaceMetadata::default() };
        let builder = ServerBuilder::new()
            .application_name("ballrace")
            .application_uri("urn:ballrace")
            .product_uri("urn:ballrace")
            .host(address.ip().to_string())
            .port(address.port())
            .pki_dir(certificates.path())
            .add_endpoint("none", ServerEndpoint::new_none("/", &[ANONYMOUS_USER_TOKEN_ID.to_string()]))
            .discovery_urls(vec!["/".to_owned()])
            .with_node_manager(simple_node_manager(metadata, FOLDER));
        let of_library = |reason: String| anyhow!("--opcua: {reason}");
        let (server, handle) = {
            let _guard = runtime.enter();
            builder.build().map_err(of_library)?
        };
        let missing = || of_library(format!("no namespace {NAMESPACE}"));
        let namespace = handle.get_namespace_index(NAMESPACE).with_context(missing)?;
        let nodes = handle.node_managers().get_of_type::<SimpleNodeManager>().with_context(missing)?;
        let run = move || {
            runtime.block_on(async {
                if let Ok(listener) = tokio::net::TcpListener::from_std(listener) {
                    let _ = server.run_with(listener).await;
                }
            });
        };
        let thread = std::thread::Builder::new().name("opcua".to_owned()).spawn(run)?;
        let server =
            Self { handle, nodes, namespace, columns: vec![], thread: Some(thread), _certificates: certificates };
        let (folder, objects) = (server.id(FOLDER), NodeId::objects_folder_id());
        server.nodes.address_space().write().add_folder(&folder, server.name(FOLDER), FOLDER, &objects);
        server.add(vec![server.variable(EVENT, String::new())]);
        Ok(server)
    }

    fn id(&self, name: &str) -> NodeId {
        NodeId::new(self.namespace, name)
    }

    fn name(&self, name: &str) -> QualifiedName {
        QualifiedName::new(self.namespace, name)
    }

    fn variable(&self, name: &str, value: impl Into<opcua::types::Variant>) -> Variable {
        Variable::new(&self.id(name), self.name(name), name, value)
    }

    /// Adds variables to the folder.
    fn add(&self, variables: Vec<Variable>) {
        self.nodes.address_space().write().add_variables(variables, &self.id(FOLDER));
    }

    /// Sets values and notifies the clients that subscribe to them.
    fn set(&self, values: &[(NodeId, DataValue)]) {
        let values = values.iter().map(|(id, value)| (id, None, value.clone()));
        // Each node was added before.
        let _ = self.nodes.set_values(self.handle.subscriptions(), values);
    }

    /// Publishes the indicators of a second.
    pub fn publish_second(&mut self, record: &SecondRecord) {
        let (columns, values) = record.columns();
        if self.columns != columns {
            let new = columns.iter().filter(|column| !self.columns.contains(column));
            self.add(new.map(|column| self.variable(&column.name, f64::NAN)).collect());
            self.columns = columns;
        }
        let at = date_time(record.at);
        let value = |(column, value): (&ColumnName, f64)| {
            let status = if value.is_finite() { StatusCode::Good } else { StatusCode::BadNoData };
            (self.id(&column.name), DataValue::new_at_status(value, at, status))
        };
        self.set(&self.columns.iter().zip(values).map(value).collect::<Vec<_>>());
    }

    /// Publishes an event, JSON.
    pub fn publish_event(&self, event: String) {
        self.set(&[(self.id(EVENT), DataValue::new_now(event))]);
    }
}

/// Returns a time in the 100 ns since 1601 of OPC UA.
fn date_time(at: SystemTime) -> DateTime {
    /// From 1601 to 1970, ms.
    const TO_1970: i64 = 11_644_473_600_000;
    let since_1970 = at.duration_since(UNIX_EPOCH).unwrap_or_default().as_millis() as i64;
    DateTime::from((TO_1970 + since_1970) * 10_000)
}

impl Drop for Server {
    fn drop(&mut self) {
        self.handle.cancel();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
