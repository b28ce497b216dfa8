//! Addresses of endpoints: validation, and which of them are on this machine.

use std::net::IpAddr;

use crate::error::OpenError;

/// Checks that an address has the form `http(s)://host[:port]/path`; removes trailing slashes.
///
/// # Errors
/// [`OpenError::BadBase`].
pub(crate) fn checked(base: &str) -> Result<String, OpenError> {
    let base = base.trim_end_matches('/');
    let (scheme, rest) = base.split_once("://").unwrap_or(("", base));
    // The authority ends at the first of these. An `@` behind it, in a path, is no password.
    let authority = rest.split(['/', '?', '#']).next().unwrap_or_default();
    if authority.contains('@') {
        // Not shown: the part in front of the @ is a password.
        return Err(bad(
            "http(s)://…@…",
            "it contains a user name or password; set OPENBENCH_API_KEY to the key",
        ));
    }
    // A query is not shown: it may contain a key.
    let shown = base.split(['?', '#']).next().unwrap_or_default();
    if !matches!(scheme, "http" | "https") {
        return Err(bad(shown, "it does not begin with http:// or https://"));
    }
    let has_blank = base.chars().any(|c| c.is_whitespace() || c.is_control());
    if authority.is_empty() || base.contains(['?', '#']) || has_blank {
        return Err(bad(shown, "write http(s)://host[:port]/path"));
    }
    Ok(base.to_owned())
}

fn bad(shown: &str, detail: &'static str) -> OpenError {
    OpenError::BadBase {
        base: shown.to_owned(),
        detail,
    }
}

/// Whether the host of an address is the loopback interface of this machine.
pub(crate) fn is_loopback(base: &str) -> bool {
    let rest = base.split_once("://").map_or(base, |(_, rest)| rest);
    // The address is `checked`, so no `@`, `?` or `#` can disguise the host.
    let authority = rest.split('/').next().unwrap_or_default();
    // IPv6 addresses stand in brackets, since they contain colons themselves.
    let host = match authority.strip_prefix('[') {
        Some(bracketed) => bracketed.split(']').next().unwrap_or_default(),
        None => authority.split(':').next().unwrap_or_default(),
    };
    host == "localhost" || host.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trailing_slashes_are_removed() {
        assert_eq!(checked("https://h:8/v1/").unwrap(), "https://h:8/v1");
    }

    #[test]
    fn invalid_addresses_are_refused_without_their_secrets() {
        for base in [
            "https://",
            "https://h?key=secret",
            "https://h/v1#secret",
            "https://u:secret@h/v1",
            "u:secret@h/v1",
            "ftp://u:secret@h",
            "https://h/a b",
            "ftp://h",
        ] {
            let error = checked(base).unwrap_err();
            assert!(matches!(error, OpenError::BadBase { .. }), "{base}");
            assert!(!format!("{error} {error:?}").contains("secret"));
        }
    }

    #[test]
    fn loopback_addresses_are_recognized() {
        for local in [
            "http://127.0.0.1:1/v1",
            "http://localhost/v1",
            "http://[::1]:1/v1",
        ] {
            assert!(is_loopback(local), "{local}");
        }
        for far in [
            "http://far.example/v1",
            "http://127.0.0.1.far.example",
            "http://[::2]/v1",
        ] {
            assert!(!is_loopback(far), "{far}");
        }
    }
}
