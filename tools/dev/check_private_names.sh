#!/usr/bin/env bash
# Fails if two sources of a part of the library use one name in their unnamed namespaces. The release
# build joins sources (CMAKE_UNITY_BUILD): equal functions would be an error of the compiler there, but of
# two overloads one source could silently call the other's. Aliases may be equal, because the compiler
# accepts only those of the same type.
#
#   tools/dev/check_private_names.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

failures=0
for part in engine backends kernels scans jobs c; do
  tags=$(find "$part" -name '*.cpp' | ctags -L - --languages=C++ --c++-kinds=fvgcsu --fields=+s --extras=-q -f -)
  if [ -z "$tags" ]; then
    echo "check_private_names: found no name in $part/" >&2
    exit 1
  fi
  found=$(awk -F '\t' '
    {
      scope = ""
      for (i = 4; i <= NF; ++i) if ($i ~ /^(namespace|class|struct|union|enum|function):/) scope = $i
      if (scope !~ /^namespace:.*__anon[0-9a-f]+$/ || ($1, $2) in seen) next
      seen[$1, $2] = 1
      ++sources[$1]
      places[$1] = places[$1] " " $2
    }
    END { for (name in sources) if (sources[name] > 1) print name ":" places[name] }' <<<"$tags" | sort)
  if [ -n "$found" ]; then
    echo "check_private_names: expected each private name in one source of $part/, found" >&2
    printf '%s\n' "$found" >&2
    failures=1
  fi
done
exit $failures
