//! Lines as text: Google's *Encoded Polyline Algorithm Format*, with five or six decimal places.

use crate::geo::Place;

/// A line with so many decimal places, 5 or 6.
pub(crate) fn encode(points: &[Place], places: u32) -> String {
    // A `Place` has seven decimal places. Half a unit is rounded away from zero.
    let divisor = 10_i64.pow(7 - places);
    let rounded = |units: i32| {
        let units = i64::from(units);
        (units + divisor / 2 * units.signum()) / divisor
    };
    let (mut text, mut before) = (String::with_capacity(points.len() * 6), [0, 0]);
    for point in points {
        // The format has latitude first, and differences of rounded values, so that errors do not
        // add up.
        let now = [rounded(point.lat), rounded(point.lon)];
        for i in 0..2 {
            push(&mut text, now[i] - before[i]);
        }
        before = now;
    }
    text
}

fn push(text: &mut String, step: i64) {
    // The sign goes to the lowest bit, so that small negative steps stay short.
    let mut bits = (step << 1) ^ (step >> 63);
    // Five bits a character, the lowest first. Bit 0x20 says that more follow; 63 makes it
    // printable.
    while bits >= 0x20 {
        text.push(char::from((bits & 0x1f | 0x20) as u8 + 63));
        bits >>= 5;
    }
    text.push(char::from(bits as u8 + 63));
}

/// The line's latitudes and longitudes; `None` if the text is malformed.
pub(crate) fn decode(text: &str, places: u32) -> Option<Vec<[f64; 2]>> {
    let (mut bytes, mut line, mut now) = (text.bytes(), Vec::new(), [0_i64; 2]);
    let scale = 10_f64.powi(places as i32);
    while bytes.len() > 0 {
        for coordinate in &mut now {
            *coordinate += pull(&mut bytes)?;
        }
        line.push(now.map(|units| units as f64 / scale));
    }
    Some(line)
}

fn pull(bytes: &mut std::str::Bytes<'_>) -> Option<i64> {
    let (mut bits, mut shift) = (0_i64, 0);
    loop {
        let byte = bytes.next()?.checked_sub(63).filter(|byte| *byte < 64)?;
        bits |= i64::from(byte & 0x1f) << shift;
        shift += 5;
        if byte < 0x20 {
            return Some((bits >> 1) ^ -(bits & 1));
        }
        // Eight characters hold 40 bits, more than any step. A longer number is not from an
        // encoder, and would shift bits out of the result.
        if shift > 35 {
            return None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use openbench_core::LonLat;
    use proptest::prelude::*;

    /// The example in the description of the format.
    #[test]
    fn the_example_of_the_format_is_encoded() {
        let line = [(-120.2, 38.5), (-120.95, 40.7), (-126.453, 43.252)];
        let line = line.map(|(lon, lat)| Place::new(LonLat::new(lon, lat)).unwrap());
        assert_eq!(encode(&line, 5), "_p~iF~ps|U_ulLnnqC_mqNvxq`@");
        assert_eq!(
            decode("_p~iF~ps|U_ulLnnqC_mqNvxq`@", 5).unwrap()[2],
            [43.252, -126.453]
        );
    }

    proptest! {
        #[test]
        fn lines_come_back(
            line in proptest::collection::vec(
                (-180_000_000..180_000_000, -90_000_000..90_000_000),
                0..9,
            ),
        ) {
            let place = |(lon, lat): (i32, i32)| Place { lon: lon * 10, lat: lat * 10 };
            let line: Vec<Place> = line.into_iter().map(place).collect();
            let back = decode(&encode(&line, 6), 6).unwrap();
            let place = |[lat, lon]: [f64; 2]| Place::new(LonLat::new(lon, lat)).unwrap();
            let back: Vec<Place> = back.into_iter().map(place).collect();
            prop_assert_eq!(back, line);
        }

        #[test]
        fn malformed_text_does_not_panic(text in ".{0,40}") {
            let _ = decode(&text, 5);
        }
    }
}
