# Sourced by ./run and ./test: brings a fresh Debian or Ubuntu machine to where cargo can build and, if it may
# install packages, to where a Vulkan adapter exists. Installs nothing that is already there; where it may not
# install, it says so and goes on.

# Mesa's device selection complains where this is unset, as it is for root and in containers.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-/tmp}"

say() { printf '%s\n' "$*" >&2; }

# Installs Debian packages if this machine and user can; returns 1 otherwise.
install_packages() {
    command -v apt-get >/dev/null 2>&1 || return 1
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null || return 1
        as_root=(sudo -n)
    fi
    say "installing: $*"
    local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -y -qq)
    "${apt[@]}" update >/dev/null 2>&1
    "${apt[@]}" install --no-install-recommends "$@" >/dev/null 2>&1 && return 0
    # An installation that was interrupted before stands in the way of every later one until it is repaired.
    "${apt[@]}" -f install >/dev/null 2>&1
    "${apt[@]}" install --no-install-recommends "$@" >/dev/null 2>&1
}

need_rust() {
    [ -f "$HOME/.cargo/env" ] && . "$HOME/.cargo/env"
    if ! command -v cargo >/dev/null 2>&1; then
        say "Rust is missing. Install it from https://rustup.rs and run this again."
        exit 2
    fi
    if ! command -v cc >/dev/null 2>&1; then
        install_packages gcc libc6-dev || {
            say "A C linker (cc) is missing and cannot be installed here: install gcc and libc6-dev."
            exit 2
        }
    fi
}

# Makes sure that a graphics adapter is found, if need be Mesa's software Vulkan. $1 is a built cvr.
need_adapter() {
    [ "${CVR_DEVICE:-auto}" = none ] && return 0
    "$1" devices >/dev/null 2>&1 && return 0
    install_packages mesa-vulkan-drivers libvulkan1 && "$1" devices >/dev/null 2>&1 && return 0
    say "No graphics adapter is found and none can be installed: the CPU mirror draws instead."
    return 0
}
