#!/usr/bin/env bash
# Are the rows of the fused executor vector instructions on every instruction set they are compiled
# for, those too that this processor has not? Reads the compiler's output (x86-64, optimised).
#
#   rows_assembly_test.sh libplait_kernels.a
#
# For every row and set: arithmetic of the set's full width; no loop in scalar arithmetic (what
# there is of it belongs to lanes of no comfortable size, one by one); no fused multiply-add, which
# would change bits. Prints the counts.
set -euo pipefail

objdump -dC --no-show-raw-insn "$1" | awk '
  function name_of(line) {
    match(line, /fused_rows::N_[A-Z0-9]+::[a-z_]+_row</)
    return RSTART ? substr(line, RSTART + 12, RLENGTH - 13) : ""
  }
  /^[0-9a-f]+ <.*>:$/ {
    row = name_of($0)
    if (row ~ /N_SCALAR/) row = ""
    if (row == "") next
    kind = ($0 ~ /double>\(/ || $0 ~ /, double>/) ? "double" : "float"
    row = row " " kind
    seen[row] = 1
    next
  }
  row == "" { next }
  $2 ~ /^vfn?m(add|sub)/ { fused[row]++ }
  $2 ~ /^v?(add|sub|mul|div|sqrt|min|max)p[sd]$/ {
    width = /%zmm/ ? "zmm" : /%ymm/ ? "ymm" : "xmm"
    packed[row, width]++
  }
  $2 ~ /^v?(add|sub|mul|div|sqrt|min|max)s[sd]$/ { scalar[row]++ }
  END {
    for (row in seen) {
      full = row ~ /N_AVX3/ ? "zmm" : row ~ /N_AVX2/ ? "ymm" : "xmm"
      vectors = packed[row, full] + 0
      if (row ~ /(even|kept)_row/ && !vectors) continue  # what keeps even vertices only copies
      rows++
      printf "%-32s %3d of %s, %d scalar, %d fused\n", row, vectors, full, scalar[row], fused[row]
      if (vectors < 2 || scalar[row] > vectors || fused[row]) {
        print "  expected: more vector than scalar arithmetic, nothing fused"
        failed = 1
      }
    }
    if (rows < 20) {
      print "found " rows + 0 " rows, expected five on each instruction set: is this an optimised build?"
      failed = 1
    }
    exit failed
  }'
