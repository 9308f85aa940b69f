#!/usr/bin/env bash
# A newcomer's first ten minutes with plait, done with the text of the pages: their commands, their
# CMakeLists.txt, their programs. Prints the seconds of each step.
#
#   newcomer.sh SOURCE BUILD WORK
#
#   SOURCE   plait's source
#   BUILD    where plait was built
#   WORK     a directory to work in; it is emptied
#
# Nothing of plait is used but what is installed and what stands on the pages. A place of a page that
# is not found is an error, so that the pages and this script stay together.
set -euo pipefail

source=$1 build=$2 work=$3
blocks=$source/tests/docs/code_blocks.sh
fail() { echo "newcomer: $*" >&2; exit 1; }

# A newcomer's home directory is where the pages put plait.
rm -rf "$work"
mkdir -p "$work/home" "$work/desk"
export HOME=$work/home PATH=$work/home/plait/bin:$PATH
cd "$work/desk"

started=$(date +%s%N)
begun=$started
# done_with WHAT: the end of a step.
done_with() {
  local now
  now=$(date +%s%N)
  printf 'newcomer: %-62s %3d.%02d s\n' "$1" $(((now - begun) / 1000000000)) $(((now - begun) / 10000000 % 100))
  begun=$now
}

# do_as_written PAGE HEADING: runs the commands under a heading.
do_as_written() {
  "$blocks" "$source/$1" sh "$2" >"$work/commands"
  bash -e "$work/commands" >"$work/log" 2>&1 || { tail -n 30 "$work/commands" "$work/log" >&2; fail "$1, $2: failed"; }
}

# do_line PAGE TEXT: runs the line of a page that begins so.
do_line() {
  grep -m 1 "^$2" "$source/$1" >"$work/commands" || fail "$1: no line begins with '$2'"
  bash -e "$work/commands" >"$work/log" 2>&1 || { tail -n 30 "$work/commands" "$work/log" >&2; fail "$1, $2: failed"; }
}

mkdir build
ln -s "$build" build/plain
do_line docs/embedding.md "cmake --install build/plain --prefix ~/plait"
rm -r build
done_with "plait is installed (docs/embedding.md, Install)"
[[ $(command -v plait) == "$HOME"/* ]] || fail "expected a program in $HOME/plait/bin"

do_as_written README.md plait
cmp molecule.png "$source/docs/images/molecule.png" || fail "expected the picture of the README"
done_with "the picture of the README"

do_as_written README.md "On the command line"
done_with "the other commands of the README"

"$blocks" "$source/docs/embedding.md" cmake "With CMake" >"$work/blocks"
sed '/^find_package(plait [0-9.]* CONFIG REQUIRED COMPONENTS/,$d' "$work/blocks" >CMakeLists.txt
"$blocks" "$source/docs/embedding.md" cpp "A first program" >first.cpp
do_as_written docs/embedding.md "With CMake"
grep -q '^plait [0-9.]*: [0-9a-f]\{32\}$' "$work/log" || fail "expected a version and a digest, found $(tail -n 1 "$work/log")"
done_with "a CMake project of one's own (docs/embedding.md)"

"$blocks" "$source/README.md" cpp >first.cpp
do_as_written docs/embedding.md "With pkg-config"
[ "$(tail -n 1 "$work/log" | wc -w)" -eq 3 ] || fail "expected a position, found $(tail -n 1 "$work/log")"
done_with "the seven lines of the README: a store, and a patch of it"

mkdir guide
cd guide
"$blocks" "$source/docs/guide.md" cpp >guide.cpp
export PKG_CONFIG_PATH=$HOME/plait/lib/pkgconfig LD_LIBRARY_PATH=$HOME/plait/lib
read -r -a flags <<<"$(pkg-config --cflags --libs plait)"
g++ -std=c++20 -O1 guide.cpp -o guide "${flags[@]}"
"$source/tests/docs/guide_test.sh" "$PWD/guide" "$source/docs" "$(command -v plait)" >"$work/log" ||
  fail "the guide's program failed"
done_with "patches, own attribute, versions (docs/guide.md), and docs/measuring.md"

begun=$started
done_with "all"
