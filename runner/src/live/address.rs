//! Addresses of sample sources.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::str::FromStr;

/// Name of the simulated demonstration.
pub const DEMONSTRATION: &str = "demonstration";

/// A source of samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Address {
    /// File in any recording format, replayed at its own rate.
    File(PathBuf),
    /// Endless simulation of the demonstration's machine with a spall.
    Demonstration,
    /// CSV recording that is part of the program, and its name.
    BuiltIn(&'static [u8], &'static str),
    /// Standard input.
    StandardInput,
    /// TCP connections to this local address, one after the other.
    Tcp(SocketAddr),
    /// UDP datagrams to this local address.
    Udp(SocketAddr),
}

impl Address {
    /// Returns `true` for a recording, which is replayed at its own rate.
    #[must_use]
    pub const fn is_recording(&self) -> bool {
        matches!(self, Self::File(_) | Self::BuiltIn(..) | Self::Demonstration)
    }
}

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            _ if text == "-" => Ok(Self::StandardInput),
            _ if text == DEMONSTRATION => Ok(Self::Demonstration),
            Some(("tcp", address)) => parse_socket(address).map(Self::Tcp),
            Some(("udp", address)) => parse_socket(address).map(Self::Udp),
            _ => Ok(Self::File(text.into())),
        }
    }
}

fn parse_socket(text: &str) -> Result<SocketAddr, String> {
    parse_local(text).ok_or_else(|| {
        "expected tcp:PORT, tcp:ADDRESS:PORT, udp:PORT, udp:ADDRESS:PORT, - or the name of a file".to_owned()
    })
}

/// Parses `PORT` or `ADDRESS:PORT`. A port without an address is a port of the loopback interface.
#[must_use]
pub fn parse_local(text: &str) -> Option<SocketAddr> {
    let loopback = |port: u16| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port);
    text.parse().map(loopback).ok().or_else(|| text.parse().ok())
}

impl std::fmt::Display for Address {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Demonstration => write!(f, "{DEMONSTRATION} (simulated)"),
            Self::BuiltIn(_, name) => write!(f, "{name}"),
            Self::StandardInput => write!(f, "standard input"),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Udp(address) => write!(f, "udp:{address}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_without_address_is_loopback() {
        let address = |text: &str| text.parse::<Address>().map(|a| a.to_string());
        assert_eq!(address("tcp:9000").as_deref(), Ok("tcp:127.0.0.1:9000"));
        assert_eq!(address("udp:0.0.0.0:9000").as_deref(), Ok("udp:0.0.0.0:9000"));
        assert_eq!(address("tcp:[::1]:9000").as_deref(), Ok("tcp:[::1]:9000"));
        assert_eq!(address("-"), Ok("standard input".to_owned()));
        assert_eq!("run.csv".parse(), Ok(Address::File("run.csv".into())));
        assert!(address("tcp:nowhere").is_err_and(|e| e.contains("expected tcp:PORT")));
        assert!(address("udp:").is_err() && address("tcp:99999").is_err());
    }
}
