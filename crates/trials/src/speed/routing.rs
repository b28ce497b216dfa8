//! Speed of routing.

use std::path::Path;
use std::time::Duration;

use cpu_time::ProcessTime;
use openbench_core::LonLat;
use openbench_osm::stream::Source;
use openbench_routing::geo::Place;
use openbench_routing::osrm::{
    Geometries, Limits, NearestRequest, Overview, Request, RequestPlaces, RouteRequest, Service,
    ServiceMemory, TableRequest,
};
use openbench_routing::overlay::FAR;
use openbench_routing::search::{End, Path as RoutePath, Workspace};
use openbench_routing::{Metric, Profile, Roads};
use serde::Serialize;

use super::{fastest, peak_memory_mb};
use openbench_bench::BenchError;

/// Repetitions of each measurement, of which the fastest counts.
const REPETITIONS: usize = 3;
/// Number of origins, and of destinations, of the table.
const TABLE_SIZE: usize = 100;
/// Number of random queries in a dump.
const DUMPED_QUERIES: u64 = 1000;

/// The measured times, all CPU time; requests run on one thread.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RoutingSpeed {
    /// Number of vertices of the road network.
    pub vertices: usize,
    /// Number of edges of the road network.
    pub edges: usize,
    /// Number of origin-destination pairs.
    pub pairs: usize,
    /// Number of pairs without a route.
    pub pairs_without_route: usize,
    /// Route request with distance and duration as JSON, snapping included: median, microseconds.
    pub route_us_p50: f64,
    /// The same: 99th percentile.
    pub route_us_p99: f64,
    /// Route request with steps and the geometry as GeoJSON: median, microseconds.
    pub steps_us_p50: f64,
    /// The same: 99th percentile.
    pub steps_us_p99: f64,
    /// Request for the nearest position on the network, as JSON: median, microseconds.
    pub nearest_us_p50: f64,
    /// The same: 99th percentile.
    pub nearest_us_p99: f64,
    /// Table of durations from the first 100 origins to the first 100 destinations, as JSON,
    /// milliseconds.
    pub table_100_ms: f64,
    /// Preparation from the map file to the first route, all threads, seconds.
    pub build_seconds: f64,
    /// Customization of the same network for another profile, all threads, seconds.
    pub customize_seconds: f64,
    /// Peak memory of the preparation, megabytes; null if the system does not report it.
    pub build_peak_memory_mb: Option<f64>,
    /// Peak memory of the whole measurement, megabytes.
    pub peak_memory_mb: Option<f64>,
    /// The route of each pair.
    #[serde(skip)]
    pub answers: Vec<RouteAnswer>,
}

/// Length and duration of a route; NaN without a route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RouteAnswer {
    /// Length, metres.
    pub distance_m: f64,
    /// Duration, seconds.
    pub duration_s: f64,
}

/// Reads origin-destination pairs: rows of `lon,lat,lon,lat` in degrees. A heading is skipped.
///
/// # Errors
/// A file that cannot be read, or the line of the first row that is not in this form.
pub fn read_pairs(path: &Path) -> Result<Vec<[Place; 2]>, BenchError> {
    let bad = |line: usize| {
        BenchError::bad_file(
            path,
            format!("line {line} is not lon,lat,lon,lat in degrees"),
        )
    };
    let text =
        openbench_core::input::read_text(path).map_err(|error| BenchError::file(path, error))?;
    let mut pairs = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        if line.trim().is_empty() || (number == 1 && line.contains(|c: char| c.is_alphabetic())) {
            continue;
        }
        let numbers: Vec<f64> = line
            .split(',')
            .filter_map(|word| word.trim().parse().ok())
            .collect();
        let &[a, b, c, d] = &numbers[..] else {
            return Err(bad(number));
        };
        let place = |lon, lat| Place::new(LonLat::new(lon, lat)).ok_or_else(|| bad(number));
        pairs.push([place(a, b)?, place(c, d)?]);
    }
    if pairs.is_empty() {
        return Err(BenchError::bad_file(
            path,
            "it has no pairs; write lon,lat,lon,lat in each line",
        ));
    }
    Ok(pairs)
}

