# Seconds of CPU time of all that this shell has run so far, into `cpu_seconds`. In a subshell it would count that one's alone,
# so that it is no command to be substituted.
count_cpu() {
    local counted
    counted=$(mktemp)
    times >"$counted"
    cpu_seconds=$(tr 'ms' '  ' <"$counted" | awk 'NR == 2 { printf "%d", 60 * ($1 + $3) + $2 + $4 }')
    rm -f "$counted"
}
