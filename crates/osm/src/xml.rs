//! Reads OSM XML, API 0.6, as the OSM servers, Overpass, libosmium and JOSM write it.
//!
//! Unknown elements and attributes are skipped. Elements that JOSM (`action="delete"`) or the API
//! (`visible="false"`) marks as deleted are skipped and counted. Document type declarations are
//! refused: OSM needs none, and expanding entities are a known attack on a reader's memory. The
//! encoding is UTF-8.

use std::borrow::Cow;

use openbench_core::LonLat;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use crate::data::OsmData;
use crate::element::{ElementKind, Member, Node, Relation, Way};
use crate::error::{OsmError, Place, Problem};
use crate::tags::Tags;

pub(crate) fn read(bytes: &[u8]) -> Result<OsmData, OsmError> {
    let text = text(bytes)?;
    let mut reader = Reader::from_str(text);
    let mut document = Document::default();
    loop {
        // A problem with an event is reported at its begin.
        let before = reader.buffer_position();
        let event = reader.read_event().map_err(|error| {
            malformed(
                text,
                reader.error_position(),
                Problem::caused("not well-formed XML", error),
            )
        })?;
        let done = matches!(event, Event::Eof);
        document
            .take(event)
            .map_err(|problem| malformed(text, before, problem))?;
        if done {
            return Ok(document.data);
        }
    }
}

/// The bytes as text. Other formats are named in the error, since a wrong file is the likeliest
/// mistake.
fn text(bytes: &[u8]) -> Result<&str, OsmError> {
    // A byte order mark, with which some editors begin UTF-8.
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if let Some(problem) = foreign_format(bytes) {
        return Err(OsmError::malformed(Place::Byte(0), problem));
    }
    std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        let line = 1 + bytes[..at].iter().filter(|b| **b == b'\n').count();
        OsmError::malformed(Place::Line(line), "neither OSM PBF nor UTF-8 text")
    })
}

/// What to do about bytes of another format, if their beginning is known.
fn foreign_format(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [] => Some("the file is empty; it should be OSM XML or PBF"),
        [0x1F, 0x8B, ..] | [b'B', b'Z', b'h', ..] | [b'P', b'K', ..] => {
            Some("the file is compressed; decompress it first")
        }
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => Some("the file is UTF-16; save it as UTF-8"),
        _ if bytes.trim_ascii_start().starts_with(b"{") => {
            Some("the file is JSON; request [out:xml] from Overpass")
        }
        _ => None,
    }
}

fn malformed(text: &str, at: u64, problem: impl Into<Problem>) -> OsmError {
    // Lines are counted only for an error, not while reading.
    let before = text
        .as_bytes()
        .iter()
        .take(usize::try_from(at).unwrap_or(usize::MAX));
    OsmError::malformed(
        Place::Line(1 + before.filter(|b| **b == b'\n').count()),
        problem,
    )
}

/// The document as read so far.
#[derive(Default)]
struct Document {
    data: OsmData,
    /// How many elements are open now. OSM XML is three deep; any depth is tolerated.
    depth: usize,
    seen_root: bool,
    open: Open,
}

/// The element to which tags, nodes and members belong now.
#[derive(Default)]
enum Open {
    #[default]
    Nothing,
    Node(Node),
    Way(Way),
    Relation(Relation),
}

impl Document {
    fn take(&mut self, event: Event<'_>) -> Result<(), Problem> {
        match event {
            Event::Start(start) => {
                // `begin` sees the depth of the element itself, `end` that of its parent.
                self.begin(&start)?;
                self.depth += 1;
            }
            Event::Empty(start) => {
                self.begin(&start)?;
                self.end();
            }
            Event::End(_) => {
                // The parser refuses an end without a begin.
                self.depth = self.depth.saturating_sub(1);
                self.end();
            }
            Event::DocType(_) => {
                return Err("a document type is not allowed in OSM XML; remove it".into());
            }
            Event::Eof => return self.finish(),
            _ => {}
        }
        Ok(())
    }

    fn finish(&self) -> Result<(), Problem> {
        match (self.seen_root, self.depth) {
            (false, _) => Err("no <osm> element; this is not OSM XML".into()),
            (true, 0) => Ok(()),
            (true, _) => {
                Err("the file ends before </osm>; it is truncated, download it again".into())
            }
        }
    }

    fn begin(&mut self, start: &BytesStart<'_>) -> Result<(), Problem> {
        let name = start.name();
        match (self.depth, name.as_ref()) {
            // Depth decides, so that an element of a known name deep within an unknown one is
            // skipped.
            (0, "osm") => self.seen_root = true,
            (0, other) => {
                return Err(
                    format!("the root is <{other}>, not <osm>; this is not OSM XML").into(),
                );
            }
            (1, "node") => self.begin_element(start, ElementKind::Node)?,
            (1, "way") => self.begin_element(start, ElementKind::Way)?,
            (1, "relation") => self.begin_element(start, ElementKind::Relation)?,
            (2, "tag") => self.tag(start)?,
            (2, "nd") => self.way_node(start)?,
            (2, "member") => self.member(start)?,
            _ => {}
        }
        Ok(())
    }

