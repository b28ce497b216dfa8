#!/bin/sh
# Prints statistics of real extracts and of drawn neighbourhoods side by side.
# OSM: folder with the extracts named in README.md.
set -eu
cd "$(dirname "$0")/../.."
: "${OSM:?set OSM to the folder with the extracts}"
cargo run --release --quiet --package openbench-neighbourhoods --example statistics -- \
    "Porto W=$OSM/porto_portugal.osm.pbf@-8.640,41.165" \
    "Porto E=$OSM/porto_portugal.osm.pbf@-8.600,41.170" \
    "Krems W=$OSM/krems_austria.osm.pbf@15.6030,48.4110" \
    "Krems E=$OSM/krems_austria.osm.pbf@15.6170,48.4125" \
    "Heidelberg W=$OSM/heidelberg_germany.osm.pbf@8.6975,49.4100" \
    "Heidelberg E=$OSM/heidelberg_germany.osm.pbf@8.7125,49.4110" \
    "$@"
