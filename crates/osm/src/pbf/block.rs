//! A block of elements: a table of strings, and groups of nodes, ways and relations that reference
//! the strings by number.

use std::borrow::Cow;

use openbench_core::LonLat;

use super::wire::{Field, Fields, Numbers, Problem, signed};
use crate::element::{ElementId, ElementKind};
use crate::visitor::{MemberRef, NodeRef, RelationRef, TagRef, TagsRef, Visitor, WayRef};

/// The most text that the elements of a block may hold, as a multiple of the block's size and in
/// any case. Strings are referenced by number, so a few bytes could ask for gigabytes. In real
/// files the factor is one to two.
const TEXT_PER_BYTE: usize = 16;
const TEXT_ALWAYS_BYTES: usize = 1 << 20;

/// What the elements of a block have in common.
struct Block<'a> {
    strings: Vec<Cow<'a, str>>,
    /// The unit of positions and the offsets added to them, nanodegrees.
    granularity: i64,
    lat_offset: i64,
    lon_offset: i64,
}

/// Shows a block's elements to a visitor.
pub(super) fn read(bytes: &[u8], visitor: &mut impl Visitor) -> Result<(), Problem> {
    let block = Block::new(bytes)?;
    let mut reader = Reader {
        block: &block,
        visitor,
        text: bytes
            .len()
            .saturating_mul(TEXT_PER_BYTE)
            .saturating_add(TEXT_ALWAYS_BYTES),
        tags: Vec::new(),
        nodes: Vec::new(),
        members: Vec::new(),
    };
    // Groups may precede the fields that they need.
    for field in Fields(bytes) {
        if let Field { number: 2, value } = field? {
            reader.group(value.bytes()?)?;
        }
    }
    Ok(())
}

/// What ways, relations and single nodes have in common.
#[derive(Default)]
struct Common<'a> {
    id: u64,
    keys: Numbers<'a>,
    values: Numbers<'a>,
    deleted: bool,
}

impl<'a> Common<'a> {
    /// Stores a common field; returns any other field.
    fn take(&mut self, field: Field<'a>) -> Result<Option<Field<'a>>, Problem> {
        let Field { number, value } = field;
        match number {
            1 => self.id = value.number()?,
            2 => self.keys = Numbers(value.bytes()?),
            3 => self.values = Numbers(value.bytes()?),
            4 => self.deleted = is_deleted(value.bytes()?)?,
            _ => return Ok(Some(field)),
        }
        Ok(None)
    }
}

impl<'a> Block<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, Problem> {
        let mut block = Self {
            strings: Vec::new(),
            // The defaults of the format.
            granularity: 100,
            lat_offset: 0,
            lon_offset: 0,
        };
        for field in Fields(bytes) {
            let Field { number, value } = field?;
            match number {
                1 => block.table(value.bytes()?)?,
                17 => block.granularity = value.number()? as i64,
                19 => block.lat_offset = value.number()? as i64,
                20 => block.lon_offset = value.number()? as i64,
                _ => {}
            }
        }
        Ok(block)
    }

    fn table(&mut self, bytes: &'a [u8]) -> Result<(), Problem> {
        for field in Fields(bytes) {
            if let Field { number: 1, value } = field? {
                self.strings.push(String::from_utf8_lossy(value.bytes()?));
            }
        }
        Ok(())
    }

    fn position(&self, lat: i64, lon: i64) -> Result<LonLat, Problem> {
        let lon = self.degrees(lon, self.lon_offset)?;
        let lat = self.degrees(lat, self.lat_offset)?;
        Ok(LonLat::new(lon, lat))
    }

    /// Divided, not multiplied, so that the same position read from XML has the same bits.
    fn degrees(&self, units: i64, offset: i64) -> Result<f64, Problem> {
        // Checked, since a hostile file may give any three numbers.
        let nano = units
            .checked_mul(self.granularity)
            .and_then(|n| n.checked_add(offset));
        nano.map(|n| n as f64 / 1e9)
            .ok_or("a position out of range")
    }
}

/// Reads the elements of a block. Buffers are used again for the next element.
struct Reader<'b, V> {
    block: &'b Block<'b>,
    visitor: &'b mut V,
    /// Bytes of text that elements may still reference.
    text: usize,
    tags: Vec<TagRef<'b>>,
    nodes: Vec<i64>,
    members: Vec<MemberRef<'b>>,
}

