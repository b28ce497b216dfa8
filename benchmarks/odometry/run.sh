#!/usr/bin/env bash
# Records the logs, runs our odometry and the peers on them, and prints the table: run.sh [FOLDER]
# Logs take some 18 GB, 13 of them the hour's and the two kilometres', which the peers are spared. Logs and peers' results that are there already are used again.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=$(mkdir -p "${1:-$here/out}" && cd "${1:-$here/out}" && pwd)
cd "$here/../.."
cargo build --release --quiet
openbench=$PWD/target/release/openbench

if [ ! -x "$here/.venv/bin/python" ]; then
    python3 -m venv "$here/.venv"
fi
python=$here/.venv/bin/python
"$python" -m pip install --quiet --disable-pip-version-check -r "$here/requirements.txt"

"$python" "$here/worlds.py" "$out/worlds"
for world in street yards square corridor kerbs avenue boulevard; do
    start=0,0,0
    if [ "$world" = yards ]; then
        start=-3,0,90
    fi
    "$openbench" world generate --map "$out/worlds/$world.osm" --out "$out/worlds/$world" \
        --georef tangent:117.0,40.498 --start="$start" --planting 0 --parked-cars 0
done

record() {
    local name=$1
    shift
    if [ ! -e "$out/$name.mcap" ]; then
        "$openbench" record "$@" --out "$out/part.mcap"
        mv "$out/part.mcap" "$out/$name.mcap"
    fi
}
w=$out/worlds
record close small --minutes 3
record loops medium --minutes 5 --noise-seed 1
record street "$w/street" --minutes 4 --via 200,-1 --via 0,1
record yards "$w/yards" --minutes 4 --via 4,4 --via 12,4 --via 28,12 --via 4,18 --via 20,25
record kerbs "$w/kerbs" --minutes 3 --via 80,0 --via 0,0
record traffic medium --minutes 4 --pedestrians 50 --cars 20 --noise-seed 2
record turning small --minutes 3 --wild
record square "$w/square" --minutes 5 --via 40,0 --via 30,40 --via -40,40 --via -50,-50 --via 40,-40
record corridor "$w/corridor" --minutes 4 --via 95,0 --via 0,0
record gap small --minutes 2 --gap 60,0.5
record saturation small --minutes 2 --wild --imu-range 0.6,11
record hour medium --minutes 60 --noise-seed 3
record avenue "$w/avenue" --minutes 38 --via 210,0 --via 300,120 --via 300,330 --via 140,440 --via=-60,420 --via=-160,260 --via=-300,239
record boulevard "$w/boulevard" --minutes 38 --seed 7 --via 180,0 --via 300,-90 --via 320,-300 --via 160,-420 --via=-40,-430 --via=-180,-290 --via=-310,-276

ours() {
    local log=$1
    mkdir -p "$out/$log"
    "$openbench" odometry "$out/$log.mcap" --out "$out/$log/ours.tum" --truth "$out/$log/truth.tum" --json > "$out/$log/ours.json"
    # Peers know of no wheels.
    "$openbench" odometry "$out/$log.mcap" --wheels --out "$out/$log/ours-wheels.tum" --json > "$out/$log/ours-wheels.json"
}
ours hour
ours avenue
ours boulevard
for log in close loops street yards kerbs traffic turning square corridor gap saturation; do
    ours "$log"
    for peer in kiss-icp rko-lio se3-lio dlio; do
        if [ ! -e "$out/$log/$peer.json" ]; then
            "$python" "$here/peers.py" "$out/$log.mcap" --out "$out/$log" --only "$peer"
        fi
    done
done
"$python" "$here/table.py" "$out" | tee "$out/table.md"
