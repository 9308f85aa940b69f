#!/usr/bin/env bash
# What plait part opens for writing, makes, renames and removes, as the kernel sees it: its directory
# part.I-... and the file done.I, and nothing else: of a subdivision, and of a pass, whose parts read the
# store that they change the next version of. Skipped without strace.
#
#   parts_strace_test.sh PLAIT
set -euo pipefail
plait=$1
skip() { echo "parts_strace_test: skipped: $*"; exit 77; }
command -v strace >/dev/null || skip 'no strace'
here=$(realpath "$(mktemp -d)")
logs=$(mktemp -d)
trap 'rm -rf "$here" "$logs"' EXIT
cd "$here"
export ASAN_OPTIONS="${ASAN_OPTIONS:-}:detect_leaks=0"  # the search for leaks does not work under strace
strace -o "$logs/probe" true 2>/dev/null || skip 'strace may not run here'  # a container may forbid it

"$plait" generate torus m.ply --vertices 500 >/dev/null

# changes: the paths that the calls of the trace change, one a line.
changes() {
  awk -v root="$here" '
    function base(text) {  # the directory of a call that names one: AT_FDCWD</a> or 5</a/b>
      match(text, /<[^>]*>/)
      return RLENGTH > 0 ? substr(text, RSTART + 1, RLENGTH - 2) : ""
    }
    function path(directory, name) {
      if (name ~ /^\//) return name
      return (directory == "" ? root : directory) "/" name
    }
    / = -1 / || !/\(/ { next }
    {
      call = $0
      sub(/^[0-9]+ +/, "", call)
      name = call
      sub(/\(.*/, "", name)
      arguments = substr(call, length(name) + 2)
      count = split(arguments, quoted, "\"")
      opens = name ~ /^(open|openat|openat2|creat)$/
      if (opens && arguments !~ /O_WRONLY|O_RDWR|O_CREAT|O_TRUNC|O_APPEND/ && name != "creat") next
      if (opens || name ~ /^(mkdir|mkdirat|unlink|unlinkat|rmdir|truncate|mknodat|chmod|fchmodat|utimensat)$/)
        print path(base(quoted[1]), quoted[2])
      else if (name ~ /^(rename|renameat|renameat2|link|linkat|symlink|symlinkat)$/) {
        print path(base(quoted[1]), quoted[2])
        print path(base(quoted[3]), quoted[4])
      } else if (name ~ /^(write|pwrite64|writev|pwritev|pwritev2|ftruncate|fallocate|fchmod|copy_file_range)$/)
        print base(arguments)
    }' "$logs/trace" | sort -u
}

# check_part PLAN FILE: makes part 1 of PLAN, which has a file of levels whose name begins with FILE.
check_part() {
  local plan=$1 file=$2 before after others
  for part in 0 2; do "$plait" part "$plan" "$part" >/dev/null; done
  before=$(find . -mindepth 1 -not -path "./$plan" -printf '%p %i %T@ %C@\n' | sort)
  # -y writes the path of each descriptor, so that a path relative to a directory is whole.
  strace -f -y -s 4096 -o "$logs/trace" -e trace=%file,%desc "$plait" part "$plan" 1 >/dev/null
  after=$(find . -mindepth 1 -not -path "./$plan" -not -path "./$plan/part.1-*" -not -path "./$plan/done.1" \
    -printf '%p %i %T@ %C@\n' | sort)
  changes >"$logs/changed"
  grep -q "^$here/$plan/part\.1-.*/$file" "$logs/changed" || {
    echo "parts_strace_test: expected files of levels in $plan, found:" >&2
    cat "$logs/changed" >&2
    exit 1
  }
  grep -qx "$here/$plan/done.1" "$logs/changed" || { echo "parts_strace_test: expected done.1" >&2; exit 1; }
  others=$(grep -v -e "^$here/$plan/part\.1-[^/]*\(/[^/]*\)\?$" -e "^$here/$plan/done\.1$" -e '^pipe:' \
    -e '^/dev/null$' -e '^anon_inode:' "$logs/changed" || true)
  [ -z "$others" ] || { printf 'parts_strace_test: part 1 changes what is not its own:\n%s\n' "$others" >&2; exit 1; }
  [ "$before" = "$after" ] || {
    echo 'parts_strace_test: files of others have changed:' >&2
    diff <(echo "$before") <(echo "$after") >&2
    exit 1
  }
}

"$plait" plan m.ply p --levels 4 --normals --parts 3 >/dev/null
check_part p attribute0.levels.
"$plait" join p s.plait >/dev/null
"$plait" plan --pass smooth s.plait q >/dev/null
check_part q attribute2.levels.
