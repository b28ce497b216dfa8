//! Reads and writes graph files.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytemuck::Pod;
use memmap2::Mmap;
use openbench_core::input;

use super::{Column, check, map};
use crate::network::{Network, RoadNames, TagSets, Texts};
use crate::roads::Roads;
use crate::tree::SegmentTree;

const MAGIC: [u8; 8] = *b"OBROADS\0";
const VERSION: u32 = 2;
const HEADER: usize = 64;
const ENTRY: usize = 24;
const ALIGNMENT: usize = 64;
const SECTIONS: usize = 20;

/// Why a graph file cannot be used or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GraphFileError {
    /// It cannot be read or written.
    #[error("cannot {doing} the graph file {}", path.display())]
    Io {
        /// `read` or `write`.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// It is no graph file, damaged, or of another version.
    #[error("{}: {problem}; make it again with `openbench prepare`", path.display())]
    Bad {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
}

/// Whether a file begins like a graph file.
pub fn is_graph_file(path: &Path) -> bool {
    let mut begin = [0; MAGIC.len()];
    input::open(path)
        .and_then(|mut file| file.read_exact(&mut begin))
        .is_ok()
        && begin == MAGIC
}

/// Writes a network in its cells to a file, which is replaced atomically.
///
/// # Errors
/// If the file cannot be written.
pub fn write(roads: &Roads, path: &Path) -> Result<(), GraphFileError> {
    // Each level is preceded by its length.
    let levels: Vec<u32> = roads
        .levels
        .iter()
        .flat_map(|starts| std::iter::once(starts.len() as u32).chain(starts.iter().copied()))
        .collect();
    let mut bytes = vec![0; HEADER + SECTIONS * ENTRY];
    for (i, section) in sections(roads, &levels).into_iter().enumerate() {
        bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
        // Aligned to more than any number needs, so that mapped sections can be read in place.
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
    openbench_osm::write_atomically(path, &bytes).map_err(|error| GraphFileError::Io {
        doing: "write",
        path: path.to_owned(),
        source: io::Error::other(error),
    })
}

/// The sections of a file, in the order in which [`Sections::roads`] reads them.
fn sections<'a>(roads: &'a Roads, levels: &'a [u32]) -> [&'a [u8]; SECTIONS] {
    let network = &roads.network;
    let [ways, nodes] = [&network.way_tags, &network.node_tags].map(|sets| &sets.0);
    let (restrictions, names) = (&network.restriction_tags.0, &network.names.0);
    [
        bytemuck::cast_slice(&network.vertices),
        bytemuck::cast_slice(&network.vertex_classes),
        bytemuck::cast_slice(&network.vertex_nodes),
        bytemuck::cast_slice(&network.edges),
        bytemuck::cast_slice(&network.points),
        bytemuck::cast_slice(&network.nodes),
        bytemuck::cast_slice(&network.ways),
        bytemuck::cast_slice(&network.restrictions),
        bytemuck::cast_slice(&network.via_ways),
        bytemuck::cast_slice(&roads.segments.runs),
        bytemuck::cast_slice(&roads.segments.boxes),
        bytemuck::cast_slice(levels),
        &ways.bytes,
        bytemuck::cast_slice(&ways.ends),
        &nodes.bytes,
        bytemuck::cast_slice(&nodes.ends),
        &restrictions.bytes,
        bytemuck::cast_slice(&restrictions.ends),
        &names.bytes,
        bytemuck::cast_slice(&names.ends),
    ]
}

/// Opens a graph file.
///
/// # Errors
/// If the file cannot be read, is no graph file of this version, or is damaged.
pub fn read(path: &Path) -> Result<Roads, GraphFileError> {
    let io = |source| GraphFileError::Io {
        doing: "read",
        path: path.to_owned(),
        source,
    };
    let mut file = input::open(path).map_err(io)?;
    let bad = |problem: &str| GraphFileError::Bad {
        path: path.to_owned(),
        problem: problem.to_owned(),
    };
    whole(&mut file).map_err(io)?.map_err(bad)?;
    let file = Arc::new(map::mapped(&file).map_err(io)?);
    // The checksum only says that the file is as it was written. Its content is checked too.
    let roads = Sections { file, next: 0 }.roads().map_err(bad)?;
    check::roads(&roads).map_err(bad)?;
    Ok(roads)
}

/// Checks that the file is a graph file of this version, as it was written.
fn whole(file: &mut File) -> io::Result<Result<(), &'static str>> {
    const FOREIGN: &str = "this is not a graph file";
    if cfg!(target_endian = "big") {
        return Ok(Err(
            "graph files can be read on little-endian machines only",
        ));
    }
    // The cheap checks come first. Each has its own message, because the remedies differ.
    let size = file.metadata()?.len();
    let mut header = [0; HEADER];
    if size < (HEADER + SECTIONS * ENTRY) as u64 {
        return Ok(Err("this is not a graph file, or it is truncated"));
    }
    file.read_exact(&mut header)?;
    let number = |at: usize| {
        u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]])
    };
    if header[..8] != MAGIC {
        return Ok(Err(FOREIGN));
    }
    if number(8) != VERSION || number(12) != SECTIONS as u32 {
        return Ok(Err("this graph file is of another version of the program"));
    }
    if u64::from(number(16)) | u64::from(number(20)) << 32 != size {
        return Ok(Err(
            "this graph file is truncated, or something follows its end",
        ));
    }
    // Read, not mapped, so that checking the whole file once does not keep it in memory.
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

