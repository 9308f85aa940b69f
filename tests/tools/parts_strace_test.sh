#!/usr/bin/env bash
# What plait part opens for writing, makes, renames and removes, as the kernel sees it: its directory
# part.I-... and the file done.I, and nothing else. Skipped without strace.
#
#   parts_strace_test.sh PLAIT
set -euo pipefail
plait=$1
skip() { echo "parts_strace_test: skipped: $*"; exit 77; }
command -v strace >/dev/null || skip 'no strace'
here=$(realpath "$(mktemp -d)")
trap 'rm -rf "$here"' EXIT
cd "$here"
export ASAN_OPTIONS="${ASAN_OPTIONS:-}:detect_leaks=0"  # the search for leaks does not work under strace
strace -o probe true 2>/dev/null || skip 'strace may not run here'  # a container may forbid it

"$plait" generate torus m.ply --vertices 500 >/dev/null
"$plait" plan m.ply p --levels 4 --normals --parts 3 >/dev/null
for part in 0 2; do "$plait" part p $part >/dev/null; done
before=$(find p -mindepth 1 -printf '%p %i %T@ %C@\n' | sort)
# -y writes the path of each descriptor, so that a path relative to a directory is whole.
strace -f -y -s 4096 -o trace -e trace=%file,%desc "$plait" part p 1 >/dev/null

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
    }' trace | sort -u
}
changes >changed
grep -q "^$here/p/part\.1-.*/attribute0\.level0" changed || {
  echo "parts_strace_test: expected files of levels, found:" >&2
  cat changed >&2
  exit 1
}
grep -qx "$here/p/done.1" changed || { echo "parts_strace_test: expected done.1" >&2; exit 1; }
others=$(grep -v -e "^$here/p/part\.1-[^/]*\(/[^/]*\)\?$" -e "^$here/p/done\.1$" -e '^pipe:' -e '^/dev/null$' \
  -e '^anon_inode:' changed || true)
[ -z "$others" ] || { printf 'parts_strace_test: part 1 changes what is not its own:\n%s\n' "$others" >&2; exit 1; }
after=$(find p -mindepth 1 -not -path 'p/part.1-*' -not -name done.1 -printf '%p %i %T@ %C@\n' | sort)
[ "$before" = "$after" ] || { echo 'parts_strace_test: files of others have changed' >&2; exit 1; }
