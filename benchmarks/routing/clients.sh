#!/bin/sh
# Unmodified clients of OSRM from PyPI and npm against our server: routingpy, and osrm-text-instructions, which puts steps into words.
# Usage: clients.sh [MAP.osm.pbf LON,LAT LON,LAT]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
[ "$#" -eq 3 ] || set -- "$root/../shared/data/osm/porto_portugal.osm.pbf" -8.6109,41.1496 -8.6260,41.1579
if [ ! -e "$1" ]; then
    echo "skipped: $1 is not there" >&2
    exit 0
fi
. "$here/venv.sh"
"$here/.venv/bin/python" -m pip install --quiet --disable-pip-version-check routingpy==1.3.0
cargo build --release --manifest-path "$root/Cargo.toml"
work=$root/target/bench-routing/clients
mkdir -p "$work"
[ -d "$work/node_modules/osrm-text-instructions" ] || npm install --silent --prefix "$work" osrm-text-instructions@0.15.0
"$root/target/release/openbench" serve --map "$1" --profile foot --listen 127.0.0.1:5919 &
server=$!
trap 'kill $server' EXIT
"$here/.venv/bin/python" "$here/clients.py" http://127.0.0.1:5919 "$2" "$3" "$work/route.json"
node - "$work" <<'EOF'
const [work] = process.argv.slice(2);
const words = require(work + "/node_modules/osrm-text-instructions")("v5");
const route = JSON.parse(require("fs").readFileSync(work + "/route.json")).routes[0];
const steps = route.legs.flatMap((leg) => leg.steps);
for (const step of steps.slice(0, 6)) console.log("  " + words.compile("en", step));
console.log(`osrm-text-instructions: ${steps.length} steps in words`);
EOF
