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
towns="medium-102 medium-103 medium-105 medium-107 large-104 large-106 large-111"
# Neighbourhoods of six to eight buildings,
some="small-108 small-301 small-302 small-303"
# and of two or three.
few="small-203 small-216 small-220 small-224"
drawn="$towns $some $few"
real="krems heidelberg"
mkdir -p "$folder"

# row NAME ARGUMENTS
row() {
    file=$folder/$1.jsonl
    shift
    [ -e "$file" ] && return
    echo "$(date +%T) $file" >&2
    # shellcheck disable=SC2086 # a list of words
    "$openbench" bench localization "$@" --beside medium-109 --poses 20 --drives "$folder/drives" \
        --jobs 2 --examples "$file"
}

# shellcheck disable=SC2086 # lists of words
{
    row city-10m $drawn $real --level city --start 10m
    row city-block $drawn $real --level city --start block
    row city-off $drawn $real --level city --start off
    row good-block $drawn $real --level good --start block
    row good-off $drawn $real --level good --start off
    # Maps that lack much of what is seen. Of few buildings, none may be left.
    row good-block-half $towns --level good --start block --missing 0.5
    row good-block-third $some --level good --start block --missing 0.3
}
