#!/usr/bin/env bash
# Makes docs/src/gtkwave.png: GTKWave as it opens a run of the scene `glass`. Needs GTKWave, Xvfb and ImageMagick.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cargo run --release --quiet -- run --width 64 --height 48 --wave 0..400 --quiet --out "$folder"
export folder
xvfb-run -a -s "-screen 0 1600x1000x24" bash -c '
    gtkwave "$folder/wave.gtkw" >/dev/null 2>&1 &
    sleep 5
    # Without the title, the tools and the list of scopes.
    import -window root -crop 1370x860+229+100 +repage -depth 8 -colors 64 docs/src/gtkwave.png
    kill %1'
