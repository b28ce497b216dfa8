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
    /// Generate a world with deliveries from any OSM map and a seed
    Generate(GenerateArgs),
    /// Draw a neighbourhood by seed, with deliveries
    Draw(NeighbourhoodArgs),
    /// Import a Gazebo world with its OSM map
    Import(ImportArgs),
    /// Render a world from above or from a pose in it
    Show(ShowArgs),
    /// Draw the public map of a suite over its world: what is wrong with it
    Map(PublicMapArgs),
    /// Draw door plates as streets have them on a contact sheet
    Plates(PlatesArgs),
}

/// Arguments of `world map`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench world map medium --condition map=poor --seed 3 --out map.svg
  openbench world map worlds/city --condition map.shift_m=3 --osm wrong.osm")]
pub struct PublicMapArgs {
    /// A built-in suite (small, medium, large), a suite file (.toml), or a world folder
    pub suite: String,
    /// Seed of what is drawn, as of a run: with small, medium and large also of the neighbourhood
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Seed of the conditions alone [default: that of --seed]
    #[arg(long, value_name = "SEED")]
    pub noise_seed: Option<u64>,
    /// A level, such as map=city, or a number, such as map.shift_m=3; may be repeated
    #[arg(long = "condition", value_name = "KEY=VALUE", value_parser = key_value)]
    pub conditions: Vec<(String, String)>,
    /// The picture
    #[arg(long, value_name = "FILE.svg", default_value = "map.svg", value_parser = svg_file)]
    pub out: PathBuf,
    /// Also write the public map that agents get
    #[arg(long, value_name = "FILE.osm", value_parser = osm_file)]
    pub osm: Option<PathBuf>,
}

/// Arguments of `world plates`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Seeds 11000 to 11999 are lettered with the typefaces that are kept for tests.

Example:
  openbench world plates --seed 10000 --out plates.png")]
pub struct PlatesArgs {
    /// Seed of what is drawn
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Number of plates
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u16).range(1..=2000))]
    pub count: u16,
    /// The picture: PNG, or JPEG if the name ends in .jpg
    #[arg(long, default_value = "plates.png", value_parser = picture_file)]
    pub out: PathBuf,
}

/// Arguments of `world generate`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
The folder holds world.toml (the recipe), map.osm (the whole map), public.osm (the map that
agents get, without doors) and suite.toml (the deliveries).

Examples:
  openbench world generate --map campus.osm --seed 3 --out worlds/campus
  openbench world generate --map city.osm.pbf --around 7.4197,43.7314 --radius 300 --out worlds/city
  openbench world generate --map city.osm.pbf --bbox 7.414,43.727,7.424,43.734 --out worlds/old
  openbench world show worlds/city && openbench run worlds/city")]
pub struct GenerateArgs {
    /// The map (.osm or .osm.pbf)
    #[arg(long)]
    pub map: PathBuf,
    /// Seed of colours, cars, greenery and deliveries
    #[arg(
        long,
        default_value_t = 1,
        // The seed is written to `world.toml`, whose integers have 63 bits.
        value_parser = clap::value_parser!(u64).range(0..=i64::MAX as u64)
    )]
    pub seed: u64,
    /// Folder for the world; an earlier world there is replaced
    #[arg(long)]
    pub out: PathBuf,
    /// Name of the world in results [default: name of the folder]
    #[arg(long)]
    pub name: Option<String>,
    /// Part of the map
    #[command(flatten)]
    pub cut: CutArgs,
    /// Start pose, metres and degrees [default: near the middle, where most doors are reachable]
    #[arg(long, value_name = "X,Y,YAW", allow_hyphen_values = true, value_parser = pose)]
    pub start: Option<openbench_core::Pose2>,
    /// Share of occupied parking spaces, 0 to 1
    #[arg(long, default_value_t = 0.6, value_parser = share)]
    pub parked_cars: f64,
    /// Amount of trees and shrubs added to those of the map, 0 to 1
    #[arg(long, default_value_t = 0.5, value_parser = share)]
    pub planting: f64,
    /// Use only mapped doors; otherwise every house gets one towards the street
    #[arg(long)]
    pub mapped_doors_only: bool,
    /// The deliveries
    #[command(flatten)]
    pub drawn: DrawArgs,
}

/// Arguments of `world draw`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
The folder is as one of `world generate`. `run medium --seed 7` needs none: it draws the same map.

Examples:
  openbench world draw medium --seed 7 --out worlds/medium-7
  openbench world show worlds/medium-7 --out medium-7.png")]
pub struct NeighbourhoodArgs {
    /// The size: small, medium or large
    pub kind: openbench_neighbourhoods::Kind,
    /// Seed of the map, of colours, cars and greenery, and of the deliveries
    #[arg(
        long,
        default_value_t = 1,
        // The seed is written to `world.toml`, whose integers have 63 bits.
        value_parser = clap::value_parser!(u64).range(0..=i64::MAX as u64)
    )]
    pub seed: u64,
    /// Folder for the world; an earlier world there is replaced
    #[arg(long)]
    pub out: PathBuf,
    /// The deliveries
    #[command(flatten)]
    pub drawn: DrawArgs,
}

