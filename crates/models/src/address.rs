//! Addresses of endpoints: what is accepted, and which of them stay on this machine.

use std::net::IpAddr;

use crate::error::OpenError;

/// The address without a slash at its end, if it is `http(s)://host[:port]/path`.
///
/// # Errors
/// [`OpenError::BadBase`].
pub(crate) fn checked(base: &str) -> Result<String, OpenError> {
    let base = base.trim_end_matches('/');
    let Some(rest) = base.strip_prefix("https://").or_else(|| base.strip_prefix("http://")) else {
        return Err(bad(base, "it does not begin with http:// or https://"));
    };
    let authority = rest.split(['/', '?', '#']).next().unwrap_or_default();
    if authority.contains('@') {
        // Not shown: what stands before the @ is a password.
        return Err(bad(
            "http(s)://…@…",
            "it holds a user name or password; put the key into OPENBENCH_API_KEY",
        ));
    }
    let has_blank = base.chars().any(|c| c.is_whitespace() || c.is_control());
    if authority.is_empty() || base.contains(['?', '#']) || has_blank {
        return Err(bad(base, "write http(s)://host[:port]/path"));
    }
    Ok(base.to_owned())
}

fn bad(shown: &str, detail: &'static str) -> OpenError {
    OpenError::BadBase { base: shown.to_owned(), detail }
}

/// Whether the host of an address is this machine's loopback interface.
pub(crate) fn is_loopback(base: &str) -> bool {
    let rest = base.split_once("://").map_or(base, |(_, rest)| rest);
    let authority = rest.split('/').next().unwrap_or_default();
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
    fn addresses_lose_the_slash_at_their_end() {
        assert_eq!(checked("https://h:8/v1/").unwrap(), "https://h:8/v1");
    }

    #[test]
    fn bad_addresses_are_refused_without_showing_passwords() {
        for base in ["https://", "https://h?x", "https://u:secret@h/v1", "https://h/a b", "ftp://h"] {
            let error = checked(base).unwrap_err();
            assert!(matches!(error, OpenError::BadBase { .. }), "{base}");
            assert!(!format!("{error} {error:?}").contains("secret"));
        }
    }

    #[test]
    fn loopback_is_told_from_other_hosts() {
        for local in ["http://127.0.0.1:1/v1", "http://localhost/v1", "http://[::1]:1/v1"] {
            assert!(is_loopback(local), "{local}");
        }
        for far in ["http://far.example/v1", "http://127.0.0.1.far.example", "http://[::2]/v1"] {
            assert!(!is_loopback(far), "{far}");
        }
    }
}
