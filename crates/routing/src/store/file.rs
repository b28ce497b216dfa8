//! Reading and writing graph files.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytemuck::Pod;
use memmap2::Mmap;
use openbench_osm::Tags;
use serde::{Deserialize, Serialize};

use super::{Column, check, map};
use crate::network::{Network, RoadName};
use crate::roads::Roads;
use crate::tree::SegmentTree;

const MAGIC: [u8; 8] = *b"OBROADS\0";
const VERSION: u32 = 1;
const HEADER: usize = 64;
const ENTRY: usize = 24;
const ALIGNMENT: usize = 64;
const SECTIONS: usize = 11;

/// Why a file is not taken.
#[derive(Debug, thiserror::Error)]
pub enum GraphFileError {
    /// It cannot be read or written.
    #[error("cannot {doing} the graph file {}: {source}", path.display())]
    Io {
        /// What was tried.
        doing: &'static str,
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is no graph file, or a damaged one, or of another version.
    #[error("{}: {problem}; make it again with `openbench prepare`", path.display())]
    Bad {
        /// Which.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
}

/// The words of a network.
#[derive(Serialize, Deserialize)]
struct Words {
    ways: Vec<Vec<(String, String)>>,
    nodes: Vec<Vec<(String, String)>>,
    restrictions: Vec<Vec<(String, String)>>,
    names: Vec<(String, String)>,
}

/// Whether a file begins like a graph file.
pub fn is_graph_file(path: &Path) -> bool {
    let mut begin = [0; MAGIC.len()];
    File::open(path).and_then(|mut file| file.read_exact(&mut begin)).is_ok() && begin == MAGIC
}

/// Writes a network in its cells to a file, which is replaced whole or not at all.
pub fn write(roads: &Roads, path: &Path) -> Result<(), GraphFileError> {
    let network = &roads.network;
    let words = Words {
        ways: network.way_words.iter().map(pairs).collect(),
        nodes: network.node_words.iter().map(pairs).collect(),
        restrictions: network.restriction_words.iter().map(pairs).collect(),
        names: network.names.iter().map(|name| (name.name.clone(), name.reference.clone())).collect(),
    };
    let io = |source| GraphFileError::Io { doing: "write", path: path.to_owned(), source };
    let words = serde_json::to_vec(&words).map_err(|error| io(error.into()))?;
    // Each level with its length before it.
    let levels: Vec<u32> = roads
        .levels
        .iter()
        .flat_map(|starts| std::iter::once(starts.len() as u32).chain(starts.iter().copied()))
        .collect();
    let sections: [&[u8]; SECTIONS] = [
        bytemuck::cast_slice(&network.vertices),
        bytemuck::cast_slice(&network.vertex_classes),
        bytemuck::cast_slice(&network.edges),
        bytemuck::cast_slice(&network.points),
        bytemuck::cast_slice(&network.nodes),
        bytemuck::cast_slice(&network.ways),
        bytemuck::cast_slice(&network.restrictions),
        bytemuck::cast_slice(&roads.segments.runs),
        bytemuck::cast_slice(&roads.segments.boxes),
        bytemuck::cast_slice(&levels),
        &words,
    ];
    let mut bytes = vec![0; HEADER + SECTIONS * ENTRY];
    for (i, section) in sections.into_iter().enumerate() {
        bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
        let entry = [i as u64, bytes.len() as u64, section.len() as u64];
        let at = HEADER + i * ENTRY;
        bytes[at..at + ENTRY].copy_from_slice(bytemuck::cast_slice(&entry.map(u64::to_le)));
        bytes.extend_from_slice(section);
    }
    let length = bytes.len() as u64;
    let sum = blake3::hash(&bytes[HEADER..]);
    let header = [
        MAGIC.as_slice(),
        &VERSION.to_le_bytes(),
        &(SECTIONS as u32).to_le_bytes(),
        &length.to_le_bytes(),
        &[0; 8],
        sum.as_bytes(),
    ];
    bytes[..HEADER].copy_from_slice(&header.concat());
    openbench_osm::write_atomically(path, &bytes).map_err(|error| io(io::Error::other(error)))
}

fn pairs(tags: &Tags) -> Vec<(String, String)> {
    tags.iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect()
}

/// Opens a graph file.
pub fn read(path: &Path) -> Result<Roads, GraphFileError> {
    let io = |source| GraphFileError::Io { doing: "read", path: path.to_owned(), source };
    let mut file = File::open(path).map_err(io)?;
    let bad = |problem: &str| GraphFileError::Bad { path: path.to_owned(), problem: problem.to_owned() };
    whole(&mut file).map_err(io)?.map_err(bad)?;
    let file = Arc::new(map::mapped(&file).map_err(io)?);
    let roads = Sections { file }.roads().map_err(bad)?;
    check::roads(&roads).map_err(bad)?;
    Ok(roads)
}

/// Whether the file is one of ours, of this version, and as it was written.
fn whole(file: &mut File) -> io::Result<Result<(), &'static str>> {
    const FOREIGN: &str = "this is not a graph file";
    if cfg!(target_endian = "big") {
        return Ok(Err("graph files can be read on little-endian machines only"));
    }
    let size = file.metadata()?.len();
    let mut header = [0; HEADER];
    if size < (HEADER + SECTIONS * ENTRY) as u64 {
        return Ok(Err("this is not a graph file, or only the beginning of one"));
    }
    file.read_exact(&mut header)?;
    let number = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
    if header[..8] != MAGIC {
        return Ok(Err(FOREIGN));
    }
    if number(8) != VERSION || number(12) != SECTIONS as u32 {
        return Ok(Err("this graph file is of another version of the program"));
    }
    if u64::from(number(16)) | u64::from(number(20)) << 32 != size {
        return Ok(Err("this graph file is cut off, or something stands behind its end"));
    }
    // Read, not mapped, so that looking at all of it once does not keep all of it in memory.
    let mut hasher = blake3::Hasher::new();
    let mut block = vec![0; 1 << 16];
    file.seek(SeekFrom::Start(HEADER as u64))?;
    loop {
        match file.read(&mut block)? {
            0 => break,
            read => drop(hasher.update(&block[..read])),
        }
    }
    Ok(if hasher.finalize().as_bytes() == &header[32..64] {
        Ok(())
    } else {
        Err("this graph file is damaged")
    })
}

struct Sections {
    file: Arc<Mmap>,
}

impl Sections {
    fn column<T: Pod>(&self, section: usize) -> Result<Column<T>, &'static str> {
        const WRONG: &str = "a section of this graph file lies outside it";
        let at = HEADER + section * ENTRY;
        let entry = self.file.get(at..at + ENTRY).ok_or(WRONG)?;
        let number = |i: usize| {
            let bytes = entry[8 * i..8 * i + 8].try_into().unwrap_or_default();
            usize::try_from(u64::from_le_bytes(bytes)).map_err(|_| WRONG)
        };
        if number(0)? != section {
            return Err("a section of this graph file is missing");
        }
        Column::mapped(&self.file, number(1)?, number(2)?).ok_or(WRONG)
    }

