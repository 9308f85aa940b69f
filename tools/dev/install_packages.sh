#!/usr/bin/env bash
# Installs the Debian packages that plait needs, as far as they are missing.
#
#   tools/dev/install_packages.sh [library] [build] [tests] [launchers] [viewers] [checks] [fuzz] [packages]
#                                 [pages] [bench]                     default: build tests
#
#   library    what the library needs, and nothing else of the project
#   build      the same and what the program needs
#   launchers  what else starts the parts of a plan in tests: MPICH, Snakemake, Slurm (900 MB). Optional
#   viewers    other people's programs that read stores and exports in tests of the Python package: VTK,
#              Blender, notebooks (800 MB). Optional; the tests skip what is not there. ParaView is one
#              more, but Debian's package takes the place of python3-vtk9: apt-get install python3-paraview
#   packages   what tools/dev/check_packages.sh needs
#   pages      what the tests of pages need: a browser (80 MB, 300 MB installed). Optional; CI skips them
#   bench      what measurements compare plait with: other libraries, fio, and file systems. Optional
#
# This script is the only list of packages. It needs root or sudo only if a package is missing. On a
# system without dpkg it prints the names of the packages and installs nothing.
set -euo pipefail

library_packages=(
  g++ cmake make pkg-config libboost-iostreams-dev libtbb-dev libfmt-dev
  libzstd-dev liblz4-dev libxxhash-dev liburing-dev libhwy-dev libpng-dev nlohmann-json3-dev
)
build_packages=(
  "${library_packages[@]}" ninja-build ccache zlib1g-dev libcli11-dev libcpp-httplib-dev
)
tests_packages=(
  catch2 python3-numpy python3-pytest python3-dask python3-matplotlib python3-meshio assimp-utils
  strace bindfs parallel python3-distributed openmpi-bin libopenmpi-dev mypy python3-build
)
launchers_packages=(mpich libmpich-dev snakemake slurm-wlm munge)
viewers_packages=(python3-vtk9 blender python3-nbclient python3-ipykernel)
# The versions are fixed, because another clang-format formats the same code differently.
checks_packages=(clang-format-14 clang-tidy-14 doxygen universal-ctags)
fuzz_packages=(clang-14 libclang-rt-14-dev)
packages_packages=(lintian mmdebstrap)
pages_packages=(chromium)
bench_packages=(
  libblosc-dev libfpzip-dev libmeshoptimizer-dev libzfp-dev libdraco-dev libosd-dev libcgal-dev libopenmesh-dev
  fio xfsprogs btrfs-progs
)

groups=("$@")
[ ${#groups[@]} -gt 0 ] || groups=(build tests)
wanted=()
for group in "${groups[@]}"; do
  case $group in
    library) wanted+=("${library_packages[@]}") ;;
    build) wanted+=("${build_packages[@]}") ;;
    tests) wanted+=("${tests_packages[@]}") ;;
    launchers) wanted+=("${launchers_packages[@]}") ;;
    viewers) wanted+=("${viewers_packages[@]}") ;;
    checks) wanted+=("${checks_packages[@]}") ;;
    fuzz) wanted+=("${fuzz_packages[@]}") ;;
    packages) wanted+=("${packages_packages[@]}") ;;
    pages) wanted+=("${pages_packages[@]}") ;;
    bench) wanted+=("${bench_packages[@]}") ;;
    *)
      echo "install_packages: unknown group '$group'; there are library, build, tests, launchers, viewers, checks, fuzz, packages, pages, bench" >&2
      exit 2
      ;;
  esac
done

if ! command -v dpkg-query >/dev/null; then
  echo "install_packages: not a Debian system; needed are: ${wanted[*]}" >&2
  exit 0
fi

missing=()
for package in "${wanted[@]}"; do
  status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
  # If a package is installed for several architectures, the status appears once for each.
  case $status in
    installed*) ;;
    *) missing+=("$package") ;;
  esac
done
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "install_packages: not root and no sudo; please install: ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

echo "installing ${missing[*]}"
apt_get=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0)
"${apt_get[@]}" update
"${apt_get[@]}" install --yes --no-install-recommends "${missing[@]}" >/dev/null
