#!/usr/bin/env bash
# Fails if a page (*.md) links to a page or a heading that is not there, if it names a file of the
# project that is not there, if the text of a heading runs on, or if a page has code that no test builds.
# Also fails if a comment names a test as its pin ("Pinned by ...") that is not there.
#
#   tools/dev/check_pages.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
failed=0
complain() { echo "check_pages: $*" >&2; failed=1; }

mapfile -t pages < <(git ls-files --cached --others --exclude-standard '*.md')

# Every heading as GitHub names it in links: PAGE#heading.
headings=$(awk '
  /^```/ { code = !code }
  !code && /^#+ / {
    text = tolower($0); sub(/^#+ /, "", text); gsub(/[^a-z0-9 _-]/, "", text); gsub(/ /, "-", text)
    print FILENAME "#" text
  }' "${pages[@]}")

# One line for each link or name: PAGE, a tab, KIND, a tab, TARGET. Code is not searched for links.
while IFS=$'\t' read -r page kind target; do
  case $kind in
    link)
      path=${target%%#*}
      if [ -z "$path" ]; then file=$page; else file=$(realpath -ms --relative-to=. "$(dirname "$page")/$path"); fi
      if [ ! -e "$file" ]; then
        complain "$page: link to '$target': no such file"
      elif [[ $target == *#* ]] && ! grep -qxF "$file#${target#*#}" <<<"$headings"; then
        complain "$page: link to '$target': no such heading"
      fi
      ;;
    file) [[ $target =~ (NAME|TARGET) ]] || compgen -G "$target*" >/dev/null || complain "$page: names '$target': no such file" ;;
    header)
      compgen -G "*/include/$target*" >/dev/null || compgen -G "engine/*/include/$target*" >/dev/null || complain "$page: names '$target': no such header"
      ;;
    place) complain "$page: $target" ;;
  esac
done < <(awk '
  FNR == 1 { code = 0 }
  function each(text, pattern, kind, from,    found) {
    while (match(text, pattern)) {
      found = substr(text, RSTART, RLENGTH)
      text = substr(text, RSTART + RLENGTH)
      print FILENAME "\t" kind "\t" substr(found, from, length(found) - from - (kind == "link" ? 0 : -1))
    }
  }
  /^```/ { code = !code; language = $0; next }
  code && language == "```" && /#include|plait::|int main/ { print FILENAME "\tplace\tline " FNR ": C++ in a block without a language" }
  code { next }
  /^#+ / && length($0) > 60 { print FILENAME "\tplace\tline " FNR ": a heading of more than 60 characters: does its text follow on the same line?" }
  {
    each($0, "\\]\\([^):]+\\)", "link", 3)
    each($0, "`plait/[a-z_/]+\\.h", "header", 2)
    each($0, "`(docs|tests|tools|engine|backends|kernels|jobs|bench|examples|cmake|packaging)/[A-Za-z0-9_./-]+", "file", 2)
  }' "${pages[@]}" | sort -u)

# The test that builds the C++ of a page names the page. The README has an example's.
for page in $(grep -l '^```cpp$' "${pages[@]}"); do
  [ "$page" = README.md ] || grep -rqF "$page" tests ||
    complain "$page: no test builds its C++"
done
# Comments name the tests that pin a formula or a promise: "Pinned by NAME_test.cpp", with or without
# its folder, on one line or on several.
mapfile -t sources < <(git ls-files --cached --others --exclude-standard '*.h' '*.cpp')
while IFS=$'\t' read -r source test; do
  if [[ $test == */* ]]; then
    [ -e "$test" ] || complain "$source: pinned by '$test': no such file"
  else
    git ls-files --cached --others --exclude-standard "tests/*/$test" "tests/$test" | grep -q . ||
      complain "$source: pinned by '$test': no such test"
  fi
done < <(awk '
  function tell(    found) {
    sub(/.*Pinned by /, "", text)
    if ((found = index(text, "; ")) > 0) text = substr(text, 1, found)
    while (match(text, /[A-Za-z0-9_\/]+_test\.(cpp|sh)/)) {
      print source "\t" substr(text, RSTART, RLENGTH)
      text = substr(text, RSTART + RLENGTH)
      if (text ~ /^\.( |$)/) break
    }
    text = ""
    lines = 0
  }
  FNR == 1 && lines > 0 { tell() }
  lines > 0 { line = $0; sub(/^ *\/\/\/? */, "", line); text = text " " line; if (--lines == 0) tell() }
  /Pinned by/ { source = FILENAME; text = $0; lines = 2 }
  END { if (lines > 0) tell() }' "${sources[@]}" | sort -u)

diff <(tests/docs/code_blocks.sh README.md cpp | tail -n +2) examples/first_store.cpp >&2 ||
  complain "README.md: expected the lines of examples/first_store.cpp (>), found those marked with <"
exit $failed
