#!/usr/bin/env bash
# Runs clang-tidy (.clang-tidy) on the sources, and on our headers through them. To save time, it
# checks tests only with --tests, and joins up to eight sources that are compiled alike into one, so
# that the headers that they share are read once. If there is something to say of a joined source, or
# if its sources cannot be joined, each of them is checked alone, and only that counts.
#
#   tools/dev/check_tidy.sh [--tests] [--since COMMIT] [--most N] [FILE...]    default: all sources
#
#   --most N         no more than N sources: those that changed last
#   --since COMMIT   only sources that differ from this commit, and one source for each header that
#                    differs; all sources if .clang-tidy differs
#
# PLAIT_CLANG_TIDY in the environment names another program than clang-tidy-14.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
clang_tidy=${PLAIT_CLANG_TIDY:-clang-tidy-14}

folders='engine|backends|kernels|jobs|c|tools|examples|bench'
since=
most=
while [ $# -gt 0 ]; do
  case $1 in
    --tests) folders+='|tests' ;;
    --since)
      since=${2:?--since needs a commit}
      shift
      ;;
    --most)
      most=${2:?--most needs a number}
      shift
      ;;
    *) break ;;
  esac
  shift
done

# This build is configured but not compiled, because clang-tidy cannot read GCC's precompiled
# headers.
build=build/tidy
cmake --preset release -B "$build" -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DCMAKE_UNITY_BUILD=OFF \
  -DPLAIT_TESTS=ON \
  -DPLAIT_TOOLS=ON -DPLAIT_EXAMPLES=ON --log-level=WARNING >/dev/null

# The largest sources come first, so that at the end no processor waits long for the last one.
built_sources() {
  sed -n "s|^ *\"file\": \"$PWD/\(.*\)\",\{0,1\}\$|\1|p" "$build"/compile_commands.json |
    grep -E "^($folders)/" | sort -u | xargs -r ls -S
}

# The sources of the list `all` that must be checked for the changes since a commit.
changed_sources() {
  local changed header includers
  mapfile -t changed < <(git diff --name-only --diff-filter=d "$1" -- '*.cpp' '*.h')
  {
    printf '%s\n' "${changed[@]}" | grep '\.cpp$' || true
    for header in $(printf '%s\n' "${changed[@]}" | grep '\.h$'); do
      includers=$(grep -lE "#include \"([^\"]*/)?${header##*/}\"" "${all[@]}" || true)
      # One source is enough to check a header: the source of the same name, or else the smallest.
      printf '%s\n' "$includers" | grep "/$(basename "$header" .h)\.cpp$" ||
        printf '%s\n' "$includers" | tail -n 1
    done
  } | sort -u | grep -xFf - <(printf '%s\n' "${all[@]}") || true
}

files=("$@")
if [ ${#files[@]} -eq 0 ]; then
  mapfile -t all < <(built_sources)
  if [ ${#all[@]} -eq 0 ]; then
    echo "check_tidy: found no source file" >&2
    exit 1
  fi
  files=("${all[@]}")
  if [ -n "$since" ] && git diff --quiet "$since" -- .clang-tidy; then
    mapfile -t files < <(changed_sources "$since")
    echo "check_tidy: ${#files[@]} of ${#all[@]} files for what changed since $since"
  fi
fi
[ ${#files[@]} -gt 0 ] || exit 0
if [ -n "$most" ] && [ ${#files[@]} -gt "$most" ]; then
  echo "check_tidy: the $most of these ${#files[@]} that changed last"
  mapfile -t files < <(git log --format= --name-only -- '*.cpp' | awk '!seen[$0]++' |
    grep -xFf <(printf '%s\n' "${files[@]}") | sed -n "1,${most}p")
fi

# What has a .clang-tidy of its own or is compiled for several instruction sets stays alone. The list
# saves time only.
alone='^c/|/half_(merge|scatter)\.cpp$|/dispatched_rows\.cpp$|/(byte_planes|slot_predictions)\.cpp$'
joined=$build/joined
rm -rf "$joined"
mkdir "$joined"

# Prints the units to check, the largest first: sources, and joined sources, which it writes with their
# compile commands.
write_units() {
  printf '%s\n' "${files[@]}" |
    awk -v root="$PWD/" -v folder="$PWD/$joined" -v alone="$alone" '
      NR == FNR { wanted[root $0] = $0; next }
      /^ *"directory":/ { directory = $0 }
      /^ *"command":/ { command = $0 }
      /^ *"file":/ {
        split($0, quoted, "\"")
        file = quoted[4]
        if (!(file in wanted) || wanted[file] ~ alone) next
        if (!match(command, / -o [^ ]*\.dir\//)) next
        name = wanted[file]
        delete wanted[file]
        flags = substr(command, 1, RSTART - 1)
        target = flags substr(command, RSTART, RLENGTH)
        if (!(target in last) || size[last[target]] == 8) last[target] = ++units
        unit = last[target]
        size[unit]++
        names[unit] = name
        includes[unit] = includes[unit] "#include \"" file "\"  // NOLINT(bugprone-suspicious-include)\n"
        entry[unit] = directory "\n" flags
      }
      END {
        database = folder "/compile_commands.json"
        printf "[" >database
        for (unit = 1; unit <= units; ++unit) {
          if (size[unit] == 1) {
            print 1, names[unit]
            continue
          }
          source = folder "/joined_" unit ".cpp"
          printf "%s", includes[unit] >source
          printf "%s\n{\n%s -c %s\",\n  \"file\": \"%s\"\n}", comma, entry[unit], source, source >database
          comma = ","
          print size[unit], source
        }
        print "\n]" >database
        for (file in wanted) print 1, wanted[file]
      }' - "$build"/compile_commands.json |
    sort -rn | cut -d ' ' -f 2-
}

# Of a joined source only that counts which is also said of one of its sources alone.
check_unit() {
  local sources
  if [[ $1 != */joined_*.cpp ]]; then
    "$clang_tidy" -p "$build" --quiet "$1"
  elif ! "$clang_tidy" -p "$joined" --quiet "$1" >"$1.log" 2>&1; then
    mapfile -t sources < <(sed -n 's/^#include "\(.*\)".*/\1/p' "$1")
    echo "check_tidy: each alone: ${sources[*]#"$PWD"/}"
    "$clang_tidy" -p "$build" --quiet "${sources[@]}"
  fi
}
export -f check_unit
export clang_tidy build joined

# Removes clang's count of suppressed warnings in system headers.
write_units | xargs -d '\n' --max-procs="$(nproc)" --max-args=1 bash -c 'check_unit "$1"' check_unit 2>&1 |
  { grep -avE '^([0-9]+ warnings?( and [0-9]+ errors?)? generated\.|\[[0-9]+/[0-9]+\] Processing.*)$' || true; }
echo "check_tidy: ${#files[@]} files in order"
