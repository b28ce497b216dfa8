#!/bin/sh
# Writes candidate poses on training worlds, which fit.py fits probabilities to.
# Usage: train.sh OPENBENCH FOLDER
#
# Files that are there are kept, so the command goes on after an interruption.
set -eu
if [ $# -ne 2 ]; then
    sed -n 2,5p "$0" >&2
    exit 2
fi
openbench=$1 folder=$2
here=$(cd "$(dirname "$0")" && pwd)
towns="medium-102 medium-103 medium-105 medium-107 large-104 large-106 large-111"
# Neighbourhoods of six to eight buildings,
some="small-108 small-301 small-302 small-303"
# and of two or three.
few="small-203 small-216 small-220 small-224"
drawn="$towns $some $few"
real="krems heidelberg"
mkdir -p "$folder"

# Houses in rows along parallel roads, which look alike in all of them.
rows=
for seed in 1 2 3 4 5 6; do
    world=$folder/rows-$seed
    rows="$rows $world"
    [ -e "$world" ] && continue
    python3 "$here/rows.py" "$seed" "$world.osm"
    "$openbench" world generate --map "$world.osm" --seed "$seed" --out "$world"
done

# row NAME ARGUMENTS
row() {
    file=$folder/$1.jsonl
    shift
    [ -e "$file" ] && return
    echo "$(date +%T) $file" >&2
    "$openbench" bench localization "$@" --poses 10 --drives "$folder/drives" --jobs 2 \
        --examples "$file"
}

# beside LEVEL OTHER WORLD...: drives in each of the worlds with the map of another one.
beside() {
    level=$1 other=$2
    shift 2
    for world in "$@"; do
        [ "$world" = "$other" ] || row "$level-$(basename "$world")-$(basename "$other")" "$world" \
            --level "$level" --start off --beside "$other"
    done
}

# shellcheck disable=SC2086 # lists of words
{
    row city-10m $drawn $real $rows --level city --start 10m
    row city-block $drawn $real $rows --level city --start block
    row good-block $drawn $real $rows --level good --start block
    # Maps that lack much of what is seen. Of few buildings, none may be left.
    row good-block-half $towns --level good --start block --missing 0.5
    row good-block-third $some --level good --start block --missing 0.3
    row city-10m-half $towns --level city --start 10m --missing 0.5
    row city-10m-third $some --level city --start 10m --missing 0.3
    beside city medium-109 $drawn $real
    beside city large-106 $drawn $real
    beside good medium-109 $drawn $real
    beside good large-111 $drawn $real
    beside good medium-103 $drawn $real $rows
}
for seed in 1 2 3 4 5 6; do
    beside good "$folder/rows-$((seed % 6 + 1))" "$folder/rows-$seed"
    beside city "$folder/rows-$(((seed + 2) % 6 + 1))" "$folder/rows-$seed"
done
