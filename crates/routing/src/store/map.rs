//! Memory-mapped files: the only place with `unsafe`.

use std::fs::File;
use std::io;

use memmap2::Mmap;

/// The bytes of a file, which are read on access.
///
/// Worth its `unsafe`: a route needs some thousandths of a country's network, and processes share
/// what they have read.
#[expect(
    unsafe_code,
    reason = "a mapped file is memory that others might change"
)]
pub(super) fn mapped(file: &File) -> io::Result<Mmap> {
    // SAFETY: graph files are written whole, renamed into place, and never changed afterwards, so
    // the bytes of an open file do not change. (Truncating it nevertheless ends this process with a
    // bus error.) Every bit pattern is valid for the types of the numbers in it. What numbers refer
    // to is checked before use.
    unsafe { Mmap::map(file) }
}
