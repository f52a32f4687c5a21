#!/usr/bin/env bash
# Makes docs/src/gtkwave.png, GTKWave as it opens a run of the scene `glass`, docs/src/frames.png, the frames of the image
# composition machine, and docs/src/overflow.png, the run of the chapter on reading waveforms. Needs GTKWave, Xvfb and ImageMagick.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# shot PICTURE WIDTHxHEIGHT EDIT ARGUMENT...: a run with these arguments, without the title, the tools and the list of
# scopes. EDIT changes the save file.
shot() {
    picture=$1 crop=$2 edit=$3
    shift 3
    cargo run --release --quiet -- run "$@" --quiet --out "$folder"
    sed -i "$edit" "$folder/wave.gtkw"
    export folder picture crop
    xvfb-run -a -s "-screen 0 1600x1000x24" bash -c '
        gtkwave "$folder/wave.gtkw" >/dev/null 2>&1 &
        sleep 5
        import -window root -crop "$crop+229+100" +repage -depth 8 -colors 64 "$picture"
        kill %1'
}

shot docs/src/gtkwave.png 1370x860 '' --width 64 --height 48 --wave 0..400
# With each step of the zoom, twice as many cycles are seen.
shot docs/src/frames.png 1370x210 's/^\*-[0-9.]*/*-20/' --arch composer --frames 4 --width 256 --height 192 --wave all \
    --wave-scope wires.draws,wires.merges,wires.composes,wires.shows,wires.swap
# All groups are opened.
shot docs/src/overflow.png 1370x860 's/^@c00200$/@800200/; s/^@1401200$/@1000200/' --scene docs/src/overflow.csv \
    -p section_capacity=2 -p sections=8 -p outside_sections=0 -p sorter_depth=4 --follow-pixel 1,0 \
    --wave-memory chains.ssa.table:1..2,chains.nsa.table:0..1 \
    --wave-scope 'wires.phase,*.label,wires.chains.grant,*.section_taken,*.stored,*.blended,memories'
