#!/usr/bin/env bash
# Installs missing packages, builds a release, generates a base mesh of 26,016 vertices, subdivides
# it to level 5 (26.6 million vertices) with normals on the default backend, verifies the store,
# prints the figures and renders the surface.
#
#   tools/quickstart.sh [DIRECTORY]        default: out/quickstart
#
# The directory then holds molecule.ply, surface.plait (about 0.65 GB), surface.png and
# subdivide.json. A second run replaces these four and no other file.
set -euo pipefail

case ${1:-} in
  -h | --help)
    sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0"
    exit 0
    ;;
  -*)
    echo "tools/quickstart.sh: unknown option '$1'; usage: tools/quickstart.sh [DIRECTORY]" >&2
    exit 2
    ;;
esac
if [ $# -gt 1 ]; then
  echo "tools/quickstart.sh: one directory at most; usage: tools/quickstart.sh [DIRECTORY]" >&2
  exit 2
fi

results=
if [ $# -eq 1 ]; then
  mkdir -p -- "$1"
  results=$(cd -- "$1" && pwd)
fi
cd "$(dirname "${BASH_SOURCE[0]}")/.."
if [ -z "$results" ]; then
  mkdir -p out/quickstart
  results=$PWD/out/quickstart
fi

plait=build/release/tools/plait
mesh=$results/molecule.ply
store=$results/surface.plait
picture=$results/surface.png
figures=$results/subdivide.json

step() { printf '\n-- %s\n' "$*"; }

# figure KEY: the value of a key in the report of subdivide. Keys of inner objects do not count.
figure() {
  local value
  value=$(tr '\n' ' ' <"$figures" |
    sed -E 's/^[^{]*\{//; :inner; s/\{[^{}]*\}//; t inner' |
    grep -oE "\"$1\"[[:blank:]]*:[[:blank:]]*(\"[^\"]*\"|[^],} ]+)" |
    head -n 1 | sed -E 's/^"[^"]*"[[:blank:]]*:[[:blank:]]*//; s/^"(.*)"$/\1/') || true
  printf '%s' "${value:-unknown}"
}
mebibytes() { figure "$1" | awk '/^[0-9]/ { printf "%.1f MiB", $1 / 1048576; next } { print }'; }
seconds() { figure "$1" | awk '/^[0-9]/ { printf "%.2f s", $1; next } { print }'; }
grouped() { figure "$1" | sed -E ':again; s/^([0-9]+)([0-9]{3})($|,)/\1,\2\3/; t again'; }

step "packages and build"
tools/dev/install_packages.sh build
# All that cmake --install takes, compiled as tools/test.sh compiles it.
cmake --preset release -DPLAIT_TOOLS=ON -DPLAIT_WERROR=OFF \
  -DPLAIT_BENCH=OFF -DPLAIT_EXAMPLES=OFF -DPLAIT_TESTS=OFF --log-level=WARNING
cmake --build --preset release --parallel "$(nproc)"

step "base mesh"
rm -f -- "$mesh"
"$plait" generate molecule "$mesh" --vertices 26016 --seed 1

step "subdivide to level 5, with normals"
"$plait" subdivide "$mesh" "$store" --levels 5 --normals --force --json >"$figures"

step "the store"
"$plait" info "$store"

step "verify"
"$plait" verify "$store"

step "picture"
rm -f -- "$picture"
"$plait" render "$store" "$picture"

step "figures"
cat <<END
vertices       $(grouped vertices), position and normal each, levels 0 to $(figure levels)
time           $(seconds seconds) in all, $(seconds refine_seconds) of it refining
speed          $(figure ns_per_vertex | awk '/^[0-9]/ { printf "%.1f", $1; next } { print }') ns a vertex
executor       $(figure executor), $(figure threads) thread(s), layout $(figure layout), span $(figure span)
disk           $(mebibytes stored_bytes) stored, $(mebibytes bytes_written) written, $(mebibytes bytes_read) read (backend $(figure backend))
memory         $(mebibytes peak_rss_bytes) at most, with a budget of $(mebibytes budget_bytes)
digest         $("$plait" digest "$store")

mesh           $mesh
store          $store
picture        $picture
all figures    $figures
END
