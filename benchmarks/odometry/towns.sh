#!/usr/bin/env bash
# Odometries on logs of neighbourhoods that a seed draws from maps: towns.sh FOLDER WINDOWS SEED MAP...
# Logs last MINUTES, 1.5 unless told. Each is recorded, run and removed, since thirty of them take 25 GB. What is done already is not done again.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
if [ $# -lt 4 ]; then
    sed -n 2,3p "$0" >&2
    exit 1
fi
out=$(mkdir -p "$1" && cd "$1" && pwd)
windows=$2
seed=$3
shift 3
maps=()
for map in "$@"; do
    maps+=(--map "$(cd "$(dirname "$map")" && pwd)/$(basename "$map")")
done
cd "$here/../.."
cargo build --release --quiet
openbench=$PWD/target/release/openbench
python=$here/.venv/bin/python
if [ ! -x "$python" ]; then
    python3 -m venv "$here/.venv"
fi
"$python" -m pip install --quiet --disable-pip-version-check -r "$here/requirements.txt"

"$openbench" bench towns "${maps[@]}" --windows "$windows" --seed "$seed" --draw --out "$out/windows"
logs=()
for window in "$out"/windows/*/; do
    log=$(basename "$window")
    logs+=("$log")
    if [ -e "$out/$log/done" ]; then
        continue
    fi
    mkdir -p "$out/$log"
    "$openbench" record "$window/world" --minutes "${MINUTES:-1.5}" --seed "$seed" --out "$out/$log.mcap"
    "$openbench" odometry "$out/$log.mcap" --out "$out/$log/ours.tum" --truth "$out/$log/truth.tum" --json \
        > "$out/$log/ours.json"
    # Peers know of no wheels.
    "$openbench" odometry "$out/$log.mcap" --wheels --out "$out/$log/ours-wheels.tum" --json \
        > "$out/$log/ours-wheels.json"
    "$python" "$here/peers.py" "$out/$log.mcap" --out "$out/$log"
    rm "$out/$log.mcap"
    touch "$out/$log/done"
done
"$python" "$here/table.py" "$out" "${logs[@]}" | tee "$out/table.md"
