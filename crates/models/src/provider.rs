//! Providers of chat models: their own endpoints and how requests carry a key.

/// A protocol of chat models, by the provider that defines it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Provider {
    /// OpenAI's chat completions, which many other servers implement.
    OpenAi,
    /// Anthropic's messages.
    Anthropic,
    /// Google's `generateContent`.
    Gemini,
}

/// The header of a request that carries a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct KeyHeader {
    /// Name of the header, in lower case.
    pub name: &'static str,
    /// Prefix of the key in its value.
    pub scheme: &'static str,
}

impl Provider {
    /// The address of the provider's own endpoint, without trailing slash.
    pub(crate) const fn own_base(self) -> &'static str {
        match self {
            Self::OpenAi => "https://api.openai.com/v1",
            Self::Anthropic => "https://api.anthropic.com",
            Self::Gemini => "https://generativelanguage.googleapis.com",
        }
    }

    /// The environment variable of the key for that endpoint only.
    pub(crate) const fn key_variable(self) -> &'static str {
        match self {
            Self::OpenAi => "OPENAI_API_KEY",
            Self::Anthropic => "ANTHROPIC_API_KEY",
            Self::Gemini => "GEMINI_API_KEY",
        }
    }

    /// The header that carries the key.
    pub(crate) const fn key_header(self) -> KeyHeader {
        match self {
            Self::OpenAi => KeyHeader {
                name: "authorization",
                scheme: "Bearer ",
            },
            Self::Anthropic => KeyHeader {
                name: "x-api-key",
                scheme: "",
            },
            Self::Gemini => KeyHeader {
                name: "x-goog-api-key",
                scheme: "",
            },
        }
    }
}
