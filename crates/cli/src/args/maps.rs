//! Arguments of the commands on maps: `route`, `serve`, `prepare` and `costmap`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

use super::values::*;

/// Map and routing profile.
#[derive(Debug, ClapArgs)]
pub struct RoadArgs {
    /// The map (.osm or .osm.pbf), or a graph file made by `prepare`
    #[arg(long)]
    pub map: PathBuf,
    /// Routing profile: delivery, foot, car, or a TOML file
    #[arg(long, default_value = "delivery")]
    pub profile: String,
}

/// Arguments of `route`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench route --map city.osm.pbf 7.4197,43.7314 7.4246,43.7387
  openbench route --map city.osm.pbf --profile foot --steps 7.4197,43.7314 7.4246,43.7387
  openbench route --map city.osm.pbf --profile mine.toml 7.4197,43.7314 7.4246,43.7387")]
pub struct RouteArgs {
    /// Map and profile
    #[command(flatten)]
    pub roads: RoadArgs,
    /// Include turn-by-turn steps
    #[arg(long)]
    pub steps: bool,
    /// Largest number of alternative routes
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub alternatives: usize,
    /// Largest distance of a road from a point, metres
    #[arg(long, default_value_t = 1000.0, value_name = "M", value_parser = metres)]
    pub radius: f64,
    /// Points of the route, LON,LAT each
    #[arg(
        required = true,
        num_args = 2..,
        value_name = "LON,LAT",
        // Negative degrees begin with a hyphen.
        allow_hyphen_values = true,
        value_parser = lonlat
    )]
    pub places: Vec<openbench_core::LonLat>,
}

/// Arguments of `serve`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench serve --map city.osm.pbf --profile foot
  curl 'http://127.0.0.1:5000/route/v1/foot/7.4197,43.7314;7.4246,43.7387?steps=true'

Ctrl-C or a TERM signal stops the server after the open requests are answered.")]
pub struct ServeArgs {
    /// Map and profile
    #[command(flatten)]
    pub roads: RoadArgs,
    /// Address to listen on; port 0 takes any free port
    #[arg(long, default_value = "127.0.0.1:5000", value_name = "ADDRESS")]
    pub listen: std::net::SocketAddr,
    /// Worker threads [default: number of processors]
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Most points of a route
    #[arg(long, default_value_t = 500, value_name = "N")]
    pub max_route_places: usize,
    /// Most points of a table
    #[arg(long, default_value_t = 100, value_name = "N")]
    pub max_table_places: usize,
}

/// Arguments of `prepare`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench prepare --map city.osm.pbf --out city.graph
  openbench serve --map city.graph --profile foot

The file serves every profile; weights are computed when it is opened.")]
pub struct PrepareArgs {
    /// The map (.osm or .osm.pbf)
    #[arg(long)]
    pub map: PathBuf,
    /// The file to write
    #[arg(long)]
    pub out: PathBuf,
    /// Largest number of vertices in a cell of each layer, smallest cells first [default: 32, and
    /// eight times as many in each layer above, up to 8388608]
    #[arg(long, value_delimiter = ',', value_name = "N,N,...")]
    pub cells: Vec<usize>,
}

/// A part of a map, and its georeference.
#[derive(Debug, ClapArgs)]
pub struct CutArgs {
    /// Cut out the square around this point
    #[arg(long, value_name = "LON,LAT", allow_hyphen_values = true, value_parser = lonlat)]
    pub around: Option<openbench_core::LonLat>,
    /// Half the side of that square, metres
    #[arg(
        long,
        value_name = "M",
        default_value_t = 250.0,
        requires = "around",
        value_parser = radius
    )]
    pub radius: f64,
    /// Cut out a rectangle, degrees
    #[arg(
        long,
        value_name = "WEST,SOUTH,EAST,NORTH",
        allow_hyphen_values = true,
        conflicts_with = "around",
        value_parser = window
    )]
    pub bbox: Option<openbench_osm::Window>,
    /// Georeference of the map: UTM zone, and the metres that are added to easting and northing,
    /// such as utm:50N,-500000,-4483000 [default: UTM around its middle]
    #[arg(long)]
    pub georef: Option<openbench_core::Georeference>,
}

impl CutArgs {
    /// The part that is cut out, if not all of the map is wanted.
    pub fn window(&self) -> anyhow::Result<Option<openbench_osm::Window>> {
        Ok(match self.around {
            Some(middle) => Some(openbench_osm::Window::around(middle, self.radius)?),
            None => self.bbox,
        })
    }
}

/// Arguments of `costmap`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Buildings, walls, fences and water are occupied; roads, pavements and grass are free; all else
is unknown. Cells have sides of 10 cm, and larger ones beyond 250 m a side. Beside FILE.yaml an
image FILE.pgm is written, in the format of Nav2's map_server.

Example:
  openbench costmap --map city.osm.pbf --around 7.4197,43.7314 --radius 100 --out city.yaml
  ros2 run nav2_map_server map_server --ros-args -p yaml_filename:=city.yaml")]
pub struct CostmapArgs {
    /// The map (.osm or .osm.pbf)
    #[arg(long)]
    pub map: PathBuf,
    /// The file to write; its image is written beside it
    #[arg(long, value_name = "FILE.yaml", value_parser = yaml_file)]
    pub out: PathBuf,
    /// Part of the map
    #[command(flatten)]
    pub cut: CutArgs,
}
