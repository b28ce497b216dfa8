#!/bin/sh
# Whether two commits compute the same: builds both, runs both, compares.
# Usage: run.sh OLD_COMMIT FOLDER [NEW_COMMIT]
# What is in FOLDER already is used again, so that an old commit is recorded once.
set -eu
if [ $# -lt 2 ]; then
    sed -n 2,4p "$0" >&2
    exit 2
fi
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
data=$root/../shared/data
if [ ! -d "$data" ]; then
    # Not 0: nothing was compared, so nothing is known to be identical.
    echo "not compared: $data is not there" >&2
    exit 2
fi
mkdir -p "$2"
folder=$(cd "$2" && pwd)

# Builds and records a commit, in folders named after it; prints its manifest's path.
record() {
    name=$(git -C "$root" rev-parse --short "$1")
    out=$folder/$name
    if [ ! -e "$out/openbench" ]; then
        mkdir -p "$out"
        git -C "$root" worktree add --quiet --detach "$out/source" "$1" >&2
        cargo build --release --quiet --manifest-path "$out/source/Cargo.toml" \
            --target-dir "$folder/target" >&2
        cp "$folder/target/release/openbench" "$out/openbench"
        git -C "$root" worktree remove "$out/source" >&2
    fi
    python3 "$here/identity.py" record "$out/openbench" "$data" "$out/record" >&2
    echo "$out/record/manifest.json"
}

old=$(record "$1")
new=$(record "${3:-HEAD}")
exec python3 "$here/identity.py" compare "$old" "$new" --names "$here/names.toml"