/// The sections of a file, one after another.
struct Sections {
    file: Arc<Mmap>,
    next: usize,
}

impl Sections {
    fn column<T: Pod>(&mut self) -> Result<Column<T>, &'static str> {
        const WRONG: &str = "a section of this graph file lies outside it";
        let at = HEADER + self.next * ENTRY;
        let entry = self.file.get(at..at + ENTRY).ok_or(WRONG)?;
        let number = |i: usize| {
            let bytes = entry[8 * i..8 * i + 8].try_into().unwrap_or_default();
            usize::try_from(u64::from_le_bytes(bytes)).map_err(|_| WRONG)
        };
        if number(0)? != self.next {
            return Err("a section of this graph file is missing");
        }
        let (begin, bytes) = (number(1)?, number(2)?);
        self.next += 1;
        Column::mapped(&self.file, begin, bytes).ok_or(WRONG)
    }

    fn texts(&mut self) -> Result<Texts, &'static str> {
        let texts = Texts {
            bytes: self.column()?,
            ends: self.column()?,
        };
        if texts.are_whole() {
            Ok(texts)
        } else {
            Err("the texts of this graph file cannot be read")
        }
    }

    fn roads(&mut self) -> Result<Roads, &'static str> {
        // Fields of a struct are evaluated in the order in which they are written: that of the
        // file.
        let mut network = Network {
            vertices: self.column()?,
            vertex_classes: self.column()?,
            vertex_nodes: self.column()?,
            edges: self.column()?,
            points: self.column()?,
            nodes: self.column()?,
            ways: self.column()?,
            restrictions: self.column()?,
            via_ways: self.column()?,
            ..Network::default()
        };
        let segments = SegmentTree::from_parts(self.column()?, self.column()?);
        let segments = segments.ok_or("the tree of segments in this graph file is incomplete")?;
        let levels = levels(&self.column()?)?;
        network.way_tags = TagSets(self.texts()?);
        network.node_tags = TagSets(self.texts()?);
        network.restriction_tags = TagSets(self.texts()?);
        network.names = RoadNames(self.texts()?);
        // Before layers are made of it, the content is checked: `assemble` indexes by it.
        check::network(&network)?;
        check::levels(&levels, network.vertices.len())?;
        Ok(Roads::assemble(network, levels, segments))
    }
}

fn levels(mut rest: &[u32]) -> Result<Vec<Vec<u32>>, &'static str> {
    let mut levels = Vec::new();
    while let [length, after @ ..] = rest {
        let (level, after) = after
            .split_at_checked(*length as usize)
            .ok_or("the cells of this graph file are incomplete")?;
        levels.push(level.to_vec());
        rest = after;
    }
    Ok(levels)
}
