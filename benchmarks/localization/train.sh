#!/bin/sh
# Writes candidate poses on training worlds, which fit.py fits probabilities to.
# Usage: train.sh OPENBENCH FOLDER
set -eu
if [ $# -ne 2 ]; then
    sed -n 2,3p "$0" >&2
    exit 2
fi
drawn="medium-102 medium-103 medium-105 medium-107 large-104 large-106 large-111 small-108"
# Neighbourhoods of two or three buildings.
drawn="$drawn small-203 small-216 small-220 small-224"
real="krems heidelberg"
mkdir -p "$2"
for level in good city poor; do
    for start in 10m block map off; do
        # A search of all of a real town takes minutes for each drive.
        case $start in
        map) worlds=$drawn ;;
        *) worlds="$drawn $real" ;;
        esac
        file=$2/$level-$start.jsonl
        [ -e "$file" ] && continue
        # shellcheck disable=SC2086 # a list of words
        "$1" bench localization $worlds --level $level --start $start --beside medium-109 \
            --poses 20 --drives "$2/drives" --jobs 2 --examples "$file"
    done
done
