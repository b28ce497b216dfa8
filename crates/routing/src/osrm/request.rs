//! Requests of OSRM's HTTP API, version 1: `/{service}/v1/{profile}/{coordinates}?{options}`.

use super::failure::Failure;
use super::query::{Setting, bearing_range, number, options, places, radius, shown};
use crate::geo::Place;
use crate::position::SnapOptions;

/// A request.
#[derive(Debug, Clone, PartialEq)]
pub enum Request {
    /// The route through some places.
    Route(RouteRequest),
    /// Roads near a place.
    Nearest(NearestRequest),
    /// Durations and distances between places.
    Table(TableRequest),
}

/// The places of a request.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RequestPlaces {
    /// Their positions.
    pub coordinates: Vec<Place>,
    /// How each of them is snapped to the network; as many as places.
    pub snap: Vec<SnapOptions>,
    /// Whether the answer contains hints.
    pub hints: bool,
    /// Whether the places are left out of the answer.
    pub skip_waypoints: bool,
}

/// The format of lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Geometries {
    /// Encoded with five decimal places.
    #[default]
    Polyline,
    /// Encoded with six decimal places.
    Polyline6,
    /// As GeoJSON.
    GeoJson,
}

/// How much of a route's line is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Overview {
    /// As many points as can be distinguished when the whole line is displayed.
    #[default]
    Simplified,
    /// All points.
    Full,
    /// All points, leg by leg.
    ByLegs,
    /// None.
    False,
}

/// What is reported for every segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Annotations {
    /// Seconds.
    pub duration: bool,
    /// Metres.
    pub distance: bool,
    /// OSM nodes.
    pub nodes: bool,
    /// Metres per second.
    pub speed: bool,
    /// The weight.
    pub weight: bool,
    /// Where its speed comes from.
    pub datasources: bool,
}

/// Asks for a route.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RouteRequest {
    /// The places to visit.
    pub places: RequestPlaces,
    /// How many alternatives are wanted.
    pub alternatives: usize,
    /// Whether to give instructions.
    pub steps: bool,
    /// What to report for every segment.
    pub annotations: Annotations,
    /// The format of lines.
    pub geometries: Geometries,
    /// How much of the whole line is written.
    pub overview: Overview,
    /// Whether the route goes straight on at places in between. By default the profile decides.
    pub continue_straight: Option<bool>,
    /// Which places divide legs; all if none are named.
    pub waypoints: Vec<usize>,
}

/// Asks for roads near places.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NearestRequest {
    /// The places.
    pub places: RequestPlaces,
    /// How many stretches of road per place.
    pub number: usize,
}

/// Asks for durations and distances between places.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TableRequest {
    /// The places.
    pub places: RequestPlaces,
    /// Indices of the sources; all if none are named.
    pub sources: Vec<usize>,
    /// Indices of the targets; all if none are named.
    pub destinations: Vec<usize>,
    /// Whether durations are wanted.
    pub duration: bool,
    /// Whether distances are wanted.
    pub distance: bool,
    /// Metres per second along a straight line where there is no route.
    pub fallback_speed: Option<f64>,
    /// Whether that line connects the places on the network, not those of the request.
    pub fallback_snapped: bool,
    /// A factor for durations.
    pub scale: f64,
}

/// The limits of requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// The most places of a route.
    pub route: usize,
    /// The most places of a table.
    pub table: usize,
    /// The most stretches of road near a place.
    pub nearest: usize,
    /// The most alternatives.
    pub alternatives: usize,
}

impl Default for Limits {
    /// The limits of `osrm-routed`.
    fn default() -> Self {
        Self {
            route: 500,
            table: 100,
            nearest: 100,
            alternatives: 3,
        }
    }
}

impl Request {
    /// Parses the path and the query of an address.
    ///
    /// # Errors
    /// OSRM's code and message, if the address is malformed or exceeds a limit.
    pub fn parse(target: &str, limits: &Limits) -> Result<Self, Failure> {
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let parts: Vec<&str> = path
            .strip_prefix('/')
            .unwrap_or_default()
            .splitn(4, '/')
            .collect();
        let malformed = || {
            let message = format!(
                "URL string malformed close to position 1: \"{}\"",
                shown(path)
            );
            Failure::new("InvalidUrl", message)
        };
        let [service, version, profile, coordinates] = parts[..] else {
            return Err(malformed());
        };
        // Any `v` with a number is well-formed. Versions other than 1 are refused below by another
        // code, as by OSRM.
        let version_is_one = version
            .strip_prefix('v')
            .is_some_and(|v| v.bytes().all(|b| b.is_ascii_digit()) && !v.is_empty());
        if !version_is_one || profile.is_empty() {
            return Err(malformed());
        }
        if !["route", "nearest", "table"].contains(&service) {
            return Err(Failure::new(
                "InvalidService",
                format!("Service {} not found!", shown(service)),
            ));
        }
        if version != "v1" {
            return Err(Failure::new(
                "InvalidVersion",
                format!("Service {} not found!", shown(service)),
            ));
        }
        // Errors give offsets in the whole address, as OSRM's do.
        let position = path.len() - coordinates.len();
        let places = places(coordinates, position)?;
        let options = options(query, path.len() + 1)?;
        match service {
            "route" => RouteRequest::new(places, &options, limits).map(Self::Route),
            "nearest" => NearestRequest::new(places, &options, limits).map(Self::Nearest),
            _ => TableRequest::new(places, &options, limits).map(Self::Table),
        }
    }
}

