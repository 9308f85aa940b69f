#!/usr/bin/env bash
# Builds the Debian packages, and uses them in a minimal Debian system, as somebody does who has
# nothing else of plait.
#
#   tools/dev/check_packages.sh [KEPT]
#
#   KEPT   a directory for the minimal systems, which later runs use again; default build/minimal
#
# Needs root, for chroot, and a network, for apt. Fails if lintian finds an error or a warning, if the
# program does not run where only its package is installed, if one of the ways of docs/embedding.md
# does not build, or if a file is left after the packages are purged.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
if [ "$(id -u)" -ne 0 ] || [ $# -gt 1 ]; then
  sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$0" >&2
  exit 2
fi
kept=${1:-build/minimal}
step() { printf '\n==== %s (after %d s)\n' "$*" "$SECONDS"; }

# inside COMMAND...: in the minimal system of this run.
inside() {
  chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
    DEBIAN_FRONTEND=noninteractive "$@"
}
apt_get() {
  inside apt-get -qq -o Dpkg::Use-Pty=0 "$@" >"$kept/apt.log" 2>&1 || { cat "$kept/apt.log"; exit 1; }
}
install_inside() { apt_get install --yes --no-install-recommends "$@"; }

# begin SYSTEM: a copy of a system that is kept, for this run.
begin() {
  rm -rf "$root"
  mkdir -p "$root"
  tar -C "$root" --exclude='./dev/*' -xf "$kept/$1.tar"
  mknod -m 666 "$root/dev/null" c 1 3
  mknod -m 666 "$root/dev/urandom" c 1 9
  cp /etc/resolv.conf "$root/etc/"
  apt_get update
}

# Names of all files but those that dpkg and apt keep for themselves.
files() {
  (cd "$root" && find . \( -path ./packages -o -path ./var/lib/dpkg -o -path ./var/lib/apt \
    -o -path ./var/cache -o -path ./var/log \) -prune -o -print | LC_ALL=C sort)
}

tools/dev/install_packages.sh build packages
step "build"
cmake --preset package --log-level=WARNING
cmake --build --preset package --parallel "$(nproc)"
rm -f build/package/*.deb
cpack --preset package >build/package/cpack.log || { cat build/package/cpack.log; exit 1; }
ls -sh1 build/package/*.deb

step "lintian"
lintian --allow-root --fail-on error,warning build/package/*.deb
echo "lintian: no error, no warning"

mkdir -p "$kept"
kept=$(cd "$kept" && pwd)
root=$kept/run
trap 'rm -rf "$root"' EXIT
if [ ! -f "$kept/base.tar" ]; then
  step "minimal system"
  mmdebstrap --quiet --variant=minbase bookworm "$kept/base.tar"
fi
if [ ! -f "$kept/compiler.tar" ]; then
  step "minimal system with a compiler"
  begin base
  install_inside g++ make cmake pkg-config
  tar -C "$root" -cf "$kept/compiler.tar" .
fi

# begin_with_packages SYSTEM: also with the packages in /packages.
begin_with_packages() {
  begin "$1"
  files >"$kept/before"
  mkdir "$root/packages"
  cp build/package/*.deb "$root/packages/"
}
# deb PACKAGE: its file, as the system of this run names it.
deb() { echo "/$(cd "$root" && echo packages/"$1"_*.deb)"; }

# end_without_packages: purges them and what came with them, and compares the files.
end_without_packages() {
  apt_get purge --yes --autoremove '?name(plait)'
  files >"$kept/after"
  if ! diff "$kept/before" "$kept/after"; then
    echo "check_packages: expected the same files as before, found those marked with >" >&2
    exit 1
  fi
  echo "purged: no file is left of $(wc -l <"$kept/after")"
}

step "the program, in a system with nothing else"
begin_with_packages base
install_inside "$(deb libplait0)" "$(deb plait)"
inside plait --help | head -n 2
inside plait generate icosphere /tmp/sphere.ply --vertices 642 >/dev/null
inside plait subdivide /tmp/sphere.ply /tmp/sphere.plait --levels 3 --backend compressed >/dev/null
inside plait verify /tmp/sphere.plait
inside bash -c 'source /usr/share/bash-completion/completions/plait && complete -p plait'
rm -r "$root"/tmp/sphere*
end_without_packages

step "the Python package, in a system with nothing else"
begin_with_packages base
install_inside "$(deb libplait0)" "$(deb python3-plait)"
inside python3 -c 'import numpy, plait
store = plait.create(numpy.eye(4, 3), [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
store.subdivide(3)
print(store.mesh().vertices.shape)'
end_without_packages

step "the library, in a system with a compiler"
begin_with_packages compiler
install_inside "$(deb libplait0)" "$(deb libplait-dev)"
mkdir "$root/tmp/outside"
cp -r tests/outside/{every_component.cpp,digests.cpp,project,use_plait.sh} "$root/tmp/outside/"
# What each way prints is compared with what the first one prints.
use() {
  inside env CXX=/usr/bin/g++ /tmp/outside/use_plait.sh "$1" "$2" /usr "/tmp/outside/$1"
}
use shared ""
use pkg-config /tmp/outside/shared/every_component
mapfile -t suggested < <(inside dpkg-query --show --showformat='${Suggests}' libplait-dev |
  tr ',' '\n' | tr -d ' ' | grep -v '^pkg-config$')  # pkg-config is there
install_inside "${suggested[@]}"
for how in static pkg-config-static; do use $how /tmp/outside/shared/every_component; done
rm -r "$root/tmp/outside"
inside apt-mark auto "${suggested[@]}" >/dev/null
end_without_packages

step "done"
