#!/usr/bin/env bash
# Seeds each fault of faults.txt into a copy of the sources and says whether the tests of the blocks find it.
# Exit status: 0 if all are found, 1 if one survives, 2 if one cannot be seeded.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(git -C "$here" rev-parse --show-toplevel)
copy=$(mktemp -d)
trap 'git -C "$root" worktree remove --force "$copy/tree"; rm -rf "$copy"' EXIT
git -C "$root" worktree add --quiet --detach "$copy/tree"
cd "$copy/tree"
# The tests of a block and of its contract.
tests=(cargo test --quiet -p pellucid-sim -p pellucid-hw -p pellucid-properties)

# Stands for a bar that is escaped.
mark=$'\x01'
trim() { sed -e 's/^ *//' -e 's/ *$//' -e "s/$mark/|/g" <<<"$1"; }
"${tests[@]}" >"$copy/log" 2>&1 || { cat "$copy/log"; echo "the tests fail without a fault"; exit 2; }

survived=0
while IFS='|' read -r file from to what; do
    file=$(trim "$file") from=$(trim "$from") to=$(trim "$to") what=$(trim "$what")
    before=$(<"$file")
    without=${before/"$from"/}
    if [ "$without" = "$before" ] || [ "${without/"$from"/}" != "$without" ]; then
        echo "$file: expected \`$from\` once"
        exit 2
    fi
    printf '%s\n' "${before/"$from"/"$to"}" >"$file"
    if ! "${tests[@]}" --no-run >"$copy/log" 2>&1; then
        cat "$copy/log"
        echo "$file: does not compile with \`$to\`"
        exit 2
    fi
    # A fault may keep a test from ending.
    if timeout 300 "${tests[@]}" >"$copy/log" 2>&1; then
        survived=1
        echo "SURVIVES  $file: $what"
    else
        found=$(grep -E '^    [a-z_:0-9]+$' "$copy/log" | head -1 | tr -d ' ' || true)
        echo "found     $file: $what (by ${found:-a test})"
    fi
    git checkout --quiet -- "$file"
done < <(grep -v '^#' "$here/faults.txt" | sed "s/\\\\|/$mark/g")
exit "$survived"