impl<V: Visitor> Reader<'_, V> {
    fn group(&mut self, bytes: &[u8]) -> Result<(), Problem> {
        for field in Fields(bytes) {
            let Field { number, value } = field?;
            match number {
                // First, so that groups of other kinds are not even parsed.
                _ if !self.visitor.wants(kind_of_group(number)) => {}
                1 => self.node(value.bytes()?)?,
                2 => self.dense_nodes(value.bytes()?)?,
                3 => self.way(value.bytes()?)?,
                4 => self.relation(value.bytes()?)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn node(&mut self, bytes: &[u8]) -> Result<(), Problem> {
        let (mut common, mut lat, mut lon) = (Common::default(), 0, 0);
        for field in Fields(bytes) {
            match common.take(field?)? {
                Some(Field { number: 8, value }) => lat = signed(value.number()?),
                Some(Field { number: 9, value }) => lon = signed(value.number()?),
                _ => {}
            }
        }
        let (id, position) = (signed(common.id), self.block.position(lat, lon)?);
        if self.read_tags(&common)? {
            self.visitor.node(NodeRef {
                id,
                position,
                tags: TagsRef(&self.tags),
            });
        }
        Ok(())
    }

    fn dense_nodes(&mut self, bytes: &[u8]) -> Result<(), Problem> {
        let [mut ids, mut lats, mut lons, mut tags, mut visible] = [Numbers::default(); 5];
        for field in Fields(bytes) {
            let Field { number, value } = field?;
            match number {
                1 => ids = Numbers(value.bytes()?),
                5 => visible = dense_visible(value.bytes()?)?,
                8 => lats = Numbers(value.bytes()?),
                9 => lons = Numbers(value.bytes()?),
                10 => tags = Numbers(value.bytes()?),
                _ => {}
            }
        }
        let (mut lats, mut lons) = (lats.sums(), lons.sums());
        for id in ids.sums() {
            let (Some(lat), Some(lon)) = (lats.next(), lons.next()) else {
                return Err("nodes without positions");
            };
            let (id, position) = (id?, self.block.position(lat?, lon?)?);
            // Also for deleted nodes, since all rows advance together.
            self.dense_tags(&mut tags)?;
            if visible.next().transpose()? == Some(0) {
                self.visitor.deleted();
            } else {
                self.visitor.node(NodeRef {
                    id,
                    position,
                    tags: TagsRef(&self.tags),
                });
            }
        }
        Ok(())
    }

    /// The tags of the next node: keys and values in turn, up to a 0. The row is empty if no node
    /// has tags.
    fn dense_tags(&mut self, row: &mut Numbers) -> Result<(), Problem> {
        self.tags.clear();
        // String 0 is no key: the format reserves it to end a node's tags.
        while let Some(key) = row.next().transpose()?.filter(|key| *key != 0) {
            let value = row.next().ok_or("a key without a value")??;
            let tag = TagRef {
                key: self.string(key)?,
                value: self.string(value)?,
            };
            self.tags.push(tag);
        }
        Ok(())
    }

    fn way(&mut self, bytes: &[u8]) -> Result<(), Problem> {
        let (mut common, mut references) = (Common::default(), Numbers::default());
        for field in Fields(bytes) {
            if let Some(Field { number: 8, value }) = common.take(field?)? {
                references = Numbers(value.bytes()?);
            }
        }
        self.nodes.clear();
        for node in references.sums() {
            self.nodes.push(node?);
        }
        if self.read_tags(&common)? {
            // Numbers of ways and relations are plain `int64`. Only those of nodes are zigzag
            // coded.
            let id = common.id as i64;
            self.visitor.way(WayRef {
                id,
                nodes: &self.nodes,
                tags: TagsRef(&self.tags),
            });
        }
        Ok(())
    }

    fn relation(&mut self, bytes: &[u8]) -> Result<(), Problem> {
        let mut common = Common::default();
        let [mut roles, mut ids, mut kinds] = [Numbers::default(); 3];
        for field in Fields(bytes) {
            match common.take(field?)? {
                Some(Field { number: 8, value }) => roles = Numbers(value.bytes()?),
                Some(Field { number: 9, value }) => ids = Numbers(value.bytes()?),
                Some(Field { number: 10, value }) => kinds = Numbers(value.bytes()?),
                _ => {}
            }
        }
        self.members.clear();
        for id in ids.sums() {
            let (Some(role), Some(kind)) = (roles.next(), kinds.next()) else {
                // Three rows that must have one entry for each member.
                return Err("a member without a role or a type");
            };
            let element = ElementId {
                kind: kind_of_member(kind?)?,
                id: id?,
            };
            let role = self.string(role?)?;
            self.members.push(MemberRef { element, role });
        }
        if self.read_tags(&common)? {
            self.visitor.relation(RelationRef {
                id: common.id as i64,
                members: &self.members,
                tags: TagsRef(&self.tags),
            });
        }
        Ok(())
    }

    /// Reads the tags of an element, unless it is deleted. Returns whether it is not.
    fn read_tags(&mut self, common: &Common) -> Result<bool, Problem> {
        if common.deleted {
            self.visitor.deleted();
            return Ok(false);
        }
        self.tags.clear();
        let mut values = common.values;
        for key in common.keys {
            let value = values.next().ok_or("a key without a value")??;
            let tag = TagRef {
                key: self.string(key?)?,
                value: self.string(value)?,
            };
            self.tags.push(tag);
        }
        Ok(true)
    }
}

impl<'b, V> Reader<'b, V> {
    fn string(&mut self, number: u64) -> Result<&'b str, Problem> {
        let string = usize::try_from(number)
            .ok()
            .and_then(|i| self.block.strings.get(i));
        let string = string.ok_or("a string that is not in the block's table")?;
        // Each reference counts, because a visitor may copy the text each time.
        self.text = self
            .text
            .checked_sub(string.len())
            .ok_or("the same long strings are referenced too often")?;
        Ok(string)
    }
}

/// Whether an element's information marks it as deleted.
fn is_deleted(info: &[u8]) -> Result<bool, Problem> {
    let mut deleted = false;
    for field in Fields(info) {
        if let Field { number: 6, value } = field? {
            deleted = value.number()? == 0;
        }
    }
    Ok(deleted)
}

/// For each of many nodes whether it is visible; empty if all are.
fn dense_visible(info: &[u8]) -> Result<Numbers<'_>, Problem> {
    let mut visible = Numbers::default();
    for field in Fields(info) {
        if let Field { number: 6, value } = field? {
            visible = Numbers(value.bytes()?);
        }
    }
    Ok(visible)
}

