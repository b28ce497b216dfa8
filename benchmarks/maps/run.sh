#!/bin/sh
# Compares maps for LiDAR odometry on logs of `openbench record`: run.sh LOG.mcap...
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
# Under target/, which git ignores.
cargo build --quiet --release --manifest-path "$here/Cargo.toml" --target-dir "$root/target/maps"
exec "$root/target/maps/release/openbench-maps" "$@"
