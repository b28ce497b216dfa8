#!/usr/bin/env bash
# Solves pose graphs with ours and GTSAM's solver, and prints the table: run.sh [FILE.g2o ...]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
if [ $# -eq 0 ]; then
    data=$here/../../../shared/data/posegraph
    if [ ! -d "$data" ]; then
        echo "no graphs: name some .g2o files"
        exit 0
    fi
    set -- "$data"/*.g2o
fi
cargo build --release --quiet --manifest-path "$here/../../Cargo.toml"
if [ ! -x "$here/.venv/bin/python" ]; then
    python3 -m venv "$here/.venv"
fi
"$here/.venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/requirements.txt"
"$here/.venv/bin/python" "$here/compare.py" --openbench "$here/../../target/release/openbench" "$@"
