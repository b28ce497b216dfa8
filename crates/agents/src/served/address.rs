//! Addresses of policy servers.

use super::error::ServerError;

/// Where a policy server listens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    scheme: &'static str,
    /// Without the brackets of an IPv6 address.
    pub host: String,
    /// Port.
    pub port: u16,
    /// Beginning with a slash.
    path: String,
}

impl Address {
    /// An address `SCHEME://HOST[:PORT][/PATH]`, for instance `ws://127.0.0.1:8000`.
    ///
    /// # Errors
    /// [`ServerError::Address`], without what may be a password.
    pub fn parse(
        text: &str,
        scheme: &'static str,
        example: &'static str,
    ) -> Result<Self, ServerError> {
        let refuse = |shown: &str, problem| ServerError::Address {
            address: shown.to_owned(),
            problem,
            example,
        };
        let (given, rest) = text.split_once("://").unwrap_or(("", text));
        let (authority, path) = match rest.find('/') {
            Some(slash) => rest.split_at(slash),
            None => (rest, "/"),
        };
        if rest.contains('@') {
            return Err(refuse(
                "SCHEME://…@…",
                "it contains a user name or a password",
            ));
        }
        if rest.contains(['?', '#']) {
            return Err(refuse("SCHEME://…?…", "it contains a query"));
        }
        if matches!(given, "wss" | "https") {
            return Err(refuse(
                text,
                "encrypted connections are not supported: use a tunnel",
            ));
        }
        if given != scheme {
            return Err(refuse(text, "it has another scheme, or none"));
        }
        let is_odd = |c: char| c.is_whitespace() || c.is_control();
        let (host, port) = split_port(authority)
            .filter(|(host, _)| !host.is_empty() && !rest.contains(is_odd))
            .ok_or_else(|| refuse(text, "it has no host, or a port that is none"))?;
        Ok(Self {
            scheme,
            host: host.to_owned(),
            port,
            path: path.to_owned(),
        })
    }

    /// The whole address.
    pub fn url(&self) -> String {
        let Self { scheme, path, .. } = self;
        format!("{scheme}://{}{path}", self.host_and_port())
    }

    /// `HOST:PORT`.
    pub fn host_and_port(&self) -> String {
        let Self { host, port, .. } = self;
        if host.contains(':') {
            format!("[{host}]:{port}")
        } else {
            format!("{host}:{port}")
        }
    }
}

/// Host and port of an authority; port 80 where none is given.
fn split_port(authority: &str) -> Option<(&str, u16)> {
    let (host, port) = match authority.strip_prefix('[') {
        Some(bracketed) => bracketed.split_once(']')?,
        None => match authority.find(':') {
            Some(colon) => authority.split_at(colon),
            None => (authority, ""),
        },
    };
    match port {
        "" => Some((host, 80)),
        port => Some((host, port.strip_prefix(':')?.parse().ok()?)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Address, ServerError> {
        Address::parse(text, "ws", "ws://127.0.0.1:8000")
    }

    #[test]
    fn addresses_come_back_as_they_were_written() {
        for (text, url) in [
            ("ws://127.0.0.1:8000", "ws://127.0.0.1:8000/"),
            ("ws://gpu.local/policy/1", "ws://gpu.local:80/policy/1"),
            ("ws://[::1]:9", "ws://[::1]:9/"),
        ] {
            assert_eq!(parse(text).unwrap().url(), url);
        }
    }

    #[test]
    fn what_is_no_address_is_refused_without_its_password() {
        for text in [
            "",
            "127.0.0.1:8000",
            "http://h:1",
            "wss://h:1",
            "ws://",
            "ws://:80",
            "ws://h:99999",
            "ws://[::1",
            "ws://h/a b",
            "ws://me:secret@h:1",
            "ws://h:1/?key=secret",
            "ws://h:1/p#secret",
        ] {
            let error = parse(text).unwrap_err().to_string();
            assert!(error.contains("ws://127.0.0.1:8000"), "{text}: {error}");
            assert!(!error.contains("secret"), "{error}");
        }
    }
}
