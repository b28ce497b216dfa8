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
invented="$towns $some $few"
real="krems heidelberg"
mkdir -p "$folder"

# drawn SCRIPT SEED...: worlds of the maps that a script draws, and their folders in $drawn.
drawn() {
    script=$1 drawn=
    shift
    for seed in "$@"; do
        world=$folder/$script-$seed
        drawn="$drawn $world"
        [ -e "$world" ] && continue
        python3 "$here/$script.py" "$seed" "$world.osm"
        "$openbench" world generate --map "$world.osm" --seed "$seed" --out "$world"
    done
}
# Houses in rows along parallel roads, which look alike in all of them,
drawn rows 1 2 3 4 5 6
rows=$drawn
# and two to ten houses within high walls that no map shows.
drawn walled 1 2 3 4 5 6 7 15 37 42
walled=$drawn

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
    row city-10m $invented $real $rows $walled --level city --start 10m
    row city-block $invented $real $rows $walled --level city --start block
    row good-block $invented $real $rows $walled --level good --start block
    # Maps that lack much of what is seen. Of few buildings, none may be left.
    row good-block-half $towns --level good --start block --missing 0.5
    row good-block-third $some --level good --start block --missing 0.3
    row city-10m-half $towns --level city --start 10m --missing 0.5
    row city-10m-third $some --level city --start 10m --missing 0.3
    beside city medium-109 $invented $real
    beside city large-106 $invented $real
    beside good medium-109 $invented $real
    beside good large-111 $invented $real
    beside good medium-103 $invented $real $rows $walled
}

# around LEVEL BY WORLD...: drives in each with the map of the one that comes so much later.
around() {
    level=$1 by=$2
    shift 2
    for i in $(seq $#); do
        j=$(((i + by - 1) % $# + 1))
        eval "beside $level \"\${$j}\" \"\${$i}\""
    done
}

# shellcheck disable=SC2086 # lists of words
for same in "$rows" "$walled"; do
    around good 1 $same
    around city 3 $same
done