    fn roads(&self) -> Result<Roads, &'static str> {
        let words: Column<u8> = self.column(10)?;
        let words: Words =
            serde_json::from_slice(&words).map_err(|_| "the words of this graph file cannot be read")?;
        let tags = |sets: Vec<Vec<(String, String)>>| sets.into_iter().map(Tags::from_iter).collect();
        let name = |(name, reference)| RoadName { name, reference };
        let network = Network {
            vertices: self.column(0)?,
            vertex_classes: self.column(1)?,
            edges: self.column(2)?,
            points: self.column(3)?,
            nodes: self.column(4)?,
            ways: self.column(5)?,
            restrictions: self.column(6)?,
            way_words: tags(words.ways),
            node_words: tags(words.nodes),
            restriction_words: tags(words.restrictions),
            names: words.names.into_iter().map(name).collect(),
            report: Default::default(),
        };
        let segments = SegmentTree::from_parts(self.column(7)?, self.column(8)?);
        let segments = segments.ok_or("the tree of segments in this graph file is incomplete")?;
        let levels = levels(&self.column(9)?)?;
        check::network(&network)?;
        check::levels(&levels, network.vertices.len())?;
        Ok(Roads::assemble(network, levels, segments))
    }
}

fn levels(mut rest: &[u32]) -> Result<Vec<Vec<u32>>, &'static str> {
    let mut levels = Vec::new();
    while let [length, after @ ..] = rest {
        let (level, after) =
            after.split_at_checked(*length as usize).ok_or("the cells of this graph file are incomplete")?;
        levels.push(level.to_vec());
        rest = after;
    }
    Ok(levels)
}
