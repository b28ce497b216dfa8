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
# OSRM's bindings are made for Python 3.12 and newer.
python=
for candidate in python3 python3.14 python3.13 python3.12 "$HOME"/.pyenv/versions/3.1[2-9]*/bin/python; do
    if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 12))' 2>/dev/null; then
        python=$candidate
        break
    fi
done
if [ -z "$python" ]; then
    echo "skipped: no Python 3.12 or newer, which the peers' packages need" >&2
    exit 0
fi
if [ ! -x "$here/.venv/bin/python" ]; then
    "$python" -m venv "$here/.venv"
fi
"$here/.venv/bin/python" -m pip install --quiet --disable-pip-version-check --only-binary :all: -r "$here/requirements.txt"
cargo build --release --manifest-path "$root/Cargo.toml"
exec "$here/.venv/bin/python" "$here/compare.py" "$root/target/release/openbench" "$1" "$2" "$root/target/bench-routing"
