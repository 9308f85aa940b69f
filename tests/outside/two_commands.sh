#!/usr/bin/env bash
# README's two commands share what they build, and plait can be installed after the first one. Both scripts
# run with a program in the place of cmake that notes how it is called; then the real one configures so, and
# builds nothing.
#
#   two_commands.sh SOURCE WORK
set -euo pipefail

source=$1 work=$2
rm -rf "$work"
mkdir -p "$work/bin"
cat >"$work/bin/cmake" <<'END'
#!/bin/sh
printf '%s\n' "$*" >>"$PLAIT_CALLS"
END
printf '#!/bin/sh\nexit 1\n' >"$work/bin/ctest"
printf '#!/bin/sh\necho installed\n' >"$work/bin/dpkg-query"
chmod +x "$work"/bin/*
fail() { echo "two_commands: $*" >&2; exit 1; }

# configure SCRIPT [ARGUMENT...]: as the script does, but in another folder.
configure() {
  local name=$1 arguments
  shift
  : >"$work/$name.calls"
  PLAIT_CALLS=$work/$name.calls PATH=$work/bin:$PATH "$source/tools/$name.sh" "$@" >"$work/$name.log" 2>&1 || true
  read -r -a arguments < <(grep '^--preset release ' "$work/$name.calls") || fail "$name.sh: expected a call of cmake"
  (cd "$source" && cmake "${arguments[@]}" -B "$work/build" >"$work/$name.configured" 2>&1) ||
    { cat "$work/$name.configured" >&2; fail "$name.sh: expected plait to be configured"; }
  grep '"command":' "$work/build/compile_commands.json" | sort >"$work/$name.commands"
}

configure quickstart "$work/results"
[ "$(wc -l <"$work/quickstart.commands")" -gt 20 ] || fail "quickstart.sh: expected commands of a compiler"

# What the rules of installation name and is not there yet must be made by a command of quickstart.sh's build.
target=$(sed -n 's/^--build .*--target \([^ ]*\).*/\1/p' "$work/quickstart.calls")
(cd "$work/build" && ninja -t commands "${target:-all}") >"$work/built"
find "$work/build" -name cmake_install.cmake -exec grep -hoE '"[^";]+"' {} + | tr -d '"' |
  { grep "^$work/build/[^$]*\$" || true; } | sort -u >"$work/installed"
[ -s "$work/installed" ] || fail "expected files of the build to be installed"
while read -r file; do
  if [ ! -e "$file" ] && ! grep -qE "[ /]${file#"$work/build/"}( |\$)" "$work/built"; then
    fail "quickstart.sh does not build $file, which cmake --install takes"
  fi
done <"$work/installed"

configure test
missing=$(comm -23 "$work/quickstart.commands" "$work/test.commands")
[ -z "$missing" ] || { echo "$missing" | head -n 3 >&2; fail "test.sh compiles anew what quickstart.sh has compiled"; }