/// Measures requests over pairs of places on a map with a profile.
///
/// With `dump`, the graph is written to that folder for programs that read no maps: `tail`, `head`
/// and `weight` of the arcs, `lat` and `lon` of the vertices, and 1,000 `queries` (from, to,
/// weight), all as numbers of four bytes.
///
/// # Errors
/// A map that cannot be read, a profile that does not fit, or a file that cannot be written.
pub fn measure(
    map: &Path,
    profile: Profile,
    pairs: &[[Place; 2]],
    dump: Option<&Path>,
) -> Result<RoutingSpeed, BenchError> {
    let began = ProcessTime::now();
    let source = Source::open(map).map_err(|e| BenchError::bad_file(map, e))?;
    let roads =
        Roads::read(&source, &Default::default()).map_err(|e| BenchError::bad_file(map, e))?;
    // As in a server, which does not need the map any more: it would count in the peak memory.
    drop(source);
    let metric = Metric::new(&roads, profile.clone()).map_err(|e| BenchError::bad_file(map, e))?;
    let build = began.elapsed();
    let build_peak_memory_mb = peak_memory_mb();
    let began = ProcessTime::now();
    // Without `black_box` the compiler may leave out work whose result is not used.
    drop(std::hint::black_box(
        Metric::new(&roads, profile).map_err(|e| BenchError::bad_file(map, e))?,
    ));
    let customize = began.elapsed();
    if let Some(folder) = dump {
        dump_graph(folder, &roads, &metric)?;
    }
    let service = Service {
        roads,
        metric,
        limits: Limits::default(),
    };
    // One for all requests, as each worker thread of `serve` has one.
    let memory = &mut ServiceMemory::default();

    let routes = pairs.iter().map(|pair| route_request(pair, false));
    let [route_us_p50, route_us_p99] = percentiles_of(&service, routes, memory);
    let steps = pairs.iter().map(|pair| route_request(pair, true));
    let [steps_us_p50, steps_us_p99] = percentiles_of(&service, steps, memory);
    let nearest = pairs.iter().map(nearest_request);
    let [nearest_us_p50, nearest_us_p99] = percentiles_of(&service, nearest, memory);
    let table = fastest(REPETITIONS, || {
        drop(std::hint::black_box(
            service.table(&table_request(pairs), memory),
        ))
    });
    let answers: Vec<_> = pairs
        .iter()
        .map(|pair| answer(&service, &route_request(pair, false), memory))
        .collect();
    Ok(RoutingSpeed {
        vertices: service.roads.network.vertices.len(),
        edges: service.roads.network.edge_count(),
        pairs: pairs.len(),
        pairs_without_route: answers.iter().filter(|a| a.distance_m.is_nan()).count(),
        route_us_p50,
        route_us_p99,
        steps_us_p50,
        steps_us_p99,
        nearest_us_p50,
        nearest_us_p99,
        table_100_ms: table.as_secs_f64() * 1e3,
        build_seconds: build.as_secs_f64(),
        customize_seconds: customize.as_secs_f64(),
        build_peak_memory_mb,
        peak_memory_mb: peak_memory_mb(),
        answers,
    })
}

/// Places of a request without hints.
fn without_hints(places: &[Place]) -> RequestPlaces {
    RequestPlaces {
        hints: false,
        ..RouteRequest::through(places.to_vec()).places
    }
}

fn route_request(pair: &[Place; 2], steps: bool) -> Request {
    let overview = if steps {
        Overview::Full
    } else {
        Overview::False
    };
    Request::Route(RouteRequest {
        places: without_hints(pair),
        steps,
        overview,
        geometries: Geometries::GeoJson,
        ..Default::default()
    })
}

fn nearest_request(pair: &[Place; 2]) -> Request {
    Request::Nearest(NearestRequest {
        places: without_hints(&pair[..1]),
        number: 1,
    })
}

