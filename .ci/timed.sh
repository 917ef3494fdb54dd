#!/usr/bin/env bash
# Runs a program that cargo has built, $1 with the rest as its arguments. Of a test binary, whose tests are then not printed
# where they pass, it appends a line for each test to the file that CVR_TEST_TIMES names: seconds, binary and test, with
# tabs between. Times of single tests are no stable feature of Rust's test harness: where they cannot be had, the program
# runs as it is.
set -uo pipefail
program=$1
shift
timed=(-Zunstable-options --report-time)
case "$program" in
    */deps/*) RUSTC_BOOTSTRAP=1 "$program" "${timed[@]}" --list >/dev/null 2>&1 || exec "$program" "$@" ;;
    *) exec "$program" "$@" ;; # of the documentation
esac
arguments=()
for argument in "$@"; do
    # A quiet harness prints no times.
    [ "$argument" = --quiet ] || arguments+=("$argument")
done
name=${program##*/}
RUSTC_BOOTSTRAP=1 "$program" "${timed[@]}" ${arguments[@]+"${arguments[@]}"} |
    awk -v binary="${name%-*}" -v times="$CVR_TEST_TIMES" '
        /^test .* \.\.\. .*<[0-9.]+s>$/ {
            seconds = $NF
            gsub(/[<>s]/, "", seconds)
            printf "%s\t%s\t%s\n", seconds, binary, $2 >> times
        }
        !/^test .* \.\.\. (ok|ignored)/ { print; fflush() }
    '
exit "${PIPESTATUS[0]}"
