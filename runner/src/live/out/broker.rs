//! Address of an MQTT broker and access to it.

use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use rumqttc::{MqttOptions, Transport};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Maximum length of a message, bytes.
pub const MAX_LENGTH: usize = 1 << 20;
/// Interval of keepalive messages, after one and a half of which the broker publishes the last will.
const KEEP_ALIVE: Duration = Duration::from_secs(10);
/// Environment variable with the password.
const PASSWORD: &str = "BALLRACE_MQTT_PASSWORD";

/// Options of the connections to a broker.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct BrokerArgs {
    /// Publish indicators and events to an MQTT broker: mqtt://HOST:PORT/TOPIC, or mqtts:// with TLS; mqtt://USER@HOST:PORT/TOPIC
    /// with the password in the environment variable BALLRACE_MQTT_PASSWORD or in --mqtt-password-file.
    #[arg(long = "mqtt", value_name = "URL", group = "broker")]
    pub mqtt: Option<String>,
    /// Publish them as an edge node of Sparkplug B: mqtt://HOST:PORT/GROUP/NODE/DEVICE, with TLS and user as --mqtt.
    #[cfg(feature = "sparkplug")]
    #[arg(long, value_name = "URL", group = "broker")]
    pub sparkplug: Option<String>,
    /// Access to the broker.
    #[command(flatten)]
    pub access: Access,
}

/// Certificates and password for a broker.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Access {
    /// Certificates (PEM) of the authorities that sign the broker's certificate; required for mqtts://.
    #[arg(long = "mqtt-ca", value_name = "FILE.pem", requires = "broker")]
    ca: Option<PathBuf>,
    /// File with the password of the MQTT user.
    #[arg(long = "mqtt-password-file", value_name = "FILE", requires = "broker")]
    password_file: Option<PathBuf>,
}

/// Parts of the URL of a broker.
#[derive(Debug, PartialEq, Eq)]
pub struct Url<'a> {
    option: &'static str,
    has_tls: bool,
    user: Option<&'a str>,
    host: &'a str,
    port: u16,
    pub topic: &'a str,
}

impl<'a> Url<'a> {
    /// Parses the URL of an option whose path is `expected`, such as TOPIC.
    ///
    /// # Errors
    /// Returns an error for another URL, or one with a password.
    pub fn parse(option: &'static str, expected: &str, url: &'a str) -> Result<Self> {
        let invalid = || UsageError(format!("{option}: invalid URL: {url:?}, expected mqtt://HOST:PORT/{expected}"));
        let (scheme, rest) = url.split_once("://").with_context(invalid)?;
        let (address, topic) = rest.split_once('/').with_context(invalid)?;
        let (user, address) = address.rsplit_once('@').map_or((None, address), |(user, host)| (Some(user), host));
        let (host, port) = address.rsplit_once(':').with_context(invalid)?;
        let port: u16 = port.parse().map_err(|_| invalid())?;
        if user.is_some_and(|user| user.contains(':')) {
            // The URL is not repeated: other users of the machine can read the messages of the service.
            bail!(UsageError(format!(
                "{option}: the URL has a password, expected it in {PASSWORD} or in --mqtt-password-file"
            )));
        }
        let is_complete = !host.is_empty() && !topic.is_empty() && user != Some("");
        if !matches!(scheme, "mqtt" | "mqtts") || !is_complete || topic.contains(['#', '+', '\0']) {
            bail!(invalid());
        }
        Ok(Self { option, has_tls: scheme == "mqtts", user, host, port, topic })
    }
}

impl Access {
    /// Returns the options of a connection to the broker.
    ///
    /// # Errors
    /// Returns an error if something is missing or a file cannot be read.
    pub fn options(&self, url: &Url) -> Result<MqttOptions> {
        let Url { option, .. } = url;
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let name = format!("ballrace{option}-{}-{:x}", std::process::id(), since_1970.as_nanos());
        let mut options = MqttOptions::new(name, url.host, url.port);
        options.set_keep_alive(KEEP_ALIVE).set_max_packet_size(MAX_LENGTH, MAX_LENGTH);
        match (url.user, self.password()?) {
            (Some(user), Some(password)) => drop(options.set_credentials(user, password)),
            (Some(user), None) => bail!(UsageError(format!(
                "{option}: no password of the user {user:?}, expected it in {PASSWORD} or in --mqtt-password-file"
            ))),
            (None, _) if self.password_file.is_some() => {
                bail!(UsageError("--mqtt-password-file: no user, expected mqtt://USER@HOST:PORT/...".to_owned()))
            }
            (None, _) => {}
        }
        match (&self.ca, url.has_tls) {
            (Some(path), true) => drop(options.set_transport(Transport::tls(certificates(path)?, None, None))),
            (None, false) => {}
            (None, true) => bail!(UsageError(format!(
                "{option}: mqtts:// without --mqtt-ca, expected the certificates of the authorities, such as \
                 /etc/ssl/certs/ca-certificates.crt"
            ))),
            (Some(_), false) => bail!(UsageError("--mqtt-ca: the URL has no TLS, expected mqtts://".to_owned())),
        }
        Ok(options)
    }

    fn password(&self) -> Result<Option<String>> {
        let Some(path) = &self.password_file else { return Ok(std::env::var(PASSWORD).ok()) };
        let text = std::fs::read_to_string(path).with_context(|| unreadable("--mqtt-password-file", path))?;
        Ok(Some(text.trim_end_matches(['\r', '\n']).to_owned()))
    }
}

fn unreadable(option: &str, path: &Path) -> String {
    format!("{option}: {}: this file cannot be read", path.display())
}

fn certificates(path: &Path) -> Result<Vec<u8>> {
    let bytes = std::fs::read(path).with_context(|| unreadable("--mqtt-ca", path))?;
    if !String::from_utf8_lossy(&bytes).contains("-----BEGIN CERTIFICATE-----") {
        bail!(UsageError(format!("--mqtt-ca: {}: no certificate, expected certificates in PEM", path.display())));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn urls_are_parsed() {
        let url = Url {
            option: "--mqtt",
            has_tls: true,
            user: Some("rig"),
            host: "broker.works",
            port: 8883,
            topic: "plant/pump",
        };
        assert_eq!(Url::parse("--mqtt", "TOPIC", "mqtts://rig@broker.works:8883/plant/pump").ok(), Some(url));
        let urls = [
            "localhost:1883/t",
            "mqtt://localhost/t",
            "mqtt://localhost:1883",
            "mqtt://:1/t",
            "mqtt://h:1/a/#",
            "http://h:1/a",
            "mqtt://@h:1/a",
        ];
        for url in urls {
            assert!(
                Url::parse("--mqtt", "TOPIC", url).is_err_and(|e| e.to_string().contains("expected mqtt://")),
                "{url}"
            );
        }
        let error = Url::parse("--mqtt", "TOPIC", "mqtt://rig:secret@h:1/a")
            .map_err(|e| e.to_string())
            .err()
            .unwrap_or_default();
        assert!(error.contains(PASSWORD) && !error.contains("secret"), "{error}");
    }
}