/// The median and the 99th percentile of the times of requests, microseconds.
fn percentiles_of(
    service: &Service,
    requests: impl Iterator<Item = Request>,
    memory: &mut ServiceMemory,
) -> [f64; 2] {
    let requests: Vec<Request> = requests.collect();
    percentiles(requests.iter().map(|request| {
        fastest(REPETITIONS, || {
            drop(std::hint::black_box(service.body(request, memory)))
        })
    }))
}

fn dump_graph(folder: &Path, roads: &Roads, metric: &Metric) -> Result<(), BenchError> {
    let file = |source| BenchError::File {
        path: folder.to_owned(),
        source,
    };
    std::fs::create_dir_all(folder).map_err(file)?;
    let write = |name: &str, numbers: Vec<u32>| {
        let bytes: Vec<u8> = numbers.into_iter().flat_map(u32::to_le_bytes).collect();
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(|source| BenchError::File { path, source })
    };
    let graph = metric.searched(roads);
    let (out, weights) = (&graph.overlay.out, &graph.weights.out);
    // Arcs that the profile closes have the weight `FAR`.
    let open: Vec<(u32, usize)> = out
        .iter()
        .filter(|(_, slot)| weights[*slot] < FAR)
        .collect();
    write("tail.u32", open.iter().map(|(tail, _)| *tail).collect())?;
    write(
        "head.u32",
        open.iter().map(|(_, slot)| out.head[*slot]).collect(),
    )?;
    write(
        "weight.u32",
        open.iter().map(|(_, slot)| weights[*slot]).collect(),
    )?;
    let position = |place: &Place| place.position();
    let vertices = &roads.network.vertices;
    write(
        "lat.f32",
        vertices
            .iter()
            .map(|v| (position(v).lat as f32).to_bits())
            .collect(),
    )?;
    write(
        "lon.f32",
        vertices
            .iter()
            .map(|v| (position(v).lon as f32).to_bits())
            .collect(),
    )?;
    let (mut workspace, mut path) = (Workspace::default(), RoutePath::default());
    let count = vertices.len() as u64;
    let queries = (0..DUMPED_QUERIES).flat_map(|i| {
        // A linear congruential generator with the constants of D. Knuth's MMIX.
        let draw = |i: u64| {
            // The upper bits: the lowest bits of such a generator repeat after few numbers.
            (i.wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407)
                >> 33)
                % count
        };
        let [from, to] = [draw(2 * i) as u32, draw(2 * i + 1) as u32];
        let ends = [from, to].map(|state| [End { state, weight: 0 }]);
        [
            from,
            to,
            workspace
                .route(graph, &ends[0], &ends[1], &mut path)
                .unwrap_or(u32::MAX),
        ]
    });
    write("queries.u32", queries.collect())
}

/// The request for a table from the first origins to the first destinations.
fn table_request(pairs: &[[Place; 2]]) -> TableRequest {
    let count = pairs.len().min(TABLE_SIZE);
    let places = (0..2)
        .flat_map(|end| pairs[..count].iter().map(move |pair| pair[end]))
        .collect();
    let mut request = TableRequest::between(places);
    (request.sources, request.destinations) = ((0..count).collect(), (count..2 * count).collect());
    request.places.hints = false;
    request
}

/// Distance in metres and duration in seconds of a route; NaN without a route.
fn answer(service: &Service, request: &Request, memory: &mut ServiceMemory) -> RouteAnswer {
    let body = service.body(request, memory).unwrap_or_default();
    let json: serde_json::Value = serde_json::from_slice(&body).unwrap_or_default();
    let route = &json["routes"][0];
    RouteAnswer {
        distance_m: route["distance"].as_f64().unwrap_or(f64::NAN),
        duration_s: route["duration"].as_f64().unwrap_or(f64::NAN),
    }
}

/// The median and the 99th percentile, microseconds.
fn percentiles(times: impl Iterator<Item = Duration>) -> [f64; 2] {
    let mut times: Vec<Duration> = times.collect();
    times.sort_unstable();
    [0.5, 0.99].map(|share| {
        let index = (times.len() as f64 * share) as usize;
        times
            .get(index.min(times.len().saturating_sub(1)))
            .map_or(0.0, |time| time.as_secs_f64() * 1e6)
    })
}
