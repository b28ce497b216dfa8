//! JSON as OSRM writes it: no white space, whole numbers without a decimal point.
//!
//! Written directly, without a tree: most of an answer are coordinates, which are whole numbers
//! here and need not become floating point first.

use crate::geo::Place;

/// A JSON text under construction. Commas are inserted automatically.
#[derive(Debug, Default)]
pub(crate) struct Json {
    text: Vec<u8>,
    comma: bool,
}

impl Json {
    /// The text.
    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.text
    }

    fn begin(&mut self) {
        // Every value begins here. A comma is due unless the value is the first one, or follows a
        // key.
        if std::mem::replace(&mut self.comma, true) {
            self.text.push(b',');
        }
    }

    /// An object with these members.
    pub(crate) fn object(&mut self, members: impl FnOnce(&mut Self)) {
        self.within(b'{', b'}', members);
    }

    /// An array of these values.
    pub(crate) fn array(&mut self, values: impl FnOnce(&mut Self)) {
        self.within(b'[', b']', values);
    }

    fn within(&mut self, open: u8, close: u8, content: impl FnOnce(&mut Self)) {
        self.begin();
        self.text.push(open);
        self.comma = false;
        content(self);
        self.text.push(close);
        self.comma = true;
    }

    /// The name of the value that follows.
    pub(crate) fn key(&mut self, key: &str) -> &mut Self {
        self.string(key);
        self.text.push(b':');
        self.comma = false;
        self
    }

    /// A string.
    pub(crate) fn string(&mut self, text: &str) {
        self.begin();
        self.text.push(b'"');
        for byte in text.bytes() {
            match byte {
                // JSON demands escapes for these and for control characters only. Other UTF-8 stays
                // as it is.
                b'"' | b'\\' => self.text.extend([b'\\', byte]),
                0..0x20 => self.text.extend(format!("\\u{byte:04x}").bytes()),
                _ => self.text.push(byte),
            }
        }
        self.text.push(b'"');
    }

    /// `true` or `false`.
    pub(crate) fn boolean(&mut self, value: bool) {
        self.begin();
        self.text
            .extend_from_slice(if value { b"true" } else { b"false" });
    }

    /// `null`.
    pub(crate) fn null(&mut self) {
        self.begin();
        self.text.extend_from_slice(b"null");
    }

    /// A whole number.
    pub(crate) fn whole(&mut self, value: i64) {
        self.begin();
        self.digits(value);
    }

    /// A number rounded to so many decimal places, without trailing zeros.
    pub(crate) fn decimal(&mut self, value: f64, places: u32) {
        let units = libm::round(value * 10_f64.powi(places as i32)) as i64;
        self.begin();
        self.fixed(units, places);
    }

    /// Hundredths of a second as seconds, rounded to a tenth.
    pub(crate) fn seconds(&mut self, hundredths: u64) {
        self.begin();
        self.fixed((hundredths as i64 + 5) / 10, 1);
    }

    /// Longitude and latitude, rounded to 1e-6 degrees.
    pub(crate) fn place(&mut self, place: Place) {
        self.begin();
        self.text.push(b'[');
        for (i, units) in [place.lon, place.lat].into_iter().enumerate() {
            if i > 0 {
                self.text.push(b',');
            }
            let units = i64::from(units);
            // From 1e-7 to 1e-6 degrees, half away from zero, as OSRM rounds coordinates.
            self.fixed((units + 5 * units.signum()) / 10, 6);
        }
        self.text.push(b']');
    }

    fn digits(&mut self, value: i64) {
        self.text
            .extend_from_slice(itoa::Buffer::new().format(value).as_bytes());
    }

    fn fixed(&mut self, units: i64, places: u32) {
        let one = 10_i64.pow(places);
        // Written apart, because the whole part of -0.5 is 0 and has no sign.
        if units < 0 {
            self.text.push(b'-');
        }
        self.digits((units / one).abs());
        let mut rest = (units % one).abs();
        if rest == 0 {
            return;
        }
        self.text.push(b'.');
        let mut unit = one / 10;
        while rest > 0 {
            self.text.push(b'0' + (rest / unit) as u8);
            (rest, unit) = (rest % unit, unit / 10);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_osrm_writes_them() {
        let mut json = Json::default();
        json.array(|json| {
            for (value, places) in [
                (1684.04, 1),
                (1684.05, 1),
                (-0.05, 1),
                (0.0, 1),
                (34.969_474_9, 3),
                (-12.5, 2),
            ] {
                json.decimal(value, places);
            }
            json.seconds(12_349);
            json.place(Place {
                lon: -86_218_685,
                lat: 411_000_000,
            });
            json.place(Place { lon: -4, lat: 50 });
        });
        let text = String::from_utf8(json.into_bytes()).unwrap();
        assert_eq!(
            text,
            "[1684,1684.1,-0.1,0,34.969,-12.5,123.5,[-8.621869,41.1],[0,0.000005]]"
        );
    }

    #[test]
    fn any_text_can_be_read_back() {
        let text = "a\"b\\c\nd\u{1}é🚚";
        let mut json = Json::default();
        json.object(|json| {
            json.key("text").string(text);
            json.key("list").array(|json| {
                json.null();
                json.boolean(true);
                json.whole(-7);
            });
            json.key("empty").object(|_| {});
        });
        let read: serde_json::Value = serde_json::from_slice(&json.into_bytes()).unwrap();
        assert_eq!(
            read,
            serde_json::json!({ "text": text, "list": [null, true, -7], "empty": {} })
        );
    }
}