impl RequestPlaces {
    fn new(coordinates: Vec<Place>) -> Self {
        let snap = vec![SnapOptions::default(); coordinates.len()];
        Self {
            coordinates,
            snap,
            hints: true,
            skip_waypoints: false,
        }
    }

    /// Stores an option that all services share. Returns whether it is one.
    fn take(&mut self, option: &Setting<'_>) -> Result<bool, Failure> {
        match option.key {
            "generate_hints" => self.hints = option.boolean()?,
            "skip_waypoints" => self.skip_waypoints = option.boolean()?,
            // Hints are accepted, but places are looked up nevertheless.
            "hints" => drop(self.list(option)?),
            "approaches" => {
                let known = |word: &&str| ["", "curb", "opposite", "unrestricted"].contains(word);
                if !self.list(option)?.iter().all(known) {
                    return Err(option.fail());
                }
            }
            "radiuses" => {
                let radiuses = self.list(option)?;
                for (snap, text) in self.snap.iter_mut().zip(radiuses) {
                    snap.radius = radius(text).ok_or_else(|| option.fail())?;
                }
            }
            "bearings" => {
                let bearings = self.list(option)?;
                for (snap, text) in self.snap.iter_mut().zip(bearings) {
                    let range = bearing_range(text);
                    if range.is_none() && !text.is_empty() {
                        return Err(option.fail());
                    }
                    snap.bearing = range;
                }
            }
            "snapping" if ["default", "any"].contains(&option.value.as_str()) => {}
            "exclude" => {
                return Err(Failure::new(
                    "InvalidValue",
                    "Exclude flag combination is not supported.",
                ));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// One value for each place.
    fn list<'a>(&self, option: &'a Setting<'_>) -> Result<Vec<&'a str>, Failure> {
        let values: Vec<&str> = option.value.split(';').collect();
        if values.len() == self.coordinates.len() {
            return Ok(values);
        }
        let message = format!(
            "Number of elements in {} size {} does not match coordinate size {}",
            option.key,
            values.len(),
            self.coordinates.len()
        );
        Err(Failure::new("InvalidOptions", message))
    }

    fn at_least_two(&self) -> Result<(), Failure> {
        if self.coordinates.len() >= 2 {
            return Ok(());
        }
        Err(Failure::new(
            "InvalidOptions",
            "Number of coordinates needs to be at least two.",
        ))
    }
}

fn too_big(what: &str, count: usize, limit: usize) -> Result<(), Failure> {
    if count <= limit {
        return Ok(());
    }
    Err(Failure::new(
        "TooBig",
        format!("{what} {count} is higher than current maximum ({limit})"),
    ))
}

impl RouteRequest {
    /// A request for the route through some places, without options.
    pub fn through(places: Vec<Place>) -> Self {
        Self {
            places: RequestPlaces::new(places),
            ..Self::default()
        }
    }

    fn new(places: Vec<Place>, options: &[Setting<'_>], limits: &Limits) -> Result<Self, Failure> {
        let mut request = Self::through(places);
        request.places.at_least_two()?;
        too_big(
            "Number of entries",
            request.places.coordinates.len(),
            limits.route,
        )?;
        for option in options {
            // Options that all services share come first; what they do not know is the service's
            // own.
            if request.places.take(option)? {
                continue;
            }
            match (option.key, option.value.as_str()) {
                // OSRM takes a number of alternatives or a boolean, and `true` asks for one.
                ("alternatives", "true") => request.alternatives = 1,
                ("alternatives", "false") => request.alternatives = 0,
                ("alternatives", _) => request.alternatives = option.whole()?,
                ("steps", _) => request.steps = option.boolean()?,
                ("annotations", words) => {
                    request.annotations = annotations(words).ok_or_else(|| option.fail())?
                }
                ("geometries", "polyline") => request.geometries = Geometries::Polyline,
                ("geometries", "polyline6") => request.geometries = Geometries::Polyline6,
                ("geometries", "geojson") => request.geometries = Geometries::GeoJson,
                ("overview", "simplified") => request.overview = Overview::Simplified,
                ("overview", "full") => request.overview = Overview::Full,
                ("overview", "by_legs") => request.overview = Overview::ByLegs,
                ("overview", "false") => request.overview = Overview::False,
                ("continue_straight", "default") => request.continue_straight = None,
                ("continue_straight", _) => request.continue_straight = Some(option.boolean()?),
                ("waypoints", _) => request.waypoints = option.indices()?,
                _ => return Err(option.fail()),
            }
        }
        // Once all options are read: of an option that is given twice the later value counts.
        if request.alternatives > limits.alternatives {
            let limit = limits.alternatives;
            let message = format!(
                "Requested number of alternatives is higher than current maximum ({limit})"
            );
            return Err(Failure::new("TooBig", message));
        }
        request.check_waypoints()?;
        Ok(request)
    }

    fn check_waypoints(&self) -> Result<(), Failure> {
        let (waypoints, last) = (&self.waypoints, self.places.coordinates.len() - 1);
        if waypoints.is_empty() {
            return Ok(());
        }
        if waypoints.first() != Some(&0) || waypoints.last() != Some(&last) {
            return Err(Failure::new(
                "InvalidValue",
                "First and last coordinates must be specified as waypoints.",
            ));
        }
        if waypoints.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(Failure::new(
                "InvalidValue",
                "Waypoints must be in ascending order.",
            ));
        }
        Ok(())
    }
}

fn annotations(words: &str) -> Option<Annotations> {
    let mut annotations = Annotations::default();
    for word in words.split(',') {
        match word {
            "true" => {
                annotations = Annotations {
                    duration: true,
                    distance: true,
                    nodes: true,
                    speed: true,
                    weight: true,
                    datasources: true,
                }
            }
            "false" => {}
            "duration" => annotations.duration = true,
            "distance" => annotations.distance = true,
            "nodes" => annotations.nodes = true,
            "speed" => annotations.speed = true,
            "weight" => annotations.weight = true,
            "datasources" => annotations.datasources = true,
            _ => return None,
        }
    }
    Some(annotations)
}

impl NearestRequest {
    fn new(places: Vec<Place>, options: &[Setting<'_>], limits: &Limits) -> Result<Self, Failure> {
        let mut request = Self {
            places: RequestPlaces::new(places),
            number: 1,
        };
        for option in options {
            if request.places.take(option)? {
                continue;
            }
            match option.key {
                "number" => request.number = option.whole()?,
                _ => return Err(option.fail()),
            }
        }
        if request.number == 0 {
            return Err(Failure::new(
                "InvalidOptions",
                "The number of results must be at least one.",
            ));
        }
        too_big("Number of results", request.number, limits.nearest)?;
        too_big(
            "Number of coordinates",
            request.places.coordinates.len(),
            limits.nearest,
        )?;
        Ok(request)
    }
}

impl TableRequest {
    /// A request for the durations between all places.
    pub fn between(places: Vec<Place>) -> Self {
        Self {
            places: RequestPlaces::new(places),
            duration: true,
            scale: 1.0,
            ..Self::default()
        }
    }

    fn new(places: Vec<Place>, options: &[Setting<'_>], limits: &Limits) -> Result<Self, Failure> {
        let mut request = Self::between(places);
        request.places.at_least_two()?;
        if request.places.coordinates.len() > limits.table {
            return Err(Failure::new("TooBig", "Too many table coordinates"));
        }
        let positive = |option: &Setting<'_>| {
            let value = number(&option.value).ok_or_else(|| option.fail())?;
            let low = || Failure::new("InvalidOptions", format!("{} must be > 0", option.key));
            // A number out of range is another error than a text that is no number.
            (value > 0.0).then_some(value).ok_or_else(low)
        };
        for option in options {
            if request.places.take(option)? {
                continue;
            }
            match option.key {
                "sources" => request.sources = option.indices()?,
                "destinations" => request.destinations = option.indices()?,
                "annotations" => {
                    let words: Vec<&str> = option.value.split(',').collect();
                    if !words
                        .iter()
                        .all(|word| ["duration", "distance"].contains(word))
                    {
                        return Err(option.fail());
                    }
                    (request.duration, request.distance) =
                        (words.contains(&"duration"), words.contains(&"distance"));
                }
                "fallback_speed" => request.fallback_speed = Some(positive(option)?),
                "fallback_coordinate" if ["input", "snapped"].contains(&option.value.as_str()) => {
                    request.fallback_snapped = option.value == "snapped";
                }
                "scale_factor" => request.scale = positive(option)?,
                _ => return Err(option.fail()),
            }
        }
        let count = request.places.coordinates.len();
        // Bounds the table by the square of the places, of which there is a limit: indices may
        // repeat.
        if request.sources.len().max(request.destinations.len()) > count {
            return Err(Failure::new(
                "InvalidOptions",
                "There are more sources or destinations than coordinates.",
            ));
        }
        if request
            .sources
            .iter()
            .chain(&request.destinations)
            .any(|index| *index >= count)
        {
            return Err(Failure::new(
                "InvalidOptions",
                "A source or destination is not among the coordinates.",
            ));
        }
        Ok(request)
    }
}
