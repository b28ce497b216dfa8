//! Rows of numbers, in memory or in a memory-mapped file.

use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use bytemuck::Pod;
use memmap2::Mmap;
use yoke::Yoke;

/// A row of numbers.
pub struct Column<T: Pod>(Kept<T>);

enum Kept<T: Pod> {
    Owned(Vec<T>),
    Mapped(Yoke<&'static [T], Arc<Mmap>>),
}

impl<T: Pod> Column<T> {
    /// Part of a mapped file; `None` if it is not inside the file, not a whole number of elements,
    /// or not aligned.
    pub(super) fn mapped(file: &Arc<Mmap>, begin: usize, bytes: usize) -> Option<Self> {
        // The slice and the mapping that it borrows from are kept together, so that a column has no
        // lifetime. Begin and length come from a file: their sum may overflow.
        let attached = Yoke::try_attach_to_cart(Arc::clone(file), |file: &Mmap| {
            let part = file
                .get(begin..begin.checked_add(bytes).ok_or(())?)
                .ok_or(())?;
            bytemuck::try_cast_slice(part).map_err(|_| ())
        });
        attached.ok().map(|yoke| Self(Kept::Mapped(yoke)))
    }
}

impl<T: Pod> Deref for Column<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Kept::Owned(numbers) => numbers,
            Kept::Mapped(numbers) => numbers.get(),
        }
    }
}

impl<T: Pod> Default for Column<T> {
    fn default() -> Self {
        Self(Kept::Owned(Vec::new()))
    }
}

impl<T: Pod> From<Vec<T>> for Column<T> {
    fn from(numbers: Vec<T>) -> Self {
        Self(Kept::Owned(numbers))
    }
}

impl<T: Pod> FromIterator<T> for Column<T> {
    fn from_iter<I: IntoIterator<Item = T>>(numbers: I) -> Self {
        Self(Kept::Owned(numbers.into_iter().collect()))
    }
}

/// The clone is in memory.
impl<T: Pod> Clone for Column<T> {
    fn clone(&self) -> Self {
        Self(Kept::Owned(self.to_vec()))
    }
}

impl<T: Pod + PartialEq> PartialEq for Column<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Pod + Eq> Eq for Column<T> {}

impl<T: Pod> fmt::Debug for Column<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {}", self.len(), std::any::type_name::<T>())
    }
}
