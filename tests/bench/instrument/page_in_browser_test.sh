#!/usr/bin/env bash
# Opens pages in headless Chromium: no console error, and no hostile text that runs. Keeps a screenshot of each page, light and dark, to look at.
#
#   page_in_browser_test.sh PICTURES PAGE...
#
#   PICTURES   the folder of the screenshots
#
# Skips (77) where there is no Chromium. PLAIT_CHROMIUM names another browser.
set -euo pipefail
pictures=$1
shift
browser=${PLAIT_CHROMIUM:-$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)}
if [ -z "$browser" ]; then
  echo "page_in_browser_test: skipped, because chromium is not installed (tools/dev/install_packages.sh pages)"
  exit 77
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir -p "$pictures"

# look PAGE LOG ARGUMENT...: one run of the browser. Its own messages go to LOG.
look() {
  local page=$1 log=$2
  shift 2
  timeout 250 "$browser" --headless --no-sandbox --disable-gpu --disable-background-networking \
    --no-first-run --disable-extensions --disable-component-update --user-data-dir="$scratch/profile" \
    --enable-logging=stderr --window-size=1100,3000 --hide-scrollbars "$@" "file://$page" 2>"$log"
}

failed=0
for page in "$@"; do
  name=$(basename "$page" .html)
  page=$(realpath "$page")
  look "$page" "$scratch/log" --dump-dom >"$scratch/dom.html" || { cat "$scratch/log" >&2; exit 1; }
  if grep 'CONSOLE' "$scratch/log" >&2 || grep -q data-broken= "$scratch/dom.html"; then
    echo "page_in_browser_test: $name: the lines above are errors of the console, or hostile text has run" >&2
    failed=1
  fi
  look "$page" "$scratch/log" --screenshot="$pictures/$name.png" >/dev/null
  look "$page" "$scratch/log" --screenshot="$pictures/$name-dark.png" --blink-settings=preferredColorScheme=0 >/dev/null
  look "$page" "$scratch/log" --print-to-pdf="$pictures/$name.pdf" --no-pdf-header-footer >/dev/null
  for picture in "$name.png" "$name-dark.png" "$name.pdf"; do
    [ -s "$pictures/$picture" ] || { echo "page_in_browser_test: $name: $picture was not made" >&2; failed=1; }
  done
done
exit $failed
