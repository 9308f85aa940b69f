#!/usr/bin/env bash
# Builds all examples outside the tree, with the package that is installed, and runs them. What they
# print or leave is held against values that they did not compute.
#
#   use_examples.sh SOURCE PREFIX WORK
#
#   SOURCE   plait's source: the examples, and the scripts that check some of them
#   PREFIX   where plait is installed, with its programs
#   WORK     a directory to build and run in; it is emptied
#
# CC and CXX are the compilers, and must be given with absolute paths.
set -euo pipefail

source=$1 prefix=$2 work=$3
fail() { echo "use_examples: $*" >&2; exit 1; }
rm -rf "$work"
mkdir -p "$work/run"

cmake -S "$source/tests/outside/examples" -B "$work/build" -DCMAKE_C_COMPILER="$CC" \
  -DCMAKE_CXX_COMPILER="$CXX" -DCMAKE_BUILD_TYPE= -DCMAKE_CXX_FLAGS=-O1 -DCMAKE_PREFIX_PATH="$prefix" \
  -DEXAMPLES="$source/examples" >"$work/log" || { cat "$work/log"; exit 1; }
cmake --build "$work/build" --parallel 2 >"$work/log" || { cat "$work/log"; exit 1; }

built=$work/build
plait=$prefix/bin/plait
cd "$work/run"

# run TEXT EXAMPLE ARGUMENTS...: it succeeds, and prints TEXT.
run() {
  local text=$1
  shift
  "$built/$@" >printed 2>&1 || { cat printed; fail "$*: failed"; }
  [[ $(cat printed) == *"$text"* ]] || { cat printed; fail "$*: expected '$text'"; }
  echo "use_examples: $*"
}

# These fail unless the results that they compare agree.
for example in loop_both_ways own_rule transparent_loop; do run '' $example; done
for example in own_kernel displaced_surface; do run '' $example $example.plait; done
# Every version doubles the coordinates of a flat surface, without rounding.
run '20 versions, 0 wrong vertices' many_readers many_readers.plait
"$source/tests/acceptance/example_watched_job.sh" "$built/watched_job" \
  "$source/tests/golden/open_octahedron.off"
# The position is that of a Loop subdivision by a program of a few lines that uses no plait.
run $'side: -0.2930 0.2930 0.0000\na patch has 2145 vertices and 4096 triangles' \
  first_store_in_c in_c.plait
"$source/tests/docs/first_store_test.sh" "$plait" "$built/first_store" >first_store.log || fail "first_store: failed"

# The plug-ins store what a store in memory holds, and keep the promises of a backend.
digest() { "$plait" subdivide molecule.ply "$@" --levels 3 --digest | tail -n 1; }
expected=$(digest --backend memory)
codec=(--plugin "$built/own_codec.so" --compress x-delta+shuffle,x-runs)
found=$(digest coded.plait "${codec[@]}")
[ "$found" = "$expected" ] || fail "own_codec: expected the digest $expected, found $found"
found=$(digest --backend x-map --plugin "$built/own_backend.so")
[ "$found" = "$expected" ] || fail "own_backend: expected the digest $expected, found $found"
"$prefix/bin/plait-conformance" --plugin "$built/own_backend.so" --backend x-map >printed ||
  { cat printed; fail "own_backend: broke a promise"; }
grep -q ' 0 broken' printed || { cat printed; fail "own_backend: expected no broken promise"; }
echo "use_examples: own_codec, own_backend"

rm -rf "$work/run"
