#!/bin/sh
# Compares our ray casting and simulation with MuJoCo, PyBullet and Embree on the published `medium` world.
# Usage: run.sh [WORLD MAP MODELS]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
data="$root/../shared/data"
case "$#" in
0) set -- "$data/openbench/medium/medium_osm.world" "$data/openbench/medium/medium.osm" "$data/gazebo_models" ;;
3) ;;
*)
    echo "usage: $0 [WORLD MAP MODELS]" >&2
    exit 2
    ;;
esac
for needed in "$@"; do
    if [ ! -e "$needed" ]; then
        echo "skipped: $needed is not there (the comparison needs a published world, its map and Gazebo's models)" >&2
        exit 0
    fi
done
if [ ! -x "$here/.venv/bin/python" ]; then
    python3 -m venv "$here/.venv"
fi
"$here/.venv/bin/python" -m pip install --quiet --disable-pip-version-check --prefer-binary -r "$here/requirements.txt"
cargo build --release --manifest-path "$root/Cargo.toml"
# Under target/, which git ignores; kept, so that compare.py can be run on it again.
dump="$root/target/bench-sim"
rm -rf "$dump"
mkdir -p "$dump"
"$root/target/release/openbench" bench sim --world "$1" --map "$2" --models "$3" --dump "$dump" --json >&2
exec "$here/.venv/bin/python" "$here/compare.py" "$dump"
