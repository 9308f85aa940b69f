#!/usr/bin/env bash
# Fails if an #include violates the layers, or if a source file is in no build.
#
#   bench -> tools; tools, bench, tests, examples -> c -> kernels, backends -> engine
#   inside engine/:  base <- io, address <- mesh <- layout <- paging <- store <- maintenance, execution
#
# The tables below have the exact rules. A public header of the engine must be in the first table:
# if you add a header, choose its layer there.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

# The layer of each public header in engine/include/plait/.
declare -A layer_of_header=(
  [attribute.h]=base [byte_text.h]=base [error.h]=base [provenance.h]=base [stopwatch.h]=base
  [default_arithmetic.h]=base [number_lattice.h]=base [rounding.h]=base
  [namespace.h]=base [topology.h]=base [vector3.h]=base [regular_normal.h]=base [version.h]=base
  [directory.h]=io [file.h]=io [file_operations.h]=io [machine.h]=io
  [partial_output.h]=io
  [base_relative_level.h]=address [edge_index.h]=address [edge_set.h]=address [face_slots.h]=address
  [level_geometry.h]=address [patch_table.h]=address [slot_shapes.h]=address
  [vertex_numbering.h]=address
  [base_mesh.h]=mesh [mesh_io.h]=mesh
  [layout.h]=layout
  [backend.h]=paging [backend_choice.h]=paging [block_maker.h]=paging [block_table.h]=paging [budget.h]=paging [derivation.h]=paging [level_cursor.h]=paging
  [level_file.h]=paging [level_pipelines.h]=paging [pager.h]=paging [pinned_level.h]=paging [session.h]=paging
  [attribute_levels.h]=store [digest.h]=store [left_overs.h]=store [options.h]=store
  [partial_store.h]=store [store.h]=store [store_directory.h]=store
  [check_store.h]=maintenance [compare_attribute.h]=maintenance [copy_levels.h]=maintenance [recode_attribute.h]=maintenance [repair.h]=maintenance
  [verify.h]=maintenance
  [bounds.h]=execution [fused.h]=execution [in_core_mesh.h]=execution [patch.h]=execution [pin_needs.h]=execution
  [pinned_patch.h]=execution [reader.h]=execution [sweep.h]=execution
)

# The layers that each folder of engine/, and each other folder, may include. Layout and address
# only compute, so they may not include io.
engine_layers='base io address mesh layout paging store maintenance execution'
declare -A may_include=(
  [base]='base'
  [io]='base io'
  [address]='base address'
  [mesh]='base io address mesh'
  [layout]='base address mesh layout'
  [paging]='base io address mesh layout paging'
  [store]='base io address mesh layout paging store'
  [maintenance]='base io address mesh layout paging store maintenance'
  [execution]='base io address mesh layout paging store execution'
  [backends]="$engine_layers backends"
  [kernels]="$engine_layers kernels"
  [c]="$engine_layers backends kernels c"
  [tools]="$engine_layers backends kernels c tools"
  [bench]="$engine_layers backends kernels c tools bench"
  [examples]="$engine_layers backends kernels c examples"
  [tests]="$engine_layers backends kernels c tools tests"
)

# System headers that a layer must not include: the library never prints, and layers that only
# compute do no file operations.
declare -A forbidden_system_header=(
  [base]='iostream|fstream|cstdio|unistd\.h|fcntl\.h|sys/.*|boost/(iostreams|interprocess)/.*'
  [io]='iostream'
  [mesh]='iostream'
  [paging]='iostream'
  [store]='iostream'
  [maintenance]='iostream'
  [execution]='iostream'
  [backends]='iostream'
  [kernels]='iostream'
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
    engine/include/plait/*) found_layer=${layer_of_header[${1#engine/include/plait/}]:-} ;;
    engine/*/*)
      inner=${1#engine/}
      found_layer=${inner%%/*}
      ;;
    *) found_layer=${1%%/*} ;;
  esac
  [ -n "${may_include[${found_layer:-none}]:-}" ] || found_layer=
}

# resolve FROM NAME: sets `found_file` to the file of the project that FROM includes as NAME, or to
# nothing.
resolve() {
  local from=$1 name=$2 component=${1%%/*} folder
  local folders=("${from%/*}" engine/include backends/include kernels/include c/include "$component")
  # Tests and measurements may include private headers.
  [ "$component" != tests ] || folders+=(engine backends kernels c tools)
  [ "$component" != bench ] || folders+=(engine kernels tools)
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
for folder in engine backends kernels c tools bench examples tests; do
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

# The namespace of the library's files has a version; that of public headers is exported.
while IFS=: read -r file line text; do
  case $file:$text in
    engine/include/plait/namespace.h:*) ;;
    */include/plait/*:PLAIT_BEGIN_NAMESPACE) ;;
    */include/plait/*) fail "$file:$line: a public header says PLAIT_BEGIN_NAMESPACE, not '$text'" ;;
    *:PLAIT_BEGIN_PRIVATE_NAMESPACE) ;;
    *) fail "$file:$line: a private file says PLAIT_BEGIN_PRIVATE_NAMESPACE, not '$text'" ;;
  esac
done < <(grep -rnE '^(namespace plait \{|PLAIT_BEGIN_)' --include='*.h' --include='*.cpp' \
  engine backends kernels c)

if [ "$file_count" -eq 0 ]; then
  fail "found no source file"
fi
if [ "$failures" -gt 0 ]; then
  echo "check_layers: $failures of these in $file_count files" >&2
  exit 1
fi
echo "check_layers: $file_count files in order"
