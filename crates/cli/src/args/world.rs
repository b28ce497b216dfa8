//! Arguments of `world` and its subcommands.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};

use super::values::*;
use super::*;

/// Arguments of `world`.
#[derive(Debug, ClapArgs)]
pub struct WorldArgs {
    /// What to do
    #[command(subcommand)]
    pub command: WorldCommand,
}

/// Commands about worlds.
#[derive(Debug, Subcommand)]
pub enum WorldCommand {
    /// Make a world of any OSM map and a seed, with deliveries in it
    Generate(GenerateArgs),
    /// Make such a folder of a Gazebo world with an OSM map
    Import(ImportArgs),
    /// Draw a picture of a world, from above or from a place in it
    Show(ShowArgs),
}

/// Arguments of `world generate`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
The folder holds world.toml (what the world is made from), map.osm (the whole map), public.osm (the map that agents get,
without doors) and suite.toml (the deliveries).

Examples:
  openbench world generate --map campus.osm --seed 3 --out worlds/campus
  openbench world generate --map city.osm.pbf --around 7.4197,43.7314 --radius 300 --out worlds/city
  openbench world generate --map city.osm.pbf --bbox 7.414,43.727,7.424,43.734 --parked-cars 1 --out worlds/jam
  openbench world show worlds/city && openbench run worlds/city")]
pub struct GenerateArgs {
    /// The map (.osm or .osm.pbf)
    #[arg(long)]
    pub map: PathBuf,
    /// What the map leaves open is drawn from it: colours, cars, greenery, deliveries
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=i64::MAX as u64))]
    pub seed: u64,
    /// The folder to make; an earlier world there is replaced
    #[arg(long)]
    pub out: PathBuf,
    /// Name of the world in results; by default that of the folder
    #[arg(long)]
    pub name: Option<String>,
    /// Which part of the map
    #[command(flatten)]
    pub cut: CutArgs,
    /// Where the robot starts, metres and degrees; by default a clear place near the middle from which most doors are reached
    #[arg(long, value_name = "X,Y,YAW", allow_hyphen_values = true, value_parser = pose)]
    pub start: Option<openbench_core::Pose2>,
    /// Share of the parking places with a car in them, 0 to 1
    #[arg(long, default_value_t = 0.6, value_parser = share)]
    pub parked_cars: f64,
    /// How many trees and shrubs are added to the map's own, 0 to 1
    #[arg(long, default_value_t = 0.5, value_parser = share)]
    pub planting: f64,
    /// Only doors that the map has; else every house gets one towards the street
    #[arg(long)]
    pub mapped_doors_only: bool,
    /// What deliveries there are
    #[command(flatten)]
    pub drawn: DrawArgs,
}

/// Arguments of `world import`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench world import --world small_osm.world --map small.osm --models gazebo_models --out worlds/published")]
pub struct ImportArgs {
    /// The Gazebo world (SDF)
    #[arg(long)]
    pub world: PathBuf,
    /// The OSM map of that world
    #[arg(long)]
    pub map: PathBuf,
    /// Folder in which `model://` is looked up (may be given more than once)
    #[arg(long)]
    pub models: Vec<PathBuf>,
    /// How the world lies on the Earth; by default UTM around the middle of the map
    #[arg(long)]
    pub georef: Option<openbench_core::Georeference>,
    /// Where the robot starts, metres and degrees in the world's own frame; by default its origin, or before a door if that is far away
    #[arg(long, value_name = "X,Y,YAW", allow_hyphen_values = true, value_parser = pose)]
    pub start: Option<openbench_core::Pose2>,
    /// What the deliveries are drawn from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The folder to make; an earlier world there is replaced
    #[arg(long)]
    pub out: PathBuf,
    /// What deliveries there are
    #[command(flatten)]
    pub drawn: DrawArgs,
}

/// Which deliveries a new world gets.
#[derive(Debug, Clone, ClapArgs)]
pub struct DrawArgs {
    /// Single deliveries, and sequences of so many doors
    #[arg(long, value_names = ["SINGLES", "SEQUENCES", "LENGTH"], num_args = 3, default_values_t = [8, 1, 3])]
    pub draw: Vec<u16>,
    /// How far from the start doors may be, metres in a straight line
    #[arg(long, value_name = "M", default_value_t = 250.0, value_parser = radius)]
    pub reach: f64,
}

/// Arguments of `world show`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench world show large --from 0,0,90 --out view.jpg --quality 80
  openbench world show worlds/city --above 120 --out city.png
  openbench world show small --from 0,0,0 --depth depth.png --classes classes.png --instances things.png

Beside an image of classes or instances lies its legend: the same name, ending in .json.")]
pub struct ShowArgs {
    /// A built-in world, or the folder of a generated or imported one
    #[arg(conflicts_with = "world")]
    pub name: Option<String>,
    /// A Gazebo world (SDF)
    #[arg(long, requires = "map")]
    pub world: Option<PathBuf>,
    /// The OSM map of that world
    #[arg(long)]
    pub map: Option<PathBuf>,
    /// Folder in which `model://` is looked up
    #[arg(long)]
    pub models: Vec<PathBuf>,
    /// How the world lies on the Earth
    #[arg(long)]
    pub georef: Option<String>,
    /// Look as the robot's camera does from `X,Y,YAW` (metres, degrees) instead of from above
    #[arg(long, value_name = "X,Y,YAW", allow_hyphen_values = true, value_parser = pose)]
    pub from: Option<openbench_core::Pose2>,
    /// From above, show only what is this near to the start, metres
    #[arg(long, value_name = "M", conflicts_with = "from", value_parser = radius)]
    pub above: Option<f64>,
    /// The picture: PNG, or JPEG if the name ends in .jpg
    #[arg(long, default_value = "world.png")]
    pub out: PathBuf,
    /// Quality of a JPEG, 1 to 100
    #[arg(long, default_value_t = 90, value_parser = clap::value_parser!(u8).range(1..=100))]
    pub quality: u8,
    /// Leave out the shadows that things throw, as the robot's camera does
    #[arg(long)]
    pub no_shadows: bool,
    /// People who walk about
    #[arg(long, default_value_t = 0)]
    pub pedestrians: u16,
    /// Cars that drive about
    #[arg(long, default_value_t = 0)]
    pub cars: u16,
    /// Seconds that they have walked and driven
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(0..=3600))]
    pub after: u16,
    /// Write depths too: 16-bit PNG, millimetres along the optical axis; 0 where nothing is, 65535 from there on
    #[arg(long, value_name = "FILE")]
    pub depth: Option<PathBuf>,
    /// Write the class of each pixel too: PNG in the legend's colours
    #[arg(long, value_name = "FILE")]
    pub classes: Option<PathBuf>,
    /// Write the thing that each pixel shows too: PNG in the legend's colours, a colour of its own for each thing
    #[arg(long, value_name = "FILE")]
    pub instances: Option<PathBuf>,
}
