//! Writes OSM XML 0.6 and osmChange 0.6, and replaces files atomically.
//!
//! The same data gives the same bytes: nodes, ways, relations, each by number, tags by key, and
//! positions with seven decimals (a centimetre). Element versions are not kept in memory. Elements
//! of the OSM database are written as version 1, without which editors refuse the file. Before an
//! upload, an editor must download the current versions.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use openbench_core::LonLat;

use crate::data::OsmData;
use crate::element::{ElementId, Member, Node, Relation, Way};
use crate::error::OsmError;
use crate::tags::Tags;

impl OsmData {
    /// The data as OSM XML 0.6 in UTF-8. Characters that XML cannot represent (most control
    /// characters) are dropped from tags.
    pub fn to_xml(&self) -> Vec<u8> {
        let mut out = document("osm");
        self.nodes
            .values()
            .for_each(|node| write_node(&mut out, 1, node));
        self.ways
            .values()
            .for_each(|way| write_way(&mut out, 1, way));
        self.relations
            .values()
            .for_each(|relation| write_relation(&mut out, 1, relation));
        out.push_str("</osm>\n");
        out.into_bytes()
    }
}

/// The difference between two states of a map as osmChange 0.6: what must be created, modified and
/// deleted to get from `old` to `new`.
///
/// The order never leaves a reference without its target. Positions that agree to seven decimals
/// are equal.
pub fn changes(old: &OsmData, new: &OsmData) -> Vec<u8> {
    let (old, new) = (written_elements(old), written_elements(new));
    let created = new.iter().filter(|(id, _)| !old.contains_key(id));
    let modified = new
        .iter()
        .filter(|(id, text)| old.get(id).is_some_and(|was| was != *text));
    // Relations before ways before nodes: what refers to an element is deleted before it.
    let deleted = old.iter().rev().filter(|(id, _)| !new.contains_key(id));
    let mut out = document("osmChange");
    section(&mut out, "create", created.map(|(_, text)| text));
    section(&mut out, "modify", modified.map(|(_, text)| text));
    section(&mut out, "delete", deleted.map(|(_, text)| text));
    out.push_str("</osmChange>\n");
    out.into_bytes()
}

/// How far elements of an osmChange document are indented, in steps of two spaces.
const CHANGE_DEPTH: usize = 2;

/// Every element as it is written. Identifiers sort nodes before ways before relations, so that a
/// reference always follows its target.
fn written_elements(data: &OsmData) -> BTreeMap<ElementId, String> {
    let mut written = BTreeMap::new();
    for node in data.nodes.values() {
        let text = written.entry(ElementId::node(node.id)).or_default();
        write_node(text, CHANGE_DEPTH, node);
    }
    for way in data.ways.values() {
        let text = written.entry(ElementId::way(way.id)).or_default();
        write_way(text, CHANGE_DEPTH, way);
    }
    for relation in data.relations.values() {
        let text = written.entry(ElementId::relation(relation.id)).or_default();
        write_relation(text, CHANGE_DEPTH, relation);
    }
    written
}

fn section<'a>(out: &mut String, name: &str, elements: impl Iterator<Item = &'a String>) {
    let body: String = elements.map(String::as_str).collect();
    if !body.is_empty() {
        // Writing to a `String` does not fail, here and below.
        let _ = write!(out, "  <{name}>\n{body}  </{name}>\n");
    }
}

fn document(root: &str) -> String {
    let declaration = r#"<?xml version="1.0" encoding="UTF-8"?>"#;
    format!("{declaration}\n<{root} version=\"0.6\" generator=\"openbench\">\n")
}

fn write_node(out: &mut String, depth: usize, node: &Node) {
    let LonLat { lon, lat } = node.position;
    let position = format!(" lat=\"{}\" lon=\"{}\"", Degrees(lat), Degrees(lon));
    element(out, depth, "node", node.id, &position, &node.tags, "");
}

fn write_way(out: &mut String, depth: usize, way: &Way) {
    let mut body = String::new();
    for id in &way.nodes {
        let _ = writeln!(body, "{:1$}<nd ref=\"{id}\"/>", "", 2 * depth + 2);
    }
    element(out, depth, "way", way.id, "", &way.tags, &body);
}

fn write_relation(out: &mut String, depth: usize, relation: &Relation) {
    let mut body = String::new();
    for Member { kind, id, role } in &relation.members {
        let (indent, kind, role) = (2 * depth + 2, kind.word(), Escaped(role));
        let _ = writeln!(
            body,
            "{:indent$}<member type=\"{kind}\" ref=\"{id}\" role=\"{role}\"/>",
            ""
        );
    }
    element(
        out,
        depth,
        "relation",
        relation.id,
        "",
        &relation.tags,
        &body,
    );
}

fn element(
    out: &mut String,
    depth: usize,
    name: &str,
    id: i64,
    attributes: &str,
    tags: &Tags,
    body: &str,
) {
    let indent = 2 * depth;
    // Editors refuse elements of the database without a version. Negative ones are new and have
    // none.
    let version = if id > 0 { " version=\"1\"" } else { "" };
    let _ = write!(
        out,
        "{:indent$}<{name} id=\"{id}\"{version}{attributes}",
        ""
    );
    if tags.is_empty() && body.is_empty() {
        out.push_str("/>\n");
        return;
    }
    let _ = write!(out, ">\n{body}");
    for (key, value) in tags.iter() {
        let _ = writeln!(
            out,
            "{:indent$}  <tag k=\"{}\" v=\"{}\"/>",
            "",
            Escaped(key),
            Escaped(value)
        );
    }
    let _ = writeln!(out, "{:indent$}</{name}>", "");
}

