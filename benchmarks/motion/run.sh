#!/usr/bin/env bash
# Drives all local planners through scenes and measures the parts of the band's: run.sh [SCENES [SEED]]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
manifest=$here/../../Cargo.toml
cargo build --release --quiet --manifest-path "$manifest" -p openbench
cargo build --release --quiet --manifest-path "$manifest" -p openbench-motion --example speed
"$here/../../target/release/examples/speed"
"$here/../../target/release/openbench" bench motion --scenes "${1:-1000}" --seed "${2:-1}" --jobs "$(nproc)"
