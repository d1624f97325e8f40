//! Access to the live page: host names against DNS rebinding, origins of other pages, and the token.

use super::HttpOptions;
use crate::error::UsageError;
use crate::live::address::parse_local;
use crate::live::http::is_for_host;
use anyhow::{Context, Result, bail};
use ballrace_twin::scene::bounded::read_text;
use hyper::Request;
use hyper::header::{AUTHORIZATION, HeaderValue};
use hyper::http::Uri;
use std::net::SocketAddr;
use subtle::ConstantTimeEq;

/// Least length of a token.
const MIN_TOKEN_LENGTH: usize = 8;
/// Largest length of the file of a token, bytes.
const MAX_TOKEN_LENGTH: u64 = 4096;

/// Access rules of the page.
pub struct Access {
    hosts: Vec<String>,
    origins: Vec<String>,
    token: Option<String>,
}

impl Access {
    /// Reads the token.
    ///
    /// # Errors
    /// Returns an error if the file of the token cannot be read, or its token is too short.
    pub fn try_new(options: &HttpOptions) -> Result<Self> {
        let token = match &options.token_file {
            Some(file) => {
                let text = read_text(file, MAX_TOKEN_LENGTH)
                    .with_context(|| format!("--http-token-file: {}", file.display()))?;
                let token = text.trim().to_owned();
                if token.len() < MIN_TOKEN_LENGTH || !token.bytes().all(|byte| byte.is_ascii_graphic()) {
                    bail!(UsageError(format!(
                        "--http-token-file: {}: no token, expected one line of at least {MIN_TOKEN_LENGTH} letters and digits",
                        file.display()
                    )));
                }
                Some(token)
            }
            None => None,
        };
        Ok(Self { hosts: options.hosts.clone(), origins: options.origins.clone(), token })
    }

    /// Returns `true` if users may acknowledge alarms.
    pub const fn has_token(&self) -> bool {
        self.token.is_some()
    }

    /// Returns `true` for a request that [`is_for_host`] accepts with the names of `--http-host`.
    pub fn allows_host<T>(&self, request: &Request<T>) -> bool {
        is_for_host(request, &self.hosts)
    }

    /// Returns `true` for the origin of a page that may show this machine.
    pub fn allows_origin(&self, origin: &HeaderValue) -> bool {
        self.origins.iter().any(|allowed| allowed.as_bytes() == origin.as_bytes())
    }

    /// Returns `true` if the request has the token. The time of the comparison does not depend on the token.
    pub fn has_valid_token<T>(&self, request: &Request<T>) -> bool {
        let header = request.headers().get(AUTHORIZATION).map(HeaderValue::as_bytes);
        let given = header.and_then(|header| header.strip_prefix(b"Bearer "));
        match (&self.token, given) {
            (Some(token), Some(given)) => token.as_bytes().ct_eq(given).into(),
            _ => false,
        }
    }
}

/// Parses the address of the page.
pub fn parse_address(text: &str) -> Result<SocketAddr, String> {
    parse_local(text).ok_or_else(|| "expected PORT or ADDRESS:PORT, such as 127.0.0.1:8080".to_owned())
}

/// Parses the origin of a page: scheme, host and port.
pub fn parse_origin(text: &str) -> Result<String, String> {
    let expected = || "expected a URL without a path, such as http://127.0.0.1:8082".to_owned();
    let uri: Uri = text.parse().map_err(|_| expected())?;
    let is_web = matches!(uri.scheme_str(), Some("http" | "https"));
    match uri.authority() {
        Some(authority)
            if is_web && uri.path() == "/" && uri.query().is_none() && !authority.as_str().contains('@') =>
        {
            Ok(format!("{}://{authority}", uri.scheme_str().unwrap_or_default()))
        }
        _ => Err(expected()),
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use hyper::header::HOST;

    fn access() -> Access {
        let names = |name: &str| vec![name.to_owned()];
        Access { hosts: names("rig.plant"), origins: names("http://a:1"), token: Some("secret-token".to_owned()) }
    }

    fn request(name: hyper::header::HeaderName, value: &str) -> Request<()> {
        Request::builder().header(name, value).body(()).unwrap()
    }

    #[test]
    fn hosts_are_addresses_localhost_and_allowed_names() {
        for host in ["127.0.0.1:80", "[::1]:8080", "localhost:1", "LOCALHOST", "10.0.0.7", "rig.plant", "Rig.Plant:80"]
        {
            assert!(access().allows_host(&request(HOST, host)), "{host}");
        }
        for host in ["evil.example", "127.0.0.1.evil.example", "rig.plant.evil.example:80", "", "a b", "localhost@x.y"]
        {
            assert!(!access().allows_host(&request(HOST, host)), "{host}");
        }
        assert!(!access().allows_host(&Request::builder().body(()).unwrap()));
    }

    #[test]
    fn the_token_is_the_whole_token() {
        assert!(access().has_valid_token(&request(AUTHORIZATION, "Bearer secret-token")));
        for given in ["Bearer secret-toke", "Bearer secret-token1", "Bearer ", "secret-token", "Basic secret-token"] {
            assert!(!access().has_valid_token(&request(AUTHORIZATION, given)), "{given}");
        }
        let read_only = Access { token: None, ..access() };
        assert!(!read_only.has_valid_token(&request(AUTHORIZATION, "Bearer ")));
    }

    #[test]
    fn origins_have_no_path() {
        assert_eq!(parse_origin("http://127.0.0.1:8082/").as_deref(), Ok("http://127.0.0.1:8082"));
        assert_eq!(parse_origin("https://rig.plant").as_deref(), Ok("https://rig.plant"));
        for text in
            ["127.0.0.1:8082", "ftp://a", "http://a/b", "http://a?x", "http://u@a", "*", "http://a; script-src *"]
        {
            assert!(parse_origin(text).is_err(), "{text}");
        }
        assert!(parse_address("8080").is_ok_and(|address| address.ip().is_loopback()));
        assert!(parse_address("0.0.0.0:1").is_ok() && parse_address("name:1").is_err());
    }
}
