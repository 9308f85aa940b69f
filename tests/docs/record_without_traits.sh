#!/usr/bin/env bash
# Fails unless a compiler says of a record type without RecordTraits what is to be written, in one message.
#
#   record_without_traits.sh COMPILER INCLUDE_DIRECTORIES
#
# The directories have colons between them.
set -euo pipefail
compiler=$1 directories=$2
fail() { echo "record_without_traits: $*" >&2; exit 1; }

cat >program.cpp <<'END'
#include "plait/store.h"
struct Material {
  float density, stiffness;
};
plait::AttributeSchema schema() { return plait::schema_of<Material>("material"); }
END
arguments=(-std=c++20 -fsyntax-only)
IFS=: read -ra folders <<<"$directories"
for folder in "${folders[@]}"; do [ -z "$folder" ] || arguments+=(-I "$folder"); done
if "$compiler" "${arguments[@]}" program.cpp 2>errors; then fail "the program was compiled"; fi
count=$(grep -c 'error:' errors)
[ "$count" = 1 ] || fail "expected one error, found $count: $(cat errors)"
grep -q 'needs RecordTraits, before it is used' errors || fail "found: $(cat errors)"
