#!/usr/bin/env bash
# Builds the fuzz targets with libFuzzer and the address and undefined behaviour sanitizers, and
# runs each target for some time on a copy of its corpus.
#
#   tests/fuzz/run.sh [--seconds N] [TARGET...]      default: 60 seconds for each of all targets
#   tests/fuzz/run.sh --runs N [TARGET...]           this number of inputs instead
#
# A target may be TARGET=CHOICE: then all inputs go to one filter or preset, such as presets=small or
# context_filters=hierarchy:step=2e-6 (PLAIT_FUZZ_ONLY; a wrong choice lists the right ones).
#
# Ends with a nonzero status if a target finds something. Then the output names the input, which
# stays in build/fuzz/findings. New inputs go to build/fuzz/grown, and later runs use them again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

usage() {
  sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' tests/fuzz/run.sh
}

seconds=60 runs=''
targets=()
while [ $# -gt 0 ]; do
  case $1 in
    -h | --help)
      usage
      exit 0
      ;;
    --seconds)
      if ! [[ ${2:-} =~ ^[1-9][0-9]*$ ]]; then
        echo "tests/fuzz/run.sh: --seconds needs a number" >&2
        exit 2
      fi
      seconds=$2
      shift 2
      ;;
    --runs)
      if ! [[ ${2:-} =~ ^[1-9][0-9]*$ ]]; then
        echo "tests/fuzz/run.sh: --runs needs a number" >&2
        exit 2
      fi
      runs=$2
      shift 2
      ;;
    -*)
      echo "tests/fuzz/run.sh: unknown option $1" >&2
      exit 2
      ;;
    *)
      targets+=("$1")
      shift
      ;;
  esac
done
known=$(sed -n 's/^plait_add_fuzz_target(\([a-z_]*\) .*/\1/p' tests/fuzz/CMakeLists.txt | sort | xargs)
if [ ${#targets[@]} -eq 0 ]; then
  read -ra targets <<<"$known"
fi
for target in "${targets[@]}"; do
  if [[ " $known " != *" ${target%%=*} "* ]]; then
    echo "tests/fuzz/run.sh: unknown target '${target%%=*}'; there are $known" >&2
    exit 2
  fi
done

tools/dev/install_packages.sh build tests fuzz
cmake --preset fuzz --log-level=WARNING
programs=("${targets[@]%%=*}")
cmake --build --preset fuzz --parallel "$(nproc)" --target "${programs[@]/#/fuzz_}"

export UBSAN_OPTIONS=print_stacktrace=1 PLAIT_FUZZ_TIMES=1
findings=build/fuzz/findings
mkdir -p "$findings"
failed=()
for chosen in "${targets[@]}"; do
  target=${chosen%%=*}
  name=${chosen//[^A-Za-z0-9_.-]/_}
  corpus=build/fuzz/grown/$target
  mkdir -p "$corpus"
  # libFuzzer writes new inputs to the first directory, and only reads those in the others.
  inputs=("$corpus" "build/fuzz/tests/fuzz/corpora/$target")
  [ ! -d "tests/fuzz/corpora/$target" ] || inputs+=("tests/fuzz/corpora/$target")
  options=(-print_final_stats=1 -artifact_prefix="$findings/$name-")
  if [ -n "$runs" ]; then options+=(-runs="$runs"); else options+=(-max_total_time="$seconds"); fi
  # An input has at most a few KiB. The largest legitimate allocation is the window of a zstd frame.
  options+=(-max_len=8192 -timeout=20 -rss_limit_mb=1024 -malloc_limit_mb=256)
  [ ! -f "tests/fuzz/$target.dict" ] || options+=(-dict="tests/fuzz/$target.dict")
  log=$findings/$name.log
  printf '==== %s for %s\n' "$chosen" "$([ -n "$runs" ] && echo "$runs inputs" || echo "$seconds s")"
  environment=()
  [ "$chosen" = "$target" ] || environment=("PLAIT_FUZZ_ONLY=${chosen#*=}")
  if env "${environment[@]}" \
    "build/fuzz/tests/fuzz/fuzz_$target" "${options[@]}" "${inputs[@]}" \
    >"$log" 2>&1; then
    grep -E 'Done [0-9]+ runs' "$log"
  else
    tail -n 60 "$log"
    failed+=("$chosen: $(grep -oE "$findings/[^ ]+" "$log" | tail -n 1) (log: $log)")
  fi
done

if [ ${#failed[@]} -gt 0 ]; then
  printf 'fuzz: FOUND %s\n' "${failed[@]}" >&2
  exit 1
fi
echo "fuzz: ${#targets[@]} targets found nothing"
