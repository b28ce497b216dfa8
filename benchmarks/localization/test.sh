#!/bin/sh
# Localizes on worlds for tests (docs/tuning.md), one JSON file for each row of the tables.
# Usage: test.sh OPENBENCH FOLDER MONACO.osm.pbf PUBLISHED GAZEBO_MODELS
#
# Files that are there are kept, so the command goes on after an interruption. PUBLISHED is the
# folder that `openbench data pull published` writes. POSES is the number of drives in each world,
# 40 by default; those of windows and published worlds have half as many. The packages from PyPI,
# which are slow, get the drives of two worlds.
set -eu
if [ $# -ne 5 ]; then
    sed -n 2,8p "$0" >&2
    exit 2
fi
openbench=$1 folder=$2 monaco=$3 published=$4 models=$5
here=$(cd "$(dirname "$0")" && pwd)
poses=${POSES:-40}
half=$(((poses + 1) / 2))
drawn="medium-11100 medium-11101 medium-11102 medium-11103 large-11104 large-11105 small-11106"
mkdir -p "$folder"

# row NAME ARGUMENTS
row() {
    file=$folder/$1.json
    shift
    [ -e "$file" ] && return
    echo "$(date +%T) $file" >&2
    "$openbench" bench localization "$@" --drives "$folder/drives" --jobs 2 --seed 11100 \
        --json > "$file.part"
    mv "$file.part" "$file"
}

# 400 m by 400 m of Monaco, in four places.
windows=
for place in 7.4130,43.7275 7.4245,43.7310 7.4235,43.7420 7.4300,43.7445; do
    window=$folder/monaco-$place
    [ -e "$window" ] || "$openbench" world generate --map "$monaco" --around "$place" \
        --radius 200 --seed 11100 --out "$window"
    windows="$windows $window"
done

for level in good city; do
    # shellcheck disable=SC2086 # a list of words
    row "$level-10m" $drawn monaco --level $level --start 10m --poses "$poses" --peers
    for start in block off; do
        # shellcheck disable=SC2086 # a list of words
        row "$level-$start" $drawn monaco --level $level --start $start --beside medium-11109 \
            --poses "$poses"
    done
done
for level in good city; do
    for world in small medium; do
        for start in 10m block; do
            row "$level-$start-published-$world" --level $level --start $start --poses "$half" \
                --world "$published/$world/${world}_osm.world" \
                --map "$published/$world/$world.osm" --models "$models"
        done
    done
    # shellcheck disable=SC2086 # a list of words
    row "$level-map" $windows --level $level --start map --poses "$half"
    row "$level-10m-packages" medium-11100 monaco --level $level --start 10m --poses "$poses" \
        --peer "$here/global_registration.py"
done
# True labels need drives of their own.
for level in good city; do
    # shellcheck disable=SC2086 # a list of words
    row "$level-10m-truth" $drawn monaco --level $level --start 10m --poses "$poses" --labels truth
done
row good-3km medium-11100 monaco --level good --start 10m --poses 1 --drive 3000 \
    --odometry-drift 0.01