    fn begin_element(&mut self, start: &BytesStart<'_>, kind: ElementKind) -> Result<(), Problem> {
        let head = Head::read(start)?;
        self.open = match head.open(kind) {
            // First, because a deleted node may lack its position without being a bad one.
            _ if head.deleted => {
                self.data.report.deleted_elements += 1;
                Open::Nothing
            }
            Some(open) => open,
            None => {
                self.data.report.bad_elements += 1;
                Open::Nothing
            }
        };
        Ok(())
    }

    fn tag(&mut self, start: &BytesStart<'_>) -> Result<(), Problem> {
        let [key, value] = attributes(start, ["k", "v"])?;
        let (Some(key), Some(value)) = (key, value) else {
            return Ok(());
        };
        if let Some(tags) = self.open.tags() {
            tags.insert(key, value);
        }
        Ok(())
    }

    fn way_node(&mut self, start: &BytesStart<'_>) -> Result<(), Problem> {
        let Open::Way(way) = &mut self.open else {
            return Ok(());
        };
        let [id] = attributes(start, ["ref"])?;
        match number(id) {
            Some(id) => way.nodes.push(id),
            None => self.data.report.bad_elements += 1,
        }
        Ok(())
    }

    fn member(&mut self, start: &BytesStart<'_>) -> Result<(), Problem> {
        let Open::Relation(relation) = &mut self.open else {
            return Ok(());
        };
        let [kind, id, role] = attributes(start, ["type", "ref", "role"])?;
        match (kind.as_deref().and_then(kind_from_word), number(id)) {
            (Some(kind), Some(id)) => {
                let role = role.unwrap_or_default().into_owned();
                relation.members.push(Member { kind, id, role });
            }
            _ => self.data.report.bad_elements += 1,
        }
        Ok(())
    }

    /// Closes an element at the depth of nodes, ways and relations.
    fn end(&mut self) {
        // A node, way or relation ends at the depth at which it began. Its children end deeper.
        if self.depth != 1 {
            return;
        }
        match std::mem::take(&mut self.open) {
            Open::Nothing => {}
            Open::Node(node) => self.data.put_node(node),
            Open::Way(way) => self.data.put_way(way),
            Open::Relation(relation) => self.data.put_relation(relation),
        }
    }
}

impl Open {
    fn tags(&mut self) -> Option<&mut Tags> {
        match self {
            Self::Nothing => None,
            Self::Node(node) => Some(&mut node.tags),
            Self::Way(way) => Some(&mut way.tags),
            Self::Relation(relation) => Some(&mut relation.tags),
        }
    }
}

/// The attributes of a node, way or relation that are used.
struct Head {
    id: Option<i64>,
    position: Option<LonLat>,
    deleted: bool,
}

impl Head {
    fn read(start: &BytesStart<'_>) -> Result<Self, Problem> {
        let [id, lon, lat, visible, action] =
            attributes(start, ["id", "lon", "lat", "visible", "action"])?;
        Ok(Self {
            id: number(id),
            position: degrees(lon)
                .zip(degrees(lat))
                .map(|(lon, lat)| LonLat::new(lon, lat)),
            deleted: visible.as_deref() == Some("false") || action.as_deref() == Some("delete"),
        })
    }

    fn open(&self, kind: ElementKind) -> Option<Open> {
        let id = self.id?;
        Some(match kind {
            ElementKind::Node => Open::Node(Node {
                id,
                position: self.position?,
                tags: Tags::new(),
            }),
            ElementKind::Way => Open::Way(Way {
                id,
                ..Way::default()
            }),
            ElementKind::Relation => Open::Relation(Relation {
                id,
                ..Relation::default()
            }),
        })
    }
}

fn degrees(text: Option<Cow<'_, str>>) -> Option<f64> {
    text?.trim().parse().ok()
}

fn number(text: Option<Cow<'_, str>>) -> Option<i64> {
    text?.trim().parse().ok()
}

fn kind_from_word(word: &str) -> Option<ElementKind> {
    [ElementKind::Node, ElementKind::Way, ElementKind::Relation]
        .into_iter()
        .find(|kind| kind.word() == word)
}

