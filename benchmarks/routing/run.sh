#!/bin/sh
# Compares our routing with OSRM, Valhalla and RoutingKit on foot, on the same map and the same pairs of places.
# Usage: run.sh [MAP.osm.pbf PAIRS.csv]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
case "$#" in
0) set -- "$root/../shared/data/osm/porto_portugal.osm.pbf" "$here/pairs.csv" ;;
2) ;;
*)
    echo "usage: $0 [MAP.osm.pbf PAIRS.csv]" >&2
    exit 2
    ;;
esac
for needed in "$@"; do
    if [ ! -e "$needed" ]; then
        echo "skipped: $needed is not there" >&2
        exit 0
    fi
done
. "$here/venv.sh"
cargo build --release --manifest-path "$root/Cargo.toml"
exec "$here/.venv/bin/python" "$here/compare.py" "$root/target/release/openbench" "$1" "$2" "$root/target/bench-routing"
