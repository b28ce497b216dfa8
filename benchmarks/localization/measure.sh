#!/bin/sh
# Localizes on worlds for validation or for tests (docs/tuning.md), one JSON file for each row of
# the tables.
# Usage: measure.sh OPENBENCH FOLDER validation
#        measure.sh OPENBENCH FOLDER test MONACO.osm.pbf PUBLISHED GAZEBO_MODELS
#
# Files that are there are kept, so the command goes on after an interruption. PUBLISHED is the
# folder that `openbench data pull published` writes. POSES is the number of drives in each world,
# 40 by default; those of windows and published worlds have half as many. The packages from PyPI,
# which are slow, get the drives of two worlds.
set -eu
case ${3:-}-$# in
validation-3 | test-6) ;;
*)
    sed -n 2,10p "$0" >&2
    exit 2
    ;;
esac
openbench=$1 folder=$2 split=$3
here=$(cd "$(dirname "$0")" && pwd)
poses=${POSES:-40}
half=$(((poses + 1) / 2))
mkdir -p "$folder"
case $split in
validation)
    seed=10000
    worlds="medium-10000 medium-10001 medium-10002 medium-10003 large-10004 large-10005
        small-10006 bayreuth campus"
    other=medium-10009
    wide=campus
    ;;
test)
    monaco=$4 published=$5 models=$6
    seed=11200
    worlds="medium-11200 medium-11201 medium-11202 medium-11203 large-11204 large-11205
        small-11206 monaco"
    other=medium-11209
    # 400 m by 400 m of Monaco, in four places.
    wide=
    for place in 7.4130,43.7275 7.4245,43.7310 7.4235,43.7420 7.4300,43.7445; do
        window=$folder/monaco-$place
        [ -e "$window" ] || "$openbench" world generate --map "$monaco" --around "$place" \
            --radius 200 --seed "$seed" --out "$window"
        wide="$wide $window"
    done
    ;;
esac

# row NAME ARGUMENTS
row() {
    file=$folder/$1.json
    shift
    [ -e "$file" ] && return
    echo "$(date +%T) $file" >&2
    "$openbench" bench localization "$@" --drives "$folder/drives" --jobs 2 --seed "$seed" \
        --json > "$file.part"
    mv "$file.part" "$file"
}

# in_worlds NAME ARGUMENTS: a row of all worlds.
in_worlds() {
    name=$1
    shift
    # shellcheck disable=SC2086 # a list of words
    row "$name" $worlds --poses "$poses" "$@"
}

for level in good city; do
    in_worlds "$level-10m" --level "$level" --start 10m --peers
    in_worlds "$level-block" --level "$level" --start block
    in_worlds "$level-off" --level "$level" --start off --beside "$other"
    # shellcheck disable=SC2086 # a list of words
    row "$level-map" $wide --level "$level" --start map --poses "$half"
done

if [ "$split" = validation ]; then
    # For reliability.py.
    for start in 10m block; do
        candidates=$folder/city-$start.jsonl
        # shellcheck disable=SC2086 # a list of words
        [ -e "$candidates" ] || "$openbench" bench localization $worlds --level city \
            --start "$start" --poses "$poses" --drives "$folder/drives" --jobs 2 \
            --seed "$seed" --examples "$candidates"
    done
    for part in free-space hypothesis-bank building-offsets; do
        for start in 10m block; do
            in_worlds "city-$start-without-$part" --level city --start "$start" --without "$part"
        done
    done
else
    for level in good city; do
        for world in small medium; do
            for start in 10m block; do
                row "$level-$start-published-$world" --level "$level" --start "$start" \
                    --poses "$half" --world "$published/$world/${world}_osm.world" \
                    --map "$published/$world/$world.osm" --models "$models"
            done
        done
        row "$level-10m-packages" medium-11200 monaco --level "$level" --start 10m \
            --poses "$poses" --peer "$here/global_registration.py"
    done
    row good-3km medium-11200 --level good --start 10m --poses 1 --drive 3000 \
        --odometry-drift 0.01
fi

# True labels need drives of their own.
for level in good city; do
    in_worlds "$level-10m-truth" --level "$level" --start 10m --labels truth
done
in_worlds city-block-truth --level city --start block --labels truth
