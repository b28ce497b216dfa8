//! Readers that stand in for each other: what one cannot read the next is asked.

use openbench_core::Image;

use crate::error::ReaderError;
use crate::reader::{PlateReader, PlateReading};

/// A reader that failed so often on end is not asked again: it costs its time-out each time.
const PATIENCE: u32 = 3;

/// Asks the first of its readers, and the next where that fails. Where none reads, the last one's error is the answer.
///
/// Unlike other readers it may read an image otherwise the second time, since who fails three times on end is left out from then on.
pub struct InTurn {
    name: String,
    readers: Vec<Attempted>,
}

/// A reader, and how often on end it failed.
struct Attempted {
    reader: Box<dyn PlateReader>,
    failures: u32,
}

impl InTurn {
    /// Asks `first`, then each of `others`.
    pub fn new(first: Box<dyn PlateReader>, others: Vec<Box<dyn PlateReader>>) -> Self {
        let readers: Vec<_> =
            std::iter::once(first).chain(others).map(|reader| Attempted { reader, failures: 0 }).collect();
        let names: Vec<&str> = readers.iter().map(|attempted| attempted.reader.name()).collect();
        Self { name: names.join(", else "), readers }
    }
}

impl PlateReader for InTurn {
    fn name(&self) -> &str {
        &self.name
    }

    fn read(&mut self, image: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        let last = self.readers.len() - 1;
        for (index, attempted) in self.readers.iter_mut().enumerate() {
            if attempted.failures >= PATIENCE && index < last {
                continue;
            }
            match attempted.reader.read(image) {
                Ok(readings) => {
                    attempted.failures = 0;
                    return Ok(readings);
                }
                Err(error) if error.is_about_image() || index == last => return Err(error),
                Err(_) => attempted.failures += 1,
            }
        }
        // The last reader answers or its error is returned.
        Ok(Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    use openbench_core::SimTime;

    use super::*;

    /// Reads its name, or fails while it is out of order; counts how often it is asked.
    struct Fickle(&'static str, std::ops::Range<u32>, Arc<AtomicU32>);

    impl PlateReader for Fickle {
        fn name(&self) -> &str {
            self.0
        }

        fn read(&mut self, _: &Image) -> Result<Vec<PlateReading>, ReaderError> {
            if self.1.contains(&self.2.fetch_add(1, Ordering::SeqCst)) {
                return Err(ReaderError::Inference { stage: "detection", source: self.0.into() });
            }
            let text = self.0.to_owned();
            Ok(vec![PlateReading { text, confidence: 1.0, corners: [[0.0; 2]; 4] }])
        }
    }

    fn readings(first: std::ops::Range<u32>, second: std::ops::Range<u32>) -> (Vec<String>, u32) {
        let asked = Arc::new(AtomicU32::new(0));
        let second = Box::new(Fickle("b", second, Arc::default()));
        let mut reader = InTurn::new(Box::new(Fickle("a", first, asked.clone())), vec![second]);
        assert_eq!(reader.name(), "a, else b");
        let image = Image { stamp: SimTime::ZERO, width: 1, height: 1, rgb: vec![0; 3] };
        let said = (0..6).map(|_| match reader.read(&image) {
            Ok(readings) => readings[0].text.clone(),
            Err(error) => error.to_string(),
        });
        (said.collect(), asked.load(Ordering::SeqCst))
    }

    #[test]
    fn the_next_reads_what_the_first_cannot() {
        assert_eq!(readings(0..0, 0..9), (vec!["a".into(); 6], 6));
        let (said, _) = readings(1..3, 0..0);
        assert_eq!(said, ["a", "b", "b", "a", "a", "a"]);
    }

    #[test]
    fn who_is_gone_is_not_asked_for_ever() {
        assert_eq!(readings(0..99, 0..0), (vec!["b".into(); 6], 3));
        let (said, _) = readings(0..99, 4..99);
        assert!(said[3] == "b" && said[4].contains("failed: b"), "{said:?}");
    }
}
