//! Files mapped into memory: the one place with `unsafe`.

use std::fs::File;
use std::io;

use memmap2::Mmap;

/// A file's bytes, read when they are looked at.
///
/// Worth its `unsafe`: of a country's network a route looks at some thousandths, and processes share what they have read.
#[expect(
    unsafe_code,
    reason = "a mapped file is memory that others might change"
)]
pub(super) fn mapped(file: &File) -> io::Result<Mmap> {
    // SAFETY: graph files are written whole and renamed into place, never changed where they are, so nobody changes the bytes
    // of a file that is open. (One who cuts the file off all the same ends this process with a bus error.) Every number in it is
    // valid for its type, and what numbers refer to is checked before it is used.
    unsafe { Mmap::map(file) }
}
