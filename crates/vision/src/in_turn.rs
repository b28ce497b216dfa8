//! Several readers: the next one reads where one fails.

use openbench_core::Image;

use crate::error::ReaderError;
use crate::reader::{PlateReader, PlateReading};

/// Number of consecutive failures after which a reader is not used any more, since each failure
/// costs its time-out.
const MAX_FAILURES: u32 = 3;

/// Reads with the first of its readers, and with the next one where that fails. If all fail, the
/// error is that of the last one.
///
/// A reader that fails three times in a row is not used any more, so that the same image may be
/// read differently the second time.
pub struct InTurn {
    name: String,
    readers: Vec<Attempted>,
}

/// A reader and its number of consecutive failures.
struct Attempted {
    reader: Box<dyn PlateReader>,
    failures: u32,
}

impl InTurn {
    /// Reads with `first`, else with each of `others` in order.
    pub fn new(first: Box<dyn PlateReader>, others: Vec<Box<dyn PlateReader>>) -> Self {
        let readers: Vec<_> = std::iter::once(first)
            .chain(others)
            .map(|reader| Attempted {
                reader,
                failures: 0,
            })
            .collect();
        let names: Vec<&str> = readers
            .iter()
            .map(|attempted| attempted.reader.name())
            .collect();
        Self {
            name: names.join(", else "),
            readers,
        }
    }
}

impl PlateReader for InTurn {
    fn name(&self) -> &str {
        &self.name
    }

    fn read(&mut self, image: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        // There is at least one reader: `new` takes the first one by itself.
        let last = self.readers.len() - 1;
        for (index, attempted) in self.readers.iter_mut().enumerate() {
            // The last one is always asked: without it there would be neither readings nor an
            // error.
            if attempted.failures >= MAX_FAILURES && index < last {
                continue;
            }
            match attempted.reader.read(image) {
                Ok(readings) => {
                    attempted.failures = 0;
                    return Ok(readings);
                }
                // An image that nobody can read says nothing about the reader, so it is no failure
                // of it.
                Err(error) if error.is_about_image() || index == last => return Err(error),
                Err(_) => attempted.failures += 1,
            }
        }
        // Not reached: the last reader returns its readings or its error.
        Ok(Vec::new())
    }

    fn computes_here(&self) -> bool {
        let mut readers = self.readers.iter();
        readers.any(|attempted| attempted.reader.computes_here())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    use openbench_core::{SimTime, with_causes};

    use super::*;

    /// Reads its own name, or fails in a range of calls; counts its calls.
    struct Fickle(&'static str, std::ops::Range<u32>, Arc<AtomicU32>);

    impl PlateReader for Fickle {
        fn name(&self) -> &str {
            self.0
        }

        fn read(&mut self, _: &Image) -> Result<Vec<PlateReading>, ReaderError> {
            if self.1.contains(&self.2.fetch_add(1, Ordering::SeqCst)) {
                return Err(ReaderError::Inference {
                    stage: "detection",
                    source: self.0.into(),
                });
            }
            let text = self.0.to_owned();
            Ok(vec![PlateReading {
                text,
                confidence: 1.0,
                corners: [[0.0; 2]; 4],
            }])
        }
    }

    fn readings(first: std::ops::Range<u32>, second: std::ops::Range<u32>) -> (Vec<String>, u32) {
        let calls = Arc::new(AtomicU32::new(0));
        let second = Box::new(Fickle("b", second, Arc::default()));
        let mut reader = InTurn::new(Box::new(Fickle("a", first, calls.clone())), vec![second]);
        assert_eq!(reader.name(), "a, else b");
        let image = Image {
            stamp: SimTime::ZERO,
            width: 1,
            height: 1,
            rgb: vec![0; 3],
        };
        let said = (0..6).map(|_| match reader.read(&image) {
            Ok(readings) => readings[0].text.clone(),
            Err(error) => with_causes(&error),
        });
        (said.collect(), calls.load(Ordering::SeqCst))
    }

    #[test]
    fn the_next_reader_reads_where_the_first_fails() {
        assert_eq!(readings(0..0, 0..9), (vec!["a".into(); 6], 6));
        let (said, _) = readings(1..3, 0..0);
        assert_eq!(said, ["a", "b", "b", "a", "a", "a"]);
    }

    #[test]
    fn a_reader_that_keeps_failing_is_not_used_any_more() {
        assert_eq!(readings(0..99, 0..0), (vec!["b".into(); 6], 3));
        let (said, _) = readings(0..99, 4..99);
        assert!(said[3] == "b" && said[4].contains("failed: b"), "{said:?}");
    }
}
