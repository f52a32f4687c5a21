#!/usr/bin/env bash
# Seeds each fault of faults.txt into a copy of the sources and says which test finds it: one of the crate of blocks, one of
# the contracts or, if none of these does, one of whole machines.
#
#   run.sh [PART]    with PART only the faults of files whose path has it
#
# It builds in target/faults, which is left for the next run.
# Exit status: 0 if all are found, 1 if one survives, 2 if one cannot be seeded.
set -euo pipefail
part=${1:-}
here=$(cd "$(dirname "$0")" && pwd)
root=$(git -C "$here" rev-parse --show-toplevel)
copy=$(mktemp -d)
trap 'git -C "$root" worktree remove --force "$copy/tree"; rm -rf "$copy"' EXIT
git -C "$root" worktree add --quiet --detach "$copy/tree"
cd "$copy/tree"
export CARGO_TARGET_DIR=$root/target/faults CARGO_INCREMENTAL=1 CARGO_PROFILE_TEST_DEBUG=0 CARGO_PROFILE_DEV_DEBUG=0

# What is run, one after the other until a fault is found: what is built in a moment first.
architectures="-p pellucid-tbuffer -p pellucid-rbuffer -p pellucid-mbuffer -p pellucid-composer -p pellucid-dfb -p pellucid-b3d -p pellucid-ppll -p pellucid-fbuffer -p pellucid-accumulate"
stages=("-p pellucid-sim" "-p pellucid-machine -p pellucid-blocks $architectures --lib" "-p pellucid-properties"
    "$architectures --test machine" "-p pellucid --test machine")

# Whether the tests of a stage pass; without end they do not.
passes() { timeout 300 cargo test --quiet $1 >"$copy/log" 2>&1; }
builds() { cargo test --quiet --no-run $1 >"$copy/log" 2>&1; }
fail() { cat "$copy/log"; echo "$1"; exit 2; }
for stage in "${stages[@]}"; do
    builds "$stage" && passes "$stage" || fail "the tests fail without a fault"
done

# Stands for a bar that is escaped.
mark=$'\x01'
trim() { sed -e 's/^ *//' -e 's/ *$//' -e "s/$mark/|/g" <<<"$1"; }

survived=0
while IFS='|' read -r file from to what; do
    file=$(trim "$file") from=$(trim "$from") to=$(trim "$to") what=$(trim "$what")
    [[ $file == *"$part"* ]] || continue
    before=$(<"$file")
    without=${before/"$from"/}
    if [ "$without" = "$before" ] || [ "${without/"$from"/}" != "$without" ]; then
        echo "$file: expected \`$from\` once"
        exit 2
    fi
    printf '%s\n' "${before/"$from"/"$to"}" >"$file"
    found=
    for stage in "${stages[@]}"; do
        builds "$stage" || fail "$file: does not compile with \`$to\`"
        if ! passes "$stage"; then
            # What is to be given to `cargo test` to see it.
            found=$(sed -n -e 's/^error: test failed, to rerun pass `\(.*\)`$/\1/p' "$copy/log")
            found+=$(grep -m 1 -E '^    [a-z_:0-9]+$' "$copy/log" | tr -s ' ' || true)
            : "${found:=a test that does not end}"
            echo "found     $file: $what ($found)"
            break
        fi
    done
    if [ -z "$found" ]; then
        survived=1
        echo "SURVIVES  $file: $what"
    fi
    # What failing tests leave must not help the next fault to be found.
    git checkout --quiet -- "$file"
    git clean --quiet -fdx
done < <(grep -v -e '^#' -e '^$' "$here/faults.txt" | sed "s/\\\\|/$mark/g")
exit "$survived"
