#!/bin/sh
# How the cost of routing grows with the map: every extract, all of them in one file, and copies of the largest side by side.
# Usage: growth.sh [MAP.osm.pbf ...]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
if [ "$#" -eq 0 ]; then
    set -- "$root"/../shared/data/osm/*.osm*
fi
for needed in "$@"; do
    if [ ! -e "$needed" ]; then
        echo "skipped: $needed is not there" >&2
        exit 0
    fi
done
. "$here/venv.sh"
"$here/.venv/bin/python" -m pip install --quiet --disable-pip-version-check --only-binary :all: osmium matplotlib
cargo build --release --manifest-path "$root/Cargo.toml"
exec "$here/.venv/bin/python" "$here/growth.py" "$root/target/release/openbench" "$root/target/bench-routing/growth" "$@"