/// Degrees with seven decimals and no negative zero.
struct Degrees(f64);

impl std::fmt::Display for Degrees {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.7}", round7(self.0))
    }
}

/// `degrees` rounded to the seven decimals of an OSM file.
pub(crate) fn round7(degrees: f64) -> f64 {
    // Adding zero turns -0 into 0.
    libm::round(degrees * 1e7) / 1e7 + 0.0
}

/// Text escaped for an attribute.
struct Escaped<'a>(&'a str);

impl std::fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for c in self.0.chars() {
            match c {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                // As they are, a parser would turn them into spaces: XML normalizes white space in
                // attributes.
                '\t' | '\n' | '\r' => write!(f, "&#{};", u32::from(c))?,
                '\0'..' ' | '\u{FFFE}' | '\u{FFFF}' => {}
                c => f.write_char(c)?,
            }
        }
        Ok(())
    }
}

/// Replaces the file at `path` with `bytes` atomically: a crash leaves the old file or the new one.
/// The bytes are written to a staging file in the same folder, which is then renamed.
///
/// # Errors
/// If a file cannot be written or renamed. The staging file is removed then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), OsmError> {
    let staging = staging_path(path);
    write_and_rename(&staging, path, bytes).map_err(|source| {
        let _ = std::fs::remove_file(&staging);
        OsmError::Io {
            doing: "write",
            path: path.to_owned(),
            source,
        }
    })
}

fn write_and_rename(staging: &Path, path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = std::fs::File::create(staging)?;
    file.write_all(bytes)?;
    // Before the new name is given: after a crash it must not lead to a file that is still empty.
    file.sync_all()?;
    std::fs::rename(staging, path)
}

/// Whether a file name is that of a staging file of [`write_atomically`] for a file called `name`,
/// which a process has left that was killed.
///
/// ```
/// assert!(openbench_osm::is_staging_of("run.json", ".run.json.4711.part"));
/// assert!(!openbench_osm::is_staging_of("run.json", "run.json.bak"));
/// ```
pub fn is_staging_of(name: &str, file: &str) -> bool {
    let process = file
        .strip_prefix('.')
        .and_then(|rest| rest.strip_prefix(name))
        .and_then(|rest| rest.strip_prefix('.'))
        .and_then(|rest| rest.strip_suffix(".part"));
    process.is_some_and(|id| !id.is_empty() && id.bytes().all(|byte| byte.is_ascii_digit()))
}

/// A hidden file in the same folder, so that renaming it stays within one file system.
fn staging_path(path: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    // The process in the name keeps two programs apart that write one file.
    name.push(format!(".{}.part", std::process::id()));
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data() -> OsmData {
        OsmData::from_xml(
            br#"<osm><node id="1" lat="-0.00000001" lon="2.5"/>
            <node id="-2" lat="1" lon="2"><tag k="a" v="&lt;&quot;&#10;&amp;'&gt;"/></node>
            <way id="7"><nd ref="1"/><nd ref="-2"/></way>
            <relation id="9"><member type="way" ref="7" role="o"/></relation></osm>"#,
        )
        .unwrap()
    }

    #[test]
    fn xml_is_written_in_order_and_escaped() {
        let expected = r#"<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6" generator="openbench">
  <node id="-2" lat="1.0000000" lon="2.0000000">
    <tag k="a" v="&lt;&quot;&#10;&amp;'&gt;"/>
  </node>
  <node id="1" version="1" lat="0.0000000" lon="2.5000000"/>
  <way id="7" version="1">
    <nd ref="1"/>
    <nd ref="-2"/>
  </way>
  <relation id="9" version="1">
    <member type="way" ref="7" role="o"/>
  </relation>
</osm>
"#;
        assert_eq!(String::from_utf8(data().to_xml()).unwrap(), expected);
    }

    #[test]
    fn changes_are_created_modified_and_deleted() {
        let old = data();
        let mut new = data();
        new.nodes.insert(
            -3,
            Node {
                id: -3,
                position: LonLat::new(1.0, 1.0),
                tags: Tags::new(),
            },
        );
        new.ways.get_mut(&7).unwrap().nodes.push(-3);
        new.relations.clear();
        let text = String::from_utf8(changes(&old, &new)).unwrap();
        let expected = r#"<osmChange version="0.6" generator="openbench">
  <create>
    <node id="-3" lat="1.0000000" lon="1.0000000"/>
  </create>
  <modify>
    <way id="7" version="1">
      <nd ref="1"/>
      <nd ref="-2"/>
      <nd ref="-3"/>
    </way>
  </modify>
  <delete>
    <relation id="9" version="1">
      <member type="way" ref="7" role="o"/>
    </relation>
  </delete>
</osmChange>
"#;
        assert_eq!(text.split_once('\n').unwrap().1, expected);
        assert!(
            !String::from_utf8(changes(&old, &old))
                .unwrap()
                .contains("node")
        );
    }

    #[test]
    fn a_file_is_replaced_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.osm");
        write_atomically(&path, b"old").unwrap();
        write_atomically(&path, b"new").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let error = write_atomically(&folder.path().join("no/map.osm"), b"")
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("cannot write") && error.contains("map.osm"),
            "{error}"
        );
    }
}
