#!/usr/bin/env bash
# Fails if an #include violates the layers, if a source file is in no build, or if plait/store.h pulls more than
# a few headers.
#
#   commands, tests -> bench -> tools -> c -> jobs -> kernels, backends -> engine;  examples -> c
#   tools, jobs -> scans -> base, address, mesh of engine
#   inside engine/:  base <- io, address <- mesh <- layout <- blocks <- paging <- format <- store
#                    <- maintenance, execution
#
# The path of a file says its layer: engine/LAYER/... or PART/..., and tools/command_NAME.cpp and
# tools/plait.cpp are the commands, which call what measures in bench/. The path of a public header also says
# what it promises: include/plait/ is stable, include/plait/extend/ is for authors of backends, filters,
# rules and kernels, include/plait/detail/ is what these two need, and no program names it. All other
# headers are private.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

# The layers that each folder of engine/, and each other folder, may include. Layout and address
# only compute, so they may not include io.
engine_layers='base io address mesh layout blocks paging format store maintenance execution'
declare -A may_include=(
  [base]='base'
  [io]='base io'
  [address]='base address'
  [mesh]='base io address mesh'
  [layout]='base address mesh layout'
  [blocks]='base io address mesh layout blocks'
  [paging]='base io address mesh layout blocks paging'
  [format]='base io address mesh layout blocks paging format'
  [store]='base io address mesh layout blocks paging format store'
  [maintenance]='base io address mesh layout blocks paging format store maintenance'
  [execution]='base io address mesh layout blocks paging format store execution'
  [backends]="$engine_layers backends"
  [kernels]="$engine_layers kernels"
  [scans]='base io address mesh scans'
  [jobs]="$engine_layers backends kernels scans jobs"
  [c]="$engine_layers backends kernels jobs c"
  [tools]="$engine_layers backends kernels scans jobs c tools"
  [bench]="$engine_layers backends kernels scans jobs c tools bench"
  [examples]="$engine_layers backends kernels jobs c examples"
  [commands]="$engine_layers backends kernels scans jobs c tools bench commands"
  [tests]="$engine_layers backends kernels scans jobs c tools bench commands tests"
)
# Folders of public headers. A layer without one has private headers only.
public_folders=(engine/*/include {backends,kernels,jobs,c}/include)
# The parts whose private headers a part may include, beside its own.
declare -A sees=(
  [engine]='engine' [backends]='engine backends' [kernels]='engine kernels' [scans]='engine scans'
  [jobs]='engine backends kernels scans jobs' [c]='engine backends kernels jobs c'
  [tools]='engine backends kernels scans jobs c tools bench' [bench]='engine backends kernels scans jobs c tools bench'
  [tests]='engine backends kernels scans jobs c tools bench tests' [examples]=''
)

# System headers that a layer must not include: the library never prints, and layers that only
# compute do no file operations.
declare -A forbidden_system_header=(
  [base]='iostream|fstream|cstdio|unistd\.h|fcntl\.h|sys/.*|boost/(iostreams|interprocess)/.*'
  [io]='iostream'
  [mesh]='iostream'
  [blocks]='iostream'
  [format]='iostream'
  [paging]='iostream'
  [store]='iostream'
  [maintenance]='iostream'
  [execution]='iostream'
  [backends]='iostream'
  [kernels]='iostream'
  [scans]='iostream|fstream|cstdio|unistd\.h|fcntl\.h|sys/.*'
  [jobs]='iostream'
  [c]='iostream|cstdio'
)
forbidden_system_header[address]=${forbidden_system_header[base]}
forbidden_system_header[layout]=${forbidden_system_header[base]}

failures=0
fail() {
  echo "check_layers: $*" >&2
  failures=$((failures + 1))
}

# layer FILE: sets `found_layer` to the layer of a file of the project, or to nothing.
layer() {
  local inner
  found_layer=
  case $1 in
    engine/*/*)
      inner=${1#engine/}
      found_layer=${inner%%/*}
      ;;
    tools/*/*) found_layer=tools ;;
    tools/command_*.cpp | tools/command_bench.h | tools/plait.cpp) found_layer=commands ;;
    *) found_layer=${1%%/*} ;;
  esac
  [ -n "${may_include[${found_layer:-none}]:-}" ] || found_layer=
}

# resolve FROM NAME: sets `found_file` to the file of the project that FROM includes as NAME, or to
# nothing.
resolve() {
  local from=$1 name=$2 folder
  # shellcheck disable=SC2206  # the parts are words
  local folders=("${from%/*}" "${public_folders[@]}" ${sees[${from%%/*}]})
  found_file=
  for folder in "${folders[@]}"; do
    if [ -f "$folder/$name" ] || [ -f "$folder/$name.in" ]; then  # CMake makes a header of its .in
      found_file=$folder/$name
      return
    fi
  done
}

check_include() {
  local from=$1 line=$2 text=$3 own_layer=$4 name
  name=${text#*[<\"]}
  name=${name%%[>\"]*}
  case $text in
    *\<plait/* | *\"*) ;;
    *)
      if [[ -n ${forbidden_system_header[$own_layer]:-} &&
        $name =~ ^(${forbidden_system_header[$own_layer]})$ ]]; then
        fail "$from:$line: layer '$own_layer' must not include <$name>"
      fi
      if [[ $name == tbb/* && ! -f tools/dev/tsan/$name ]]; then
        fail "$from:$line: <$name> has no stand-in for the thread sanitizer in tools/dev/tsan"
      fi
      return
      ;;
  esac
  if [[ $name == *../* ]]; then
    fail "$from:$line: include '$name' climbs out of its folder; name it from the component's root"
    return
  fi
  resolve "$from" "$name"
  if [ -z "$found_file" ]; then
    fail "$from:$line: include '$name' is no file that '${from%%/*}' can see"
    return
  fi
  if [[ $from == */include/plait/* && $found_file != */include/plait/* ]]; then
    fail "$from:$line: public header includes the private $found_file"
  fi
  if [[ $found_file == */include/plait/detail/* ]]; then
    case $from in
      examples/* | tests/outside/* | tests/docs/*)
        fail "$from:$line: a program includes headers of plait/ and plait/extend/, not $name" ;;
    esac
  fi
  layer "$found_file"
  if [ -z "$found_layer" ]; then
    return # reported when that file itself is checked
  fi
  case " ${may_include[$own_layer]} " in
    *" $found_layer "*) ;;
    *) fail "$from:$line: layer '$own_layer' must not include $found_file of layer '$found_layer'" ;;
  esac
}

folders=()
for folder in engine backends kernels scans jobs c tools bench examples tests; do
  [ ! -d "$folder" ] || folders+=("$folder")
done

file_count=0
while IFS= read -r file; do
  file_count=$((file_count + 1))
  layer "$file"
  if [ -z "$found_layer" ]; then
    fail "$file: no layer; give it one in tools/dev/check_layers.sh"
    continue
  fi
  own_layer=$found_layer
  while IFS=: read -r line text; do
    check_include "$file" "$line" "$text" "$own_layer"
  done < <(grep -nE '^[[:blank:]]*#[[:blank:]]*include[[:blank:]]*[<"]' "$file" || true)
done < <(find "${folders[@]}" -type f \( -name '*.h' -o -name '*.cpp' -o -name '*.c' \) | LC_ALL=C sort)

# A source that no CMakeLists.txt names is never compiled, so its tests never run.
while IFS= read -r file; do
  folder=${file%/*}
  named=no
  while :; do
    pattern=${file#"$folder"/}
    pattern="(^|[[:blank:](\"/])${pattern//./\\.}([[:blank:])\"]|\$)"
    if [ -f "$folder/CMakeLists.txt" ] &&
      grep -qE "$pattern" <(sed 's/#.*//' "$folder/CMakeLists.txt"); then
      named=yes
      break
    fi
    [[ $folder == */* ]] || break
    folder=${folder%/*}
  done
  [ "$named" = yes ] || fail "$file: named in no CMakeLists.txt, so it is never built"
done < <(find "${folders[@]}" -type f -regex '.*\.\(c\|cpp\)' | LC_ALL=C sort)

# What every program includes stays small: the public headers behind plait/store.h, itself not counted.
most_behind_store=10
store=engine/store/include/plait/store.h
behind=("$store")
for ((at = 0; at < ${#behind[@]}; ++at)); do
  while IFS= read -r name; do
    resolve "${behind[at]}" "$name"
    [[ -z $found_file || " ${behind[*]} " == *" $found_file "* ]] || behind+=("$found_file")
  done < <(sed -nE 's/^#include "(plait\/[^"]*)".*/\1/p' "${behind[at]}")
done
[ $((${#behind[@]} - 1)) -le $most_behind_store ] ||
  fail "$store: expected at most $most_behind_store headers behind it, found $((${#behind[@]} - 1)): ${behind[*]:1}"

# The namespace of the library's files has a version; that of public headers is exported, and that of
# private headers which the program, the measurements or tests of the shared library include.
while IFS=: read -r file line text; do
  case $file:$text in
    engine/base/include/plait/detail/namespace.h:*) ;;
    */include/plait/*:PLAIT_BEGIN_NAMESPACE) ;;
    */include/plait/*) fail "$file:$line: a public header says PLAIT_BEGIN_NAMESPACE, not '$text'" ;;
    *.h:PLAIT_BEGIN_NAMESPACE) ;;
    *:PLAIT_BEGIN_PRIVATE_NAMESPACE) ;;
    *) fail "$file:$line: a private file says PLAIT_BEGIN_PRIVATE_NAMESPACE, not '$text'" ;;
  esac
done < <(grep -rnE '^(namespace plait \{|PLAIT_BEGIN_)' --include='*.h' --include='*.cpp' \
  engine backends kernels scans jobs c)

if [ "$file_count" -eq 0 ]; then
  fail "found no source file"
fi
if [ "$failures" -gt 0 ]; then
  echo "check_layers: $failures of these in $file_count files" >&2
  exit 1
fi
echo "check_layers: $file_count files in order"
