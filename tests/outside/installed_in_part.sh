#!/usr/bin/env bash
# Optional packages that are there in part never stop a build: plait is configured with them in front of the
# whole ones, and must say in one line each what it leaves out.
#
#   installed_in_part.sh SOURCE WORK        CMAKE, CXX and CMAKE_GENERATOR are from the environment
set -euo pipefail

source=$1 work=$2
rm -rf "$work"
mkdir -p "$work/bin" "$work/include" "$work/python"

# program NAME TEXT: stands in front of the program of that name.
program() {
  printf '#!/bin/sh\n%s\n' "$2" >"$work/bin/$1"
  chmod +x "$work/bin/$1"
}
# package NAME TEXT: a CMake package in front of the one of that name.
package() {
  mkdir -p "$work/prefix/lib/cmake/$1"
  echo "$2" >"$work/prefix/lib/cmake/$1/$1Config.cmake"
}
export PATH=$work/bin:$PATH

# configure NAME EXPECTED...: each EXPECTED begins a line of what CMake says.
configure() {
  local name=$1 expected
  shift
  if ! "${CMAKE:-cmake}" -S "$source" -B "$work/$name" -DCMAKE_PREFIX_PATH="$work/prefix" -DCMAKE_CXX_COMPILER="$CXX" \
    >"$work/$name.log" 2>&1; then
    cat "$work/$name.log" >&2
    echo "installed_in_part: $name: expected plait to be configured" >&2
    exit 1
  fi
  for expected in "$@"; do
    if [ "$(grep -c "^plait: $expected" "$work/$name.log")" -ne 1 ]; then
      cat "$work/$name.log" >&2
      echo "installed_in_part: $name: expected one line that begins with 'plait: $expected'" >&2
      exit 1
    fi
  done
}

# Open MPI's wrappers without its headers, as Debian's openmpi-bin without libopenmpi-dev.
program mpiexec 'exit 1'  # CMake looks for the wrappers beside it
for wrapper in mpicc mpicxx mpic++ mpiCC; do
  program $wrapper 'echo "-I/nowhere/openmpi/include -L/nowhere/openmpi/lib -lmpi"'
done
program ccache 'exit 1'
echo '#error half of liburing' >"$work/include/liburing.h"
echo 'raise ImportError("half of numpy")' >"$work/python/numpy.py"
package OpenMesh 'include(${CMAKE_CURRENT_LIST_DIR}/OpenMeshTargets.cmake)'
CPATH=$work/include PYTHONPATH=$work/python configure things_around \
  "MPI is installed in part (.*), so plait-mpi and its tests are left out" \
  "liburing>=2.0 is installed in part (.*), so transfers by io_uring are left out" \
  "OpenMesh is installed in part (.*), so measurements of OpenMesh are left out" \
  "$work/bin/ccache does not compile, so nothing is cached" \
  "no Python with numpy and pytest found"

# What the program and the tests need: a package whose library is gone, and one whose headers are.
package Catch2 'add_library(Catch2::Catch2 INTERFACE IMPORTED)
set_target_properties(Catch2::Catch2 PROPERTIES INTERFACE_INCLUDE_DIRECTORIES /nowhere/include)'
package CLI11 'message(FATAL_ERROR "the library of CLI11 is gone")'
configure program_and_tests \
  "Catch2 is installed in part (.*), so the tests are left out" \
  "CLI11 is installed in part (the library of CLI11 is gone), so the program and its tests are left out" \
  "CLI11 is installed in part (.*), so the measurements are left out"
