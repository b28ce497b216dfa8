//! Reads OSM PBF, the compressed format of regional extracts (crate `osmpbf`).
//!
//! A PBF file is a row of blobs, each with a header that says its kind and size. The framing is checked before any blob is
//! unpacked, so that a cut-off file is told from a whole one. Blob kinds that are not known are passed over, as the
//! format demands; features that are not known are refused, as it demands too.

use std::io::{Cursor, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};

use openbench_core::LonLat;
use osmpbf::{Blob, BlobDecode, BlobReader, Element, HeaderBlock, PrimitiveBlock, RelMemberType};

use crate::data::{ElementKind, Member, Node, OsmData, Relation, Way};
use crate::error::{OsmError, Place};

/// No blob may be larger, says the format.
const LARGEST_BLOB: i32 = 32 << 20;

const KNOWN_FEATURES: [&str; 3] = ["OsmSchema-V0.6", "DenseNodes", "HistoricalInformation"];

/// Whether the bytes begin like PBF: the length of a blob header is below 2^16, so its first two bytes are 0.
pub(crate) fn looks_like_pbf(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0, 0])
}

pub(crate) fn read(bytes: &[u8]) -> Result<OsmData, OsmError> {
    check_framing(bytes)?;
    let mut data = OsmData::default();
    for blob in BlobReader::new_seekable(Cursor::new(bytes)).map_err(|error| at(0, error))? {
        let blob = blob.map_err(|error| at(0, error))?;
        let offset = blob.offset().map_or(0, |offset| offset.0);
        // The decoder panics on a member type that it does not know and, in debug builds, on sums that overflow.
        catch_unwind(AssertUnwindSafe(|| read_blob(&blob, &mut data)))
            .unwrap_or_else(|_| Err("numbers in this block make no sense".into()))
            .map_err(|problem| at(offset, problem))?;
    }
    Ok(data)
}

fn at(offset: u64, problem: impl ToString) -> OsmError {
    OsmError::malformed(Place::Byte(offset as usize), problem.to_string())
}

/// Walks from header to header: the last blob must end where the bytes end.
fn check_framing(bytes: &[u8]) -> Result<(), OsmError> {
    let length = bytes.len() as u64;
    let mut reader = BlobReader::new_seekable(Cursor::new(bytes)).map_err(|error| at(0, error))?;
    let mut position = 0;
    while position < length {
        let header = match reader.next_header_skip_blob() {
            Some(Ok((header, _))) => header,
            Some(Err(error)) => return Err(at(position, error)),
            None => {
                return Err(at(
                    position,
                    "the file ends within a blob header; it is cut off, fetch it again",
                ));
            }
        };
        if !(0..=LARGEST_BLOB).contains(&header.get_blob_size()) {
            return Err(at(position, "a blob of impossible size; this is not OSM PBF or it is damaged"));
        }
        let start = position;
        position = reader.seek_raw(SeekFrom::Current(0)).map_err(|error| at(start, error))?;
        if position > length {
            return Err(at(start, "the file ends within this blob; it is cut off, fetch it again"));
        }
    }
    Ok(())
}

fn read_blob(blob: &Blob, data: &mut OsmData) -> Result<(), String> {
    match blob.decode().map_err(|error| error.to_string())? {
        BlobDecode::OsmHeader(header) => check_features(&header),
        BlobDecode::OsmData(block) => {
            read_block(&block, data);
            Ok(())
        }
        BlobDecode::Unknown(_) => Ok(()),
    }
}

fn check_features(header: &HeaderBlock) -> Result<(), String> {
    match header.required_features().iter().find(|feature| !KNOWN_FEATURES.contains(&feature.as_str())) {
        Some(feature) => Err(format!("the file needs the feature {feature}, which is not supported")),
        None => Ok(()),
    }
}

fn read_block(block: &PrimitiveBlock, data: &mut OsmData) {
    block.for_each_element(|element| match element {
        Element::DenseNode(node) if node.info().is_some_and(|info| info.deleted()) => {
            data.report.deleted_elements += 1;
        }
        Element::Node(node) if node.info().deleted() => data.report.deleted_elements += 1,
        Element::Way(way) if way.info().deleted() => data.report.deleted_elements += 1,
        Element::Relation(relation) if relation.info().deleted() => data.report.deleted_elements += 1,
        Element::DenseNode(node) => {
            let position = position(node.nano_lon(), node.nano_lat());
            data.put_node(Node { id: node.id(), position, tags: node.tags().collect() });
        }
        Element::Node(node) => {
            let position = position(node.nano_lon(), node.nano_lat());
            data.put_node(Node { id: node.id(), position, tags: node.tags().collect() });
        }
        Element::Way(way) => {
            data.put_way(Way { id: way.id(), nodes: way.refs().collect(), tags: way.tags().collect() });
        }
        Element::Relation(relation) => read_relation(&relation, data),
    });
}

fn read_relation(relation: &osmpbf::Relation<'_>, data: &mut OsmData) {
    let member = |m: osmpbf::RelMember<'_>| Member {
        kind: match m.member_type {
            RelMemberType::Node => ElementKind::Node,
            RelMemberType::Way => ElementKind::Way,
            RelMemberType::Relation => ElementKind::Relation,
        },
        id: m.member_id,
        role: m.role().unwrap_or_default().to_owned(),
    };
    let members = relation.members().map(member).collect();
    data.put_relation(Relation { id: relation.id(), members, tags: relation.tags().collect() });
}

/// Divided, not multiplied, so that the same place read from XML has the same bits.
fn position(nano_lon: i64, nano_lat: i64) -> LonLat {
    LonLat::new(nano_lon as f64 / 1e9, nano_lat as f64 / 1e9)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One blob with a header block that asks for `feature`, uncompressed, built by hand after the format's definition.
    fn header_blob(feature: &str) -> Vec<u8> {
        let field = |tag: u8, bytes: &[u8]| [&[tag, bytes.len() as u8], bytes].concat();
        let blob = field(0x0A, &field(0x22, feature.as_bytes()));
        let header = [field(0x0A, b"OSMHeader"), vec![0x18, blob.len() as u8]].concat();
        [&(header.len() as u32).to_be_bytes(), header.as_slice(), &blob].concat()
    }

    #[test]
    fn a_file_with_a_header_alone_is_an_empty_map() {
        let data = OsmData::from_bytes(&header_blob("DenseNodes")).unwrap();
        assert!(data.nodes.is_empty());
    }

    #[test]
    fn an_unknown_feature_is_refused_by_name() {
        let error = OsmData::from_bytes(&header_blob("LocationsOnMars")).unwrap_err().to_string();
        assert_eq!(error, "byte 0: the file needs the feature LocationsOnMars, which is not supported");
    }

    #[test]
    fn every_cut_of_a_file_is_noticed() {
        let whole = header_blob("DenseNodes");
        for length in 1..whole.len() {
            assert!(OsmData::from_pbf(&whole[..length]).is_err(), "cut to {length} bytes");
        }
    }

    #[test]
    fn a_negative_blob_size_does_not_loop() {
        // Size -1 as a ten-byte varint.
        let header = [&[0x0A, 9], b"OSMHeader".as_slice(), &[0x18], &[0xFF; 9], &[1]].concat();
        let bytes = [&(header.len() as u32).to_be_bytes(), header.as_slice()].concat();
        assert!(OsmData::from_pbf(&bytes).unwrap_err().to_string().contains("impossible size"));
    }
}
