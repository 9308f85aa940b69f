#!/usr/bin/env bash
# Builds the program of tests/outside/every_component.cpp as somebody else does, runs it, and fails
# unless it prints what INSIDE prints, the same program built with plait.
#
#   use_plait.sh HOW INSIDE PREFIX WORK
#
#   INSIDE   may be empty: then the program only runs
#   HOW      shared, static: find_package; pkg-config, pkg-config-static; subproject
#   PREFIX   where plait is installed; for subproject: plait's folder
#   WORK     a directory to build in; it is emptied
#
# Of a subproject, the part of the library that includes headers of all others and the program are compiled,
# and not linked: the library is the one that is tested inside.
#
# CXX is the compiler, and must be given with an absolute path.
set -euo pipefail

how=$1 inside=$2 prefix=$3 work=$4 only=
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$work"
mkdir -p "$work"

# require_flag COMMAND: the flag that keeps the bits of a program's own rules the same everywhere.
require_flag() {
  if [[ $1 != *-ffp-contract=off* ]]; then
    echo "use_plait: expected -ffp-contract=off, found '$1'" >&2
    exit 1
  fi
}

# by_cmake TARGETS OPTION...: the program of the project, linked to these targets.
by_cmake() {
  local targets=$1
  shift
  cmake -S "$here/project" -B "$work" -DCMAKE_CXX_COMPILER="$CXX" -DPLAIT_LINK="$targets" "$@" \
    -DCMAKE_EXPORT_COMPILE_COMMANDS=ON --no-warn-unused-cli --log-level=WARNING >"$work.log" ||
    { cat "$work.log"; exit 1; }
  require_flag "$(grep 'command.*every_component' "$work/compile_commands.json")"
  cmake --build "$work" --parallel 2 ${only:+--target $only} >"$work.log" || { cat "$work.log"; exit 1; }
}

# by_pkg_config FLAG...: the same by one command, as in docs/embedding.md.
by_pkg_config() {
  local flags
  read -r -a flags <<<"$(pkg-config --cflags plait)"
  require_flag "${flags[*]}"
  "$CXX" -std=c++20 "$here/every_component.cpp" -o "$work/every_component" "${flags[@]}" "$@"
}

if [ "$how" != subproject ]; then
  PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name plait.pc)")
  export PKG_CONFIG_PATH
fi
expected=libplait.so.0
case $how in
  shared)
    # Who links the shared library needs no other package.
    by_cmake "plait::engine;plait::backends;plait::kernels" -DCMAKE_PREFIX_PATH="$prefix" \
      "-DPLAIT_COMPONENTS=engine;backends;kernels" -DCMAKE_DISABLE_FIND_PACKAGE_Boost=ON \
      -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON -DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON \
      -DCMAKE_DISABLE_FIND_PACKAGE_PkgConfig=ON
    ;;
  static)
    by_cmake plait::plait_static -DCMAKE_PREFIX_PATH="$prefix" -DPLAIT_COMPONENTS=static
    expected=
    ;;
  pkg-config)
    read -r -a libs <<<"$(pkg-config --libs plait)"
    by_pkg_config "${libs[@]}"
    export LD_LIBRARY_PATH=${PKG_CONFIG_PATH%/*}
    ;;
  pkg-config-static)
    read -r -a libs <<<"$(pkg-config --static --libs plait)"
    by_pkg_config "$(pkg-config --variable=libdir plait)/libplait.a" -Wl,--as-needed "${libs[@]}"
    expected=
    ;;
  subproject)
    only="plait_c every_component_compiled"
    by_cmake plait::plait -DPLAIT_SOURCE="$prefix" -DCMAKE_UNITY_BUILD=ON \
      -DCMAKE_OPTIMIZE_DEPENDENCIES=ON
    exit 0
    ;;
  *)
    echo "use_plait: unknown way '$how'" >&2
    exit 2
    ;;
esac

"$work/every_component" >"$work.printed"
if [ -n "$inside" ]; then
  "$inside" >"$work.expected"
  if ! diff "$work.expected" "$work.printed"; then
    echo "use_plait: the program printed the lines marked with >, expected those marked with <" >&2
    exit 1
  fi
fi
linked=$(ldd "$work/every_component" | awk '$1 ~ /^libplait/ { print $1 }')
if [ "$linked" != "$expected" ]; then
  echo "use_plait: expected the program to link '$expected', found '$linked'" >&2
  exit 1
fi
cat "$work.printed"
