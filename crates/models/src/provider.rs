//! The providers whose protocols are known: their own endpoints, and how each takes a key.

/// Whose protocol an endpoint speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Provider {
    /// OpenAI's chat completions, as many other servers speak them.
    OpenAi,
    /// Anthropic's messages.
    Anthropic,
    /// Google's `generateContent`.
    Gemini,
}

/// The header of a request that carries a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct KeyHeader {
    /// Its name, in lower case.
    pub name: &'static str,
    /// What stands before the key in its value.
    pub scheme: &'static str,
}

impl Provider {
    /// The address of the provider's own endpoint, without a slash at its end.
    pub(crate) const fn own_base(self) -> &'static str {
        match self {
            Self::OpenAi => "https://api.openai.com/v1",
            Self::Anthropic => "https://api.anthropic.com",
            Self::Gemini => "https://generativelanguage.googleapis.com",
        }
    }

    /// The environment variable with the key for that endpoint alone.
    pub(crate) const fn key_variable(self) -> &'static str {
        match self {
            Self::OpenAi => "OPENAI_API_KEY",
            Self::Anthropic => "ANTHROPIC_API_KEY",
            Self::Gemini => "GEMINI_API_KEY",
        }
    }

    /// The header in which a key travels.
    pub(crate) const fn key_header(self) -> KeyHeader {
        match self {
            Self::OpenAi => KeyHeader { name: "authorization", scheme: "Bearer " },
            Self::Anthropic => KeyHeader { name: "x-api-key", scheme: "" },
            Self::Gemini => KeyHeader { name: "x-goog-api-key", scheme: "" },
        }
    }
}