/// Arguments of `world import`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Example:
  openbench world import --world small_osm.world --map small.osm \\
      --models gazebo_models --out worlds/published")]
pub struct ImportArgs {
    /// The Gazebo world (SDF)
    #[arg(long)]
    pub world: PathBuf,
    /// The OSM map of that world
    #[arg(long)]
    pub map: PathBuf,
    /// Folder with the models that `model://` names; may be repeated
    #[arg(long)]
    pub models: Vec<PathBuf>,
    /// Georeference of the world: UTM zone, and the metres that are added to easting and northing,
    /// such as utm:50N,-500000,-4483000 [default: UTM around the middle of the map]
    #[arg(long)]
    pub georef: Option<openbench_core::Georeference>,
    /// Start pose, metres and degrees in the world's frame [default: its origin, or in front of a
    /// door if that is far away]
    #[arg(long, value_name = "X,Y,YAW", allow_hyphen_values = true, value_parser = pose)]
    pub start: Option<openbench_core::Pose2>,
    /// Seed of the deliveries
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for the world; an earlier world there is replaced
    #[arg(long)]
    pub out: PathBuf,
    /// The deliveries
    #[command(flatten)]
    pub drawn: DrawArgs,
}

/// Which deliveries a new world gets.
#[derive(Debug, Clone, ClapArgs)]
pub struct DrawArgs {
    /// Number of single deliveries, number of sequences, doors of each sequence
    #[arg(
        long,
        value_names = ["SINGLES", "SEQUENCES", "LENGTH"],
        num_args = 3,
        default_values_t = [8, 1, 3]
    )]
    pub draw: Vec<u16>,
    /// Largest straight-line distance of doors from the start, metres
    #[arg(long, value_name = "M", default_value_t = 250.0, value_parser = radius)]
    pub reach: f64,
}

/// Arguments of `world show`.
#[derive(Debug, ClapArgs)]
#[command(after_help = "\
Examples:
  openbench world show large --from 0,0,90 --out view.jpg --quality 80
  openbench world show worlds/city --above 120 --out city.png
  openbench world show small --from 0,0,0 --depth depth.png --classes classes.png

The legend of an image of classes or instances has the same name, ending in .json.")]
pub struct ShowArgs {
    /// A built-in world (small, medium, large), a drawn one (medium-7), or a world folder
    #[arg(conflicts_with = "world")]
    pub name: Option<String>,
    /// A Gazebo world (SDF)
    #[arg(long, requires = "map")]
    pub world: Option<PathBuf>,
    /// The OSM map of that world
    #[arg(long)]
    pub map: Option<PathBuf>,
    /// Folder with the models that `model://` names; may be repeated
    #[arg(long)]
    pub models: Vec<PathBuf>,
    /// Georeference of the world: UTM zone, and the metres that are added to easting and northing,
    /// such as utm:50N,-500000,-4483000
    #[arg(long)]
    pub georef: Option<String>,
    /// Show the world under a condition; may be repeated. doors=drawn and plates=real change the
    /// world; others, such as light=night, need --from, and give the robot's own image of 640 x 480
    #[arg(long = "condition", value_name = "KEY=VALUE", value_parser = key_value)]
    pub conditions: Vec<(String, String)>,
    /// Seed of what conditions draw, as of a run
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Pose of the robot whose camera view is rendered, metres and degrees [default: from above]
    #[arg(long, value_name = "X,Y,YAW", allow_hyphen_values = true, value_parser = pose)]
    pub from: Option<openbench_core::Pose2>,
    /// From above, show only this distance around the start, metres
    #[arg(long, value_name = "M", conflicts_with = "from", value_parser = radius)]
    pub above: Option<f64>,
    /// File for the image: PNG, or JPEG if the name ends in .jpg
    #[arg(long, default_value = "world.png", value_parser = picture_file)]
    pub out: PathBuf,
    /// JPEG quality, 1 to 100
    #[arg(long, default_value_t = 90, value_parser = clap::value_parser!(u8).range(1..=100))]
    pub quality: u8,
    /// Render no cast shadows, like the robot's camera
    #[arg(long)]
    pub no_shadows: bool,
    /// Number of pedestrians
    #[arg(long, default_value_t = 0)]
    pub pedestrians: u16,
    /// Number of moving cars
    #[arg(long, default_value_t = 0)]
    pub cars: u16,
    /// Time since these started to move, seconds
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(0..=3600))]
    pub after: u16,
    /// The robot's own images at each level of a condition, such as light, side by side: left to
    /// right and down in the order of the levels
    #[arg(
        long,
        value_name = "KEY",
        requires = "from",
        conflicts_with_all = ["depth", "classes", "instances", "no_shadows"]
    )]
    pub levels: Option<String>,
    /// File for depths: 16-bit PNG, millimetres along the optical axis; 0 without a hit, 65535 and
    /// beyond as 65535
    #[arg(long, value_name = "FILE")]
    pub depth: Option<PathBuf>,
    /// File for semantic classes: PNG in the legend's colours
    #[arg(long, value_name = "FILE")]
    pub classes: Option<PathBuf>,
    /// File for instances: PNG, one colour for each object
    #[arg(long, value_name = "FILE")]
    pub instances: Option<PathBuf>,
}
