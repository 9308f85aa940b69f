#!/usr/bin/env bash
# Fails if a program in C that was compiled with the plait.h of the last release would break with
# this one. Functions and constants may be added. c/plait.abi describes the interface of the last release.
#
#   tools/dev/check_c_abi.sh           compares
#   tools/dev/check_c_abi.sh --write   writes c/plait.abi: at a release, or with a new
#                                      PLAIT_ABI_VERSION
#
# The description has what a compiler sees: functions, and the types that they use. So it is made of a
# library in C that has an empty body for each function of plait.h, and not of libplait, whose types
# in C++ are no part of the interface.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
released=c/plait.abi
header=c/include/plait.h

mode=compare
case ${1:-} in
  '') ;;
  --write) mode=write ;;
  *)
    echo "check_c_abi: unknown argument '$1'; there is --write" >&2
    exit 2
    ;;
esac
if ! command -v abidw >/dev/null; then
  echo "check_c_abi: abidw is missing; install it: tools/dev/install_packages.sh checks" >&2
  exit 1
fi

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# Each set of constants gets a name, that of its first constant, and a variable of its type.
awk '/^enum {$/ { getline first; split(first, word, / *=/); sub(/^ */, "", word[1])
                  print "enum of_" word[1] " {"; print first; sets = sets "extern enum of_" word[1] \
                    " constants_" word[1] ";\n"; next }
     { print }
     END { printf "%s", sets }' "$header" >"$scratch/plait.h"
{
  echo '#include "plait.h"'
  awk '/^PLAIT_API / { declaration = 1 }
       declaration { if (sub(/;$/, " { __builtin_trap(); }")) declaration = 0; print }
       /^PLAIT_API .*} *$/ { declaration = 0 }' "$header"
  sed -n 's/^extern \(enum of_.*\)/\1/p' "$scratch/plait.h"
} >"$scratch/interface.c"
declared=$(grep -c '^PLAIT_API ' "$header")
bodies=$(grep -c '__builtin_trap' "$scratch/interface.c")
if [ "$declared" -ne "$bodies" ]; then
  echo "check_c_abi: $header: $declared functions, found the end of $bodies" >&2
  exit 1
fi
(cd "$scratch" && ${CC:-cc} -std=c11 -g -O0 -w -shared -fPIC -o libplait.so interface.c)
abidw --no-show-locs --no-corpus-path --no-comp-dir-path --out-file "$scratch/plait.abi" \
  "$scratch/libplait.so"

if [ $mode = write ]; then
  cp "$scratch/plait.abi" "$released"
  echo "check_c_abi: wrote $released, $declared functions"
  exit
fi
if ! abidiff --no-added-syms --no-show-locs "$released" "$scratch/plait.abi" >"$scratch/report"; then
  cat "$scratch/report" >&2
  echo "check_c_abi: $header changed for programs that were compiled with the last release; fields at" \
    "the end of a struct with struct_size are no break: --write accepts them" >&2
  exit 1
fi
echo "check_c_abi: $declared functions, compatible with the last release"
