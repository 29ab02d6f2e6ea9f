#!/usr/bin/env bash
# Loads the HTML report of a project in a headless Chromium (Debian: apt-get install chromium) and looks whether the page drew
# itself without an error, at a desktop's and at a phone's width. With a second argument it keeps pictures there.
#
#   tests/browser.sh 'samples/transfer-line/line.il --cpu Q26UDV' [DIRECTORY]
set -euo pipefail
cd "$(dirname "$0")/.."
project=${1:-samples/transfer-line/line.il --cpu Q26UDV}
pictures=${2:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
[ -n "${SCANBOUND:-}" ] || cargo build --quiet --release
# shellcheck disable=SC2086 # the project's options are words of their own
"${SCANBOUND:-target/release/scanbound}" audit $project -o "$work/report.html" 2> "$work/stderr" || { cat "$work/stderr"; exit 1; }
chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || {
    echo "no Chromium: apt-get install chromium"
    exit 2
}
for size in 1280,900 390,844; do
    flags=(--headless=new --no-sandbox --disable-gpu --hide-scrollbars "--window-size=$size" --enable-logging=stderr --v=0 --virtual-time-budget=10000)
    "$chromium" "${flags[@]}" --dump-dom "file://$work/report.html#r1" > "$work/dom.html" 2> "$work/log"
    grep -q 'data-ready="yes"' "$work/dom.html" || { echo "$size: the page did not draw itself"; grep CONSOLE "$work/log"; exit 1; }
    if grep -q 'CONSOLE.*\(Error\|Refused\)' "$work/log"; then grep CONSOLE "$work/log"; exit 1; fi
    rungs=$(grep -o '<section class="rung"' "$work/dom.html" | wc -l || true)
    drawn=$(grep -o '<svg width' "$work/dom.html" | wc -l || true)
    [ "$rungs" -gt 0 ] || { echo "$size: no rungs"; exit 1; }
    [ "$drawn" -gt 0 ] || { echo "$size: no rung is drawn"; exit 1; }
    if [ -n "$pictures" ]; then
        for part in answer rungs; do
            "$chromium" "${flags[@]}" "--screenshot=$pictures/$part-${size%,*}.png" "file://$work/report.html#$part" 2> /dev/null
        done
    fi
    echo "$size: $rungs rungs, $drawn of them drawn at once; $(stat -c %s "$work/report.html") bytes"
done
