#!/usr/bin/env bash
# Runs the program of the README in the current directory, and fails unless its store is what it should be.
#
#   first_store_test.sh PLAIT FIRST_STORE
#
# Independent of plait are: the number of vertices, by Euler's formula from the header of the mesh's
# file; and that Loop's scheme stays inside the bounding box of the base mesh. The digest must be that
# of another executor.
set -euo pipefail
plait=$1 first_store=$2
fail() { echo "first_store_test: $*" >&2; exit 1; }

"$plait" generate molecule molecule.ply --vertices 3000 --seed 5
"$first_store" >printed
if "$first_store" >again 2>refused; then fail "the second run replaced the store"; fi
grep -q "first.plait" refused || fail "expected a refusal that names the store, found '$(cat refused)'"
cat printed

# A refinement makes a vertex on each edge, and quarters each face. So with V vertices and F faces
# without border, E = 3 F / 2, level 3 has V + E (1 + 4 + 16) vertices.
header() { head -c 300 molecule.ply | awk -v name="$1" '$1 == "element" && $2 == name { print $3 }'; }
expected=$(($(header vertex) + 3 * $(header face) / 2 * 21))
found=$("$plait" info --json first.plait | tr -d ' \n' | sed -E 's/.*"finest":\{[^}]*"vertices":([0-9]+).*/\1/')
[ "$found" = "$expected" ] || fail "expected $expected vertices, found '$found'"

# The corners of the bounding box, and the point that the program printed.
head_bytes=$(($(grep -abo end_header molecule.ply | cut -d: -f1) + 11))
od -An -v -w12 -t f4 -j $head_bytes -N $((12 * $(header vertex))) molecule.ply |
  awk -v printed="$(cat printed)" '
    {
      for (k = 1; k <= 3; ++k) {
        if (NR == 1 || $k < low[k]) low[k] = $k
        if (NR == 1 || $k > high[k]) high[k] = $k
      }
    }
    END {
      split(printed, point, " ")
      for (k = 1; k <= 3; ++k) if (point[k] == "" || point[k] < low[k] || point[k] > high[k]) exit 1
    }' || fail "expected a point inside the base mesh, found '$(cat printed)'"

"$plait" subdivide molecule.ply other.plait --levels 3 --normals --executor transparent >/dev/null
first=$("$plait" digest first.plait) other=$("$plait" digest other.plait)
[ "$first" = "$other" ] || fail "expected the digest $other, found $first"