/// The values of the attributes called `names`, with entities resolved.
fn attributes<'a, const N: usize>(
    start: &'a BytesStart<'_>,
    names: [&str; N],
) -> Result<[Option<Cow<'a, str>>; N], Problem> {
    let mut values = [const { None }; N];
    // Without a search for duplicates in each element: of these the last counts.
    for attribute in start.attributes().with_checks(false) {
        let attribute =
            attribute.map_err(|error| Problem::caused("unreadable attribute", error))?;
        if let Some(i) = names
            .iter()
            .position(|name| *name == attribute.key.as_ref())
        {
            let value = attribute.normalized_value(XmlVersion::Implicit1_0);
            values[i] = Some(value.map_err(|error| {
                Problem::caused(format!("unreadable value of {}", names[i]), error)
            })?);
        }
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(text: &str) -> String {
        OsmData::from_xml(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn nodes_ways_relations_and_their_tags_are_read() {
        let data = OsmData::from_xml(
            br#"<?xml version="1.0" encoding="UTF-8"?>
            <osm version="0.6">
              <note>hello</note><bounds minlat="1" minlon="2" maxlat="3" maxlon="4"/>
              <node id="1" lat="1.5" lon="2.5"/>
              <node id="-2" lat="-1" lon="2"><tag k="name" v="A &amp; B &#x20AC;&#10;"/></node>
              <way id="7"><center lat="0" lon="0"/><nd ref="1"/><nd ref="-2"/>
                <tag k="highway" v="path"/></way>
              <relation id="9"><member type="way" ref="7" role="outer"/>
                <tag k="type" v="multipolygon"/></relation>
            </osm>"#,
        )
        .unwrap();
        assert_eq!(data.nodes[&1].position, LonLat::new(2.5, 1.5));
        assert!(data.nodes[&-2].tags.is("name", "A & B €\n"));
        assert_eq!(data.ways[&7].nodes, [1, -2]);
        let member = Member {
            kind: ElementKind::Way,
            id: 7,
            role: "outer".into(),
        };
        assert_eq!(data.relations[&9].members, [member]);
        assert_eq!(data.report, crate::ReadReport::default());
    }

    #[test]
    fn deleted_and_broken_elements_are_skipped_and_counted() {
        let data = OsmData::from_xml(
            br#"<osm version="0.6">
              <node id="1" action="delete" lat="1" lon="2"><tag k="a" v="b"/></node>
              <node id="2" visible="false"/>
              <node id="x" lat="1" lon="2"/><node id="3" lat="91" lon="2"/>
              <node id="4" lat="NaN" lon="2"/><node id="5"/>
              <node id="6" lat="1" lon="2"/><node id="6" lat="1" lon="3"/>
              <way id="1"><nd ref="1"/><nd ref="6"/></way><way id="2"/>
              <way id="3"><nd ref="six"/></way>
              <relation id="1"><member type="way" ref="99" role=""/>
                <member type="area" ref="1"/></relation>
            </osm>"#,
        )
        .unwrap();
        let report = crate::ReadReport {
            ways_with_missing_nodes: 1,
            ways_without_nodes: 2,
            relations_with_missing_members: 1,
            deleted_elements: 2,
            bad_elements: 6,
            repeated_elements: 1,
        };
        assert_eq!(data.report, report);
        assert_eq!(data.nodes.keys().collect::<Vec<_>>(), [&6]);
    }

    #[test]
    fn a_truncated_file_is_an_error_with_its_last_line() {
        let text = "<osm>\n<node id=\"1\" lat=\"1\" lon=\"2\"/>\n<way id=\"1\">";
        assert_eq!(
            problem(text),
            "line 3: the file ends before </osm>; it is truncated, download it again"
        );
        assert!(problem("<osm>\n<node id=\"1\" la").starts_with("line 2: not well-formed XML"));
        assert!(problem("<osm>\n<node></way></osm>").starts_with("line 2: not well-formed XML"));
    }

    #[test]
    fn other_formats_are_named() {
        assert!(problem("").contains("empty"));
        assert!(problem("  {\"elements\": []}").contains("[out:xml]"));
        assert!(problem("\u{1}hello").contains("no <osm> element"));
        assert!(problem("<html></html>").contains("the root is <html>"));
        assert!(
            OsmData::from_xml(b"\x1f\x8b\x08")
                .unwrap_err()
                .to_string()
                .contains("decompress")
        );
        assert!(
            OsmData::from_xml(b"<osm>\n\xff")
                .unwrap_err()
                .to_string()
                .starts_with("line 2: neither")
        );
    }

    #[test]
    fn expanding_entities_are_refused() {
        let bomb = r#"<!DOCTYPE lolz [<!ENTITY a "lol"><!ENTITY b "&a;&a;&a;">]>
            <osm><node id="1" lat="&b;" lon="1"/></osm>"#;
        assert_eq!(
            problem(bomb),
            "line 1: a document type is not allowed in OSM XML; remove it"
        );
        assert!(problem("<osm><node id=\"&b;\"/></osm>").contains("unreadable value of id"));
    }
}
