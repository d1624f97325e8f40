//! Where samples come from.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::str::FromStr;

/// A source of samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Address {
    /// A file, in any format of a recording, replayed in its own time.
    File(PathBuf),
    /// A CSV recording that is part of the program, and its name.
    BuiltIn(&'static [u8], &'static str),
    /// Standard input.
    Input,
    /// One connection after another to this address, at which the program listens.
    Tcp(SocketAddr),
    /// Datagrams to this address.
    Udp(SocketAddr),
}

impl Address {
    /// It was recorded before, and is replayed in its own time.
    #[must_use]
    pub const fn is_recording(&self) -> bool {
        matches!(self, Self::File(_) | Self::BuiltIn(..))
    }
}

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            _ if text == "-" => Ok(Self::Input),
            Some(("tcp", place)) => socket(text, place).map(Self::Tcp),
            Some(("udp", place)) => socket(text, place).map(Self::Udp),
            _ => Ok(Self::File(text.into())),
        }
    }
}

/// A port alone is one of this machine only.
fn socket(text: &str, place: &str) -> Result<SocketAddr, String> {
    let port = |text: &str| text.parse().map(|port: u16| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port)).ok();
    port(place)
        .or_else(|| place.parse().ok())
        .ok_or_else(|| format!("found {text:?}, allowed: tcp:PORT, tcp:ADDRESS:PORT, the same with udp, - or a file"))
}

impl std::fmt::Display for Address {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::BuiltIn(_, name) => write!(f, "{name}"),
            Self::Input => write!(f, "standard input"),
            Self::Tcp(place) => write!(f, "tcp:{place}"),
            Self::Udp(place) => write!(f, "udp:{place}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_alone_is_loopback() {
        let address = |text: &str| text.parse::<Address>().map(|a| a.to_string());
        assert_eq!(address("tcp:9000").as_deref(), Ok("tcp:127.0.0.1:9000"));
        assert_eq!(address("udp:0.0.0.0:9000").as_deref(), Ok("udp:0.0.0.0:9000"));
        assert_eq!(address("tcp:[::1]:9000").as_deref(), Ok("tcp:[::1]:9000"));
        assert_eq!(address("-"), Ok("standard input".to_owned()));
        assert_eq!("run.csv".parse(), Ok(Address::File("run.csv".into())));
        assert!(address("tcp:nowhere").is_err_and(|e| e.contains("tcp:nowhere") && e.contains("allowed")));
        assert!(address("udp:").is_err() && address("tcp:99999").is_err());
    }
}
