//! A block of elements: a table of strings, and groups of nodes, ways and relations that name them by number.

use openbench_core::LonLat;

use super::wire::{Fields, Numbers, Problem, Value, signed};
use crate::data::{ElementKind, Member, Node, OsmData, Relation, Way};
use crate::tags::Tags;

/// So much text may the elements of a block hold for each of its bytes, and so much in any case. They name strings by number, so
/// that a few bytes could ask for gigabytes; in real files it is one to two times.
const TEXT: (usize, usize) = (16, 1 << 20);

/// A block that is being read.
struct Block<'a> {
    strings: Vec<&'a [u8]>,
    /// Units of positions, and what is added to them, nanodegrees.
    granularity: i64,
    lat_offset: i64,
    lon_offset: i64,
    /// Bytes of text that elements may still take.
    text: usize,
}

/// Puts a block's elements into `data`.
pub(super) fn read(bytes: &[u8], data: &mut OsmData) -> Result<(), Problem> {
    let text = bytes.len().saturating_mul(TEXT.0).saturating_add(TEXT.1);
    let mut block = Block { strings: Vec::new(), granularity: 100, lat_offset: 0, lon_offset: 0, text };
    for field in Fields(bytes) {
        match field? {
            (1, table) => block.table(table.bytes()?)?,
            (17, value) => block.granularity = value.number()? as i64,
            (19, value) => block.lat_offset = value.number()? as i64,
            (20, value) => block.lon_offset = value.number()? as i64,
            _ => {}
        }
    }
    // Groups may stand before what they need.
    for field in Fields(bytes) {
        if let (2, group) = field? {
            block.group(group.bytes()?, data)?;
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
    /// Takes a field in; gives it back if it is none of the common ones.
    fn take(&mut self, field: (u64, Value<'a>)) -> Result<Option<(u64, Value<'a>)>, Problem> {
        match field {
            (1, id) => self.id = id.number()?,
            (2, keys) => self.keys = Numbers(keys.bytes()?),
            (3, values) => self.values = Numbers(values.bytes()?),
            (4, info) => self.deleted = is_deleted(info.bytes()?)?,
            other => return Ok(Some(other)),
        }
        Ok(None)
    }
}

impl<'a> Block<'a> {
    fn table(&mut self, bytes: &'a [u8]) -> Result<(), Problem> {
        for field in Fields(bytes) {
            if let (1, string) = field? {
                self.strings.push(string.bytes()?);
            }
        }
        Ok(())
    }

    fn group(&mut self, bytes: &'a [u8], data: &mut OsmData) -> Result<(), Problem> {
        for field in Fields(bytes) {
            match field? {
                (1, node) => self.node(node.bytes()?, data)?,
                (2, nodes) => self.dense_nodes(nodes.bytes()?, data)?,
                (3, way) => self.way(way.bytes()?, data)?,
                (4, relation) => self.relation(relation.bytes()?, data)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn node(&mut self, bytes: &'a [u8], data: &mut OsmData) -> Result<(), Problem> {
        let (mut common, mut lat, mut lon) = (Common::default(), 0, 0);
        for field in Fields(bytes) {
            match common.take(field?)? {
                Some((8, value)) => lat = signed(value.number()?),
                Some((9, value)) => lon = signed(value.number()?),
                _ => {}
            }
        }
        let (id, position) = (signed(common.id), self.position(lat, lon)?);
        if let Some(tags) = self.tags(common, data)? {
            data.put_node(Node { id, position, tags });
        }
        Ok(())
    }

    fn dense_nodes(&mut self, bytes: &'a [u8], data: &mut OsmData) -> Result<(), Problem> {
        let [mut ids, mut lats, mut lons, mut tags, mut visible] = [Numbers::default(); 5];
        for field in Fields(bytes) {
            match field? {
                (1, row) => ids = Numbers(row.bytes()?),
                (5, info) => visible = dense_visible(info.bytes()?)?,
                (8, row) => lats = Numbers(row.bytes()?),
                (9, row) => lons = Numbers(row.bytes()?),
                (10, row) => tags = Numbers(row.bytes()?),
                _ => {}
            }
        }
        let (mut lats, mut lons) = (lats.sums(), lons.sums());
        for id in ids.sums() {
            let (Some(lat), Some(lon)) = (lats.next(), lons.next()) else {
                return Err("nodes without positions");
            };
            let (id, position) = (id?, self.position(lat?, lon?)?);
            let tags = self.dense_tags(&mut tags)?;
            if visible.next().transpose()? == Some(0) {
                data.report.deleted_elements += 1;
            } else {
                data.put_node(Node { id, position, tags });
            }
        }
        Ok(())
    }

    /// The tags of the next node: keys and values in turn up to a 0. Without any tags the row is empty.
    fn dense_tags(&mut self, row: &mut Numbers) -> Result<Tags, Problem> {
        let mut tags = Vec::new();
        while let Some(key) = row.next().transpose()?.filter(|key| *key != 0) {
            let value = row.next().ok_or("a key without a value")??;
            tags.push((self.string(key)?, self.string(value)?));
        }
        Ok(tags.into_iter().collect())
    }

    fn way(&mut self, bytes: &'a [u8], data: &mut OsmData) -> Result<(), Problem> {
        let (mut common, mut references) = (Common::default(), Numbers::default());
        for field in Fields(bytes) {
            if let Some((8, row)) = common.take(field?)? {
                references = Numbers(row.bytes()?);
            }
        }
        let (id, nodes) = (common.id as i64, references.sums().collect::<Result<_, _>>()?);
        if let Some(tags) = self.tags(common, data)? {
            data.put_way(Way { id, nodes, tags });
        }
        Ok(())
    }

    fn relation(&mut self, bytes: &'a [u8], data: &mut OsmData) -> Result<(), Problem> {
        let mut common = Common::default();
        let [mut roles, mut ids, mut kinds] = [Numbers::default(); 3];
        for field in Fields(bytes) {
            match common.take(field?)? {
                Some((8, row)) => roles = Numbers(row.bytes()?),
                Some((9, row)) => ids = Numbers(row.bytes()?),
                Some((10, row)) => kinds = Numbers(row.bytes()?),
                _ => {}
            }
        }
        let mut members = Vec::new();
        for id in ids.sums() {
            let (Some(role), Some(kind)) = (roles.next(), kinds.next()) else {
                return Err("a member without a role or a type");
            };
            members.push(Member { kind: kind_of(kind?)?, id: id?, role: self.string(role?)? });
        }
        let id = common.id as i64;
        if let Some(tags) = self.tags(common, data)? {
            data.put_relation(Relation { id, members, tags });
        }
        Ok(())
    }

    /// The tags of an element that is not deleted; one that is is counted.
    fn tags(&mut self, common: Common, data: &mut OsmData) -> Result<Option<Tags>, Problem> {
        if common.deleted {
            data.report.deleted_elements += 1;
            return Ok(None);
        }
        let (mut tags, mut values) = (Vec::new(), common.values);
        for key in common.keys {
            let value = values.next().ok_or("a key without a value")??;
            tags.push((self.string(key?)?, self.string(value)?));
        }
        Ok(Some(tags.into_iter().collect()))
    }

    fn string(&mut self, number: u64) -> Result<String, Problem> {
        let string = usize::try_from(number).ok().and_then(|i| self.strings.get(i));
        let string = string.ok_or("a word that is not in the block's table")?;
        self.text = self.text.checked_sub(string.len()).ok_or("the same long words again and again")?;
        Ok(String::from_utf8_lossy(string).into_owned())
    }

    /// Divided, not multiplied, so that the same place read from XML has the same bits.
    fn position(&self, lat: i64, lon: i64) -> Result<LonLat, Problem> {
        let degrees = |units: i64, offset: i64| {
            let nano = units.checked_mul(self.granularity).and_then(|n| n.checked_add(offset));
            nano.map(|n| n as f64 / 1e9).ok_or("a position that makes no sense")
        };
        Ok(LonLat::new(degrees(lon, self.lon_offset)?, degrees(lat, self.lat_offset)?))
    }
}

/// Whether an element's information says that it is deleted.
fn is_deleted(info: &[u8]) -> Result<bool, Problem> {
    let mut deleted = false;
    for field in Fields(info) {
        if let (6, visible) = field? {
            deleted = visible.number()? == 0;
        }
    }
    Ok(deleted)
}

/// For each of many nodes whether it is there; nothing where all are.
fn dense_visible(info: &[u8]) -> Result<Numbers<'_>, Problem> {
    let mut visible = Numbers::default();
    for field in Fields(info) {
        if let (6, row) = field? {
            visible = Numbers(row.bytes()?);
        }
    }
    Ok(visible)
}

fn kind_of(number: u64) -> Result<ElementKind, Problem> {
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

    /// A field of bytes, shorter than 128.
    fn field(number: u8, bytes: &[u8]) -> Vec<u8> {
        [&[number << 3 | 2, bytes.len() as u8], bytes].concat()
    }

    fn read_all(fields: &[Vec<u8>]) -> Result<OsmData, Problem> {
        let mut data = OsmData::default();
        read(&fields.concat(), &mut data).map(|()| data)
    }

    /// Nodes 1 and 2, the second deleted.
    fn dense() -> Vec<u8> {
        let rows = [field(1, &[2, 2]), field(8, &[20, 2]), field(9, &[40, 2]), field(5, &field(6, &[1, 0]))];
        field(2, &field(2, &rows.concat()))
    }

    #[test]
    fn units_and_offsets_hold_wherever_they_stand() {
        // Groups first; then a granularity of 1000 and a latitude's offset of 1 nanodegree.
        let data = read_all(&[dense(), vec![0x88, 1, 0xE8, 7], vec![0x98, 1, 1]]).unwrap();
        assert_eq!(data.nodes[&1].position, LonLat::new(20_000.0 / 1e9, 10_001.0 / 1e9));
    }

    #[test]
    fn what_is_deleted_is_counted_and_left_out() {
        let gone = field(4, &[0x30, 0]);
        let node = field(2, &field(1, &[vec![0x08, 6, 0x40, 2, 0x48, 4], gone.clone()].concat()));
        let way = field(2, &field(3, &[vec![0x08, 5], gone].concat()));
        let data = read_all(&[dense(), node, way]).unwrap();
        assert_eq!((data.nodes.len(), data.ways.len(), data.report.deleted_elements), (1, 0, 3));
    }

    #[test]
    fn nodes_may_stand_alone() {
        let node = field(2, &field(1, &[0x08, 6, 0x40, 2, 0x48, 4]));
        assert_eq!(read_all(&[node]).unwrap().nodes[&3].position, LonLat::new(2.0 / 1e7, 1.0 / 1e7));
    }

    #[test]
    fn what_does_not_fit_together_is_said() {
        let without_positions = field(2, &field(2, &field(1, &[2, 2])));
        let unknown_word = field(2, &field(3, &[field(2, &[7]), field(3, &[7])].concat()));
        let no_value = field(2, &field(3, &field(2, &[0])));
        for (block, problem) in [
            (without_positions, "nodes without positions"),
            (unknown_word, "a word that is not in the block's table"),
            (no_value, "a key without a value"),
        ] {
            assert_eq!(read_all(&[block]).unwrap_err(), problem);
        }
    }

    #[test]
    fn a_long_word_cannot_be_asked_for_without_end() {
        let word = vec![b'x'; 1 << 16];
        let long = |number: u8, bytes: &[u8]| {
            let n = bytes.len();
            [&[number << 3 | 2, n as u8 | 128, (n >> 7) as u8 | 128, (n >> 14) as u8], bytes].concat()
        };
        // Ways of two bytes for each mention of the word: 2,000 mentions are 130 MB.
        let way = field(3, &[field(2, &[0; 50]), field(3, &[0; 50])].concat());
        let block = [long(1, &long(1, &word)), long(2, &way.repeat(20))];
        assert_eq!(read_all(&block).unwrap_err(), "the same long words again and again");
    }
}
