#!/usr/bin/env bash
# Holds all methods against the reference on all scenes: one line a scene, exit code 1 if an exact method differs anywhere.
#
#   scripts/sweep.sh SCENES [WIDTHxHEIGHT] [NAME...]
#
# SCENES   folder of scenes; cameras and lights are in sweep.tsv beside this script. Files that are not there are listed.
# SIZE     of the pictures, 1920x1080 if not given.
# NAME     only these: names of sweep.tsv, or builtin:NAME. Without any: all of the table, and all built-in scenes.
#
# ANTUMBRA names the program (default: target/release/antumbra), METHODS the methods (comma-separated; default: all).
# Sizes over 480x270 are preceded by a run at 480x270; a method that would take over a minute a frame (LIMIT_MS), by the
# number of pixels, is shown at that size instead and listed at the end.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
antumbra=${ANTUMBRA:-$here/../target/release/antumbra}
[ $# -ge 1 ] || { sed -n '2,13s/^# \{0,1\}//p' "$0"; exit 2; }
scenes=$1 size=${2:-1920x1080}
shift; [ $# -gt 0 ] && shift
wanted=("$@")
small=480x270
limit=${LIMIT_MS:-60000}
pixels=$((${size%x*} * ${size#*x}))
ratio=$((pixels / (480 * 270)))
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

failed=0 missing=() slow=() count=0

# Runs `compare`; the table goes to file $1. Exit code 1 (masks differ) is for the caller to see in the table.
compare() {
    local table=$1 status=0
    shift
    "$antumbra" compare "$@" --quiet > "$table" 2> "$out/errors" || status=$?
    if [ "$status" -gt 1 ]; then
        cat "$out/errors" >&2
        return "$status"
    fi
}

# Columns of the table: method, exact, mismatches, leaks, acne, ms.
rows() { awk '$2 == "yes" || $2 == "no" { print $1, $2, $3, $6 }' "$1"; }

# name, scene, arguments
scene() {
    local name=$1 file=$2 methods=${METHODS:-all} left_out="" at=$size
    shift 2
    if [ ${#wanted[@]} -gt 0 ] && [[ " ${wanted[*]} " != *" $name "* ]]; then return; fi
    if [[ $file != builtin:* && ! -f $file ]]; then missing+=("$name"); return; fi
    count=$((count + 1))
    : > "$out/small"
    if [ "$ratio" -gt 1 ]; then
        if ! compare "$out/small" "$file" "$@" --size $small --methods "$methods"; then failed=1; echo "$name: FAILED TO RUN"; return; fi
        left_out=$(rows "$out/small" | awk -v r="$ratio" -v l="$limit" '$4 * r > l { print $1 }' | paste -sd, -)
        if [ -n "$left_out" ]; then
            methods=$(rows "$out/small" | awk -v r="$ratio" -v l="$limit" '$4 * r <= l { print $1 }' | grep -v '^oracle$' | paste -sd, -)
            slow+=("$name: $left_out")
        fi
    fi
    if ! compare "$out/large" "$file" "$@" --size "$size" --methods "$methods"; then failed=1; echo "$name: FAILED TO RUN"; return; fi
    local wrong exact
    wrong=$({ rows "$out/small"; rows "$out/large"; } | awk '$2 == "yes" && $3 > 0 { print $1 " " $3 }' | sort -u | paste -sd, -)
    exact=$(rows "$out/large" | awk '$2 == "yes"' | wc -l)
    printf '%-26s %s, %d exact methods, ' "$name" "$(awk 'NR == 1 { print $(NF - 1), $NF; exit }' "$out/large") at $at" "$exact"
    if [ -z "$wrong" ]; then
        echo "0 mismatches${left_out:+ (at $small: $left_out)}"
    else
        failed=1
        echo "MISMATCHES: $wrong"
        cat "$out/small" "$out/large" >&2
    fi
}

while IFS=$'\t' read -r name file args; do
    [[ -z $name || $name == \#* ]] && continue
    read -ra words <<< "$args"
    scene "$name" "$scenes/$file" "${words[@]}"
done < "$here/sweep.tsv"
while read -r name _; do
    scene "$name" "$name"
done < <("$antumbra" scenes | grep '^builtin:')

echo
echo "$count scenes at $size"
[ ${#missing[@]} -eq 0 ] || echo "not there: ${missing[*]}"
if [ ${#slow[@]} -gt 0 ]; then
    echo "over $((limit / 1000)) s a frame at $size, so shown at $small:"
    printf '  %s\n' "${slow[@]}"
fi
[ "$count" -gt 0 ] || { echo "nothing was compared"; exit 2; }
[ "$failed" -eq 0 ] && echo "no exact method differs anywhere" || echo "SOMETHING DIFFERS OR FAILED"
exit "$failed"
