#!/usr/bin/env bash
# Searches the longest ways of Moving AI scenario files with ours and with pyastar2d, and prints the table: run.sh [FILE.map ...] (FILE.map.scen beside each)
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
if [ $# -eq 0 ]; then
    data=$here/../../../shared/data/grids
    if [ ! -d "$data" ]; then
        echo "no grids: name some .map files"
        exit 0
    fi
    set -- "$data"/*.map
fi
cargo build --release --quiet --manifest-path "$here/../../Cargo.toml" -p openbench-motion --example movingai
if [ ! -x "$here/.venv/bin/python" ]; then
    python3 -m venv "$here/.venv"
fi
"$here/.venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/requirements.txt"
"$here/.venv/bin/python" "$here/compare.py" --movingai "$here/../../target/release/examples/movingai" "$@"
