#!/bin/sh
# Do the main paths of the command cost the same instructions as benches/instructions.txt says?
#
#   benches/paths.sh [BINARY]               (default: the release build of this checkout, which is made)
#   UPDATE_INSTRUCTIONS=1 benches/paths.sh  writes the file anew
#
# Runs each command on one thread under callgrind, and exits 1 where it takes over 1 % more, or over 1 % less, than the
# file says: then the file is to be written anew, in the commit that says why. Another compiler lays the same code out
# otherwise: under one that is not the file's the counts are shown and not held.
set -eu
root=$(git rev-parse --show-toplevel)
cd "$root"
command -v valgrind >/dev/null || { echo "valgrind is not installed: instructions are not counted"; exit 0; }
if [ $# -gt 0 ]; then
    binary=$1
else
    cargo build --release --locked --bin biprism
    binary=${CARGO_TARGET_DIR:-$root/target}/release/biprism
fi
list=benches/instructions.txt
compiler=$(rustc --version)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

count() { # arguments of the command
    RAYON_NUM_THREADS=1 valgrind --tool=callgrind --callgrind-out-file=/dev/null --log-file="$work/log" \
        "$binary" "$@" >"$work/said" 2>&1 || { cat "$work/said" >&2; return 2; }
    sed -n 's/^==[0-9]*== Collected : //p' "$work/log"
}
flat=scenes/cases/prism_flat.toml
freeform=scenes/cases/prism_freeform.toml
awk 'BEGIN { for (k = 0; k < 20000; k++) printf "%.3f,%.3f\n", (k * 97) % 320 + 0.25, (k * 71) % 180 + 0.5 }' >"$work/points.csv"
: >"$work/found"
path() { # name, arguments of the command
    name=$1
    shift
    n=$(count "$@")
    echo "$name $n" >>"$work/found"
}
path design design "$freeform" --out "$work/prism"
path render_flat_png render "$flat" --out "$work/flat.png"
path render_freeform_png render "$freeform" --out "$work/freeform.png"
path render_freeform_exr render "$freeform" --out "$work/freeform.exr"
path corners corners "$work/freeform.png"
path measure measure "$work/freeform.png" --scene "$freeform" --own
path compare compare "$freeform" --out "$work/compared"
path trace_text trace "$freeform" --points "$work/points.csv"
path trace_npy trace "$freeform" --points "$work/points.csv" --out "$work/rays.npy"

if [ -n "${UPDATE_INSTRUCTIONS:-}" ]; then
    { echo "# instructions of one thread, by benches/paths.sh; $compiler"; cat "$work/found"; } >"$list"
    cat "$list"
    exit 0
fi
hold=1
grep -qF "$compiler" "$list" || { echo "$compiler is not the compiler of $list: counts are not held"; hold=0; }
awk -v hold="$hold" '
    NR == FNR { if ($1 != "#") was[$1] = $2; next }
    { change = was[$1] ? 100 * ($2 / was[$1] - 1) : 100
      bad = change > 1 || change < -1
      printf "%-28s %13.0f %13.0f %+8.3f %%%s\n", $1, was[$1], $2, change, bad ? "  beyond 1 %" : ""
      if (bad) failed = 1; delete was[$1] }
    END { for (name in was) { print name " is no path any more"; failed = 1 }; exit hold && failed }' "$list" "$work/found"
