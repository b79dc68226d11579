#!/bin/sh
# Does a plain picture cost the same instructions as it did at another revision?
#
#   benches/instructions.sh [REVISION] [SCENE...]        (default: HEAD~1, and four cases without effects)
#
# Builds this checkout and REVISION (in a temporary worktree), renders each scene with both on one thread under
# callgrind, and prints instructions inside the render and of the whole command. Exits 1 where the render of this
# checkout takes over 0.5 % more than the other's: a compiler lays the same loops out anew when code around them
# changes, and moves counts by less than that.
#
# Instructions are counted by the name of the functions, which the release profile strips and these builds keep. Revisions whose `render_band` the compiler may still inline are
# counted with CARGO_INCREMENTAL=1, which keeps modules apart.
set -eu
revision=${1:-HEAD~1}
[ $# -gt 0 ] && shift
root=$(git rev-parse --show-toplevel)
cd "$root"
[ $# -gt 0 ] || set -- scenes/cases/prism_none.toml scenes/cases/prism_flat.toml scenes/cases/prism_freeform.toml scenes/cases/prism_tilted.toml
target=${CARGO_TARGET_DIR:-$root/target}
work=$(mktemp -d)
trap 'git worktree remove --force "$work/old" >/dev/null 2>&1 || true; rm -rf "$work"' EXIT

build() { # directory, name
    # Cargo takes two checkouts of one package for the same, and compares times only.
    touch "$1/src/lib.rs"
    (cd "$1" && CARGO_PROFILE_RELEASE_STRIP=false CARGO_TARGET_DIR=$target cargo build --release --bin biprism >&2 2>&1)
    cp "$target/release/biprism" "$work/$2"
}
git worktree add --detach "$work/old" "$revision" >/dev/null 2>&1
build "$work/old" was
build "$root" is
if cmp -s "$work/was" "$work/is"; then
    echo "both builds are the same" >&2
    exit 2
fi

# Instructions of planning a picture and of its bands, or of the whole command.
inside='--toggle-collect=biprism::render::plan::Plan::new --toggle-collect=biprism::render::render_band'
count() { # binary, options of callgrind
    binary=$1
    shift
    RAYON_NUM_THREADS=1 valgrind --tool=callgrind --callgrind-out-file=/dev/null "$@" \
        "$work/$binary" render "$work/scene.toml" --out "$work/picture.png" 2>&1 | sed -n 's/^==[0-9]*== Collected : //p'
}
status=0
printf '%-32s %12s %12s %9s   %13s %13s %9s\n' "instructions" "render, was" "is" "change" "command, was" "is" "change"
for scene in "$@"; do
    for level in standard exact; do
        sed "0,/^name/s/^name/accuracy = \"$level\"\nname/" "$scene" > "$work/scene.toml"
        a=$(count was $inside)
        b=$(count is $inside)
        c=$(count was)
        d=$(count is)
        # A render is never half as cheap as another: then a function was inlined and not counted.
        [ $((2 * ${a:-0})) -gt "${b:-0}" ] && [ $((2 * ${b:-0})) -gt "${a:-0}" ] || {
            echo "$scene: $a and $b instructions counted; build both with CARGO_INCREMENTAL=1" >&2
            exit 2
        }
        awk -v s="$(basename "$scene" .toml), $level" -v a="$a" -v b="$b" -v c="$c" -v d="$d" 'BEGIN {
            printf "%-32s %12.0f %12.0f %+8.3f %%   %13.0f %13.0f %+8.3f %%\n", s, a, b, 100*(b/a-1), c, d, 100*(d/c-1)
            exit b > 1.005*a }' || status=1
    done
done
exit $status
