#!/bin/sh
# Compares our pictures with those that a Vulkan driver draws of the same triangles: the built-in worlds, and the published `medium` where it is there.
# Usage: run.sh [WORLD MAP MODELS]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
data="$root/../shared/data"
if [ "$#" -eq 0 ]; then
    if [ -e "$data/openbench/medium/medium_osm.world" ] && [ -d "$data/gazebo_models" ]; then
        set -- "$data/openbench/medium/medium_osm.world" "$data/openbench/medium/medium.osm" "$data/gazebo_models"
    else
        echo "skipped: the published world \`medium\`, since $data is not there; the built-in worlds follow" >&2
    fi
fi
# Under target/, which git ignores.
cargo build --release --manifest-path "$here/Cargo.toml" --target-dir "$root/target/oracle"
# Some drivers complain without one.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$root/target/oracle}"
exec "$root/target/oracle/release/openbench-oracle" "$@"