/// The kind of the elements in a field of a group.
fn kind_of_group(field: u64) -> ElementKind {
    match field {
        // 1 are single nodes, 2 are dense ones.
        1 | 2 => ElementKind::Node,
        3 => ElementKind::Way,
        _ => ElementKind::Relation,
    }
}

fn kind_of_member(number: u64) -> Result<ElementKind, Problem> {
    match number {
        0 => Ok(ElementKind::Node),
        1 => Ok(ElementKind::Way),
        2 => Ok(ElementKind::Relation),
        _ => Err("a member of unknown type"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::OsmData;

    /// A field of fewer than 128 bytes.
    fn field(number: u8, bytes: &[u8]) -> Vec<u8> {
        [&[number << 3 | 2, bytes.len() as u8], bytes].concat()
    }

    fn read_all(fields: &[Vec<u8>]) -> Result<OsmData, Problem> {
        let mut data = OsmData::default();
        read(&fields.concat(), &mut data).map(|()| data)
    }

    /// Nodes 1 and 2, the second deleted.
    fn dense() -> Vec<u8> {
        let rows = [
            field(1, &[2, 2]),
            field(8, &[20, 2]),
            field(9, &[40, 2]),
            field(5, &field(6, &[1, 0])),
        ];
        field(2, &field(2, &rows.concat()))
    }

    #[test]
    fn units_and_offsets_apply_wherever_they_are() {
        // Groups first, then a granularity of 1000 and a latitude offset of 1 nanodegree.
        let data = read_all(&[dense(), vec![0x88, 1, 0xE8, 7], vec![0x98, 1, 1]]).unwrap();
        assert_eq!(
            data.nodes[&1].position,
            LonLat::new(20_000.0 / 1e9, 10_001.0 / 1e9)
        );
    }

    #[test]
    fn deleted_elements_are_counted_and_skipped() {
        let gone = field(4, &[0x30, 0]);
        let node = field(
            2,
            &field(1, &[vec![0x08, 6, 0x40, 2, 0x48, 4], gone.clone()].concat()),
        );
        let way = field(2, &field(3, &[vec![0x08, 5], gone].concat()));
        let data = read_all(&[dense(), node, way]).unwrap();
        assert_eq!(
            (
                data.nodes.len(),
                data.ways.len(),
                data.report.deleted_elements
            ),
            (1, 0, 3)
        );
    }

    #[test]
    fn nodes_may_stand_alone() {
        let node = field(2, &field(1, &[0x08, 6, 0x40, 2, 0x48, 4]));
        assert_eq!(
            read_all(&[node]).unwrap().nodes[&3].position,
            LonLat::new(2.0 / 1e7, 1.0 / 1e7)
        );
    }

    #[test]
    fn inconsistent_blocks_are_errors() {
        let without_positions = field(2, &field(2, &field(1, &[2, 2])));
        let unknown_word = field(2, &field(3, &[field(2, &[7]), field(3, &[7])].concat()));
        let no_value = field(2, &field(3, &field(2, &[0])));
        for (block, problem) in [
            (without_positions, "nodes without positions"),
            (unknown_word, "a string that is not in the block's table"),
            (no_value, "a key without a value"),
        ] {
            assert_eq!(read_all(&[block]).unwrap_err(), problem);
        }
    }

    #[test]
    fn a_long_string_cannot_be_referenced_without_limit() {
        let word = vec![b'x'; 1 << 16];
        let long = |number: u8, bytes: &[u8]| {
            let n = bytes.len();
            [
                &[
                    number << 3 | 2,
                    n as u8 | 128,
                    (n >> 7) as u8 | 128,
                    (n >> 14) as u8,
                ],
                bytes,
            ]
            .concat()
        };
        // Ways of two bytes for each reference to the string: 2,000 references are 130 MB.
        let way = field(3, &[field(2, &[0; 50]), field(3, &[0; 50])].concat());
        let block = [long(1, &long(1, &word)), long(2, &way.repeat(20))];
        assert_eq!(
            read_all(&block).unwrap_err(),
            "the same long strings are referenced too often"
        );
    }
}
