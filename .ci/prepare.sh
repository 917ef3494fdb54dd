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

# Ends with a sentence where CVR_DEVICE is no word that ./run and ./test know. Comes before anything is built.
check_device_switch() {
    case "${CVR_DEVICE:-auto}" in
        required | vulkan | gl | auto | none) ;;
        *)
            say "CVR_DEVICE=$CVR_DEVICE: it must be required, vulkan, gl, auto or none."
            exit 2
            ;;
    esac
}

# Sets what `$1 devices` finds: `vulkan`, `native` (Vulkan, Metal or DX12), `gl`, and `hardware_gl` (one that is not in
# software), each the name of an adapter, or empty. $1 is a built cvr.
look_for_adapters() {
    vulkan='' native='' gl='' hardware_gl=''
    local backend kind name
    while IFS=$'\t' read -r _ backend kind name _; do
        case "$backend" in
            vulkan) vulkan=$name native=$name ;;
            metal | dx12) native=$name ;;
            gl)
                gl=$name
                [ "$kind" = cpu ] || hardware_gl=$name
                ;;
        esac
    done < <("$1" devices --tsv 2>/dev/null)
}

# Makes sure that there is the graphics adapter that CVR_DEVICE wants, and sets what look_for_adapters does. Mesa's software
# Vulkan is installed where there is nothing, or GL in software, which has gaps; GL on hardware is left as it is.
need_adapter() {
    local switch="${CVR_DEVICE:-auto}"
    vulkan='' native='' gl='' hardware_gl=''
    [ "$switch" = none ] && return 0
    look_for_adapters "$1"
    case "$switch" in
        gl) [ -n "$gl" ] || ! install_packages libegl1 libgl1-mesa-dri || look_for_adapters "$1" ;;
        vulkan) [ -n "$vulkan" ] || ! install_packages mesa-vulkan-drivers libvulkan1 || look_for_adapters "$1" ;;
        *)
            [ -n "$native$hardware_gl" ] || ! install_packages mesa-vulkan-drivers libvulkan1 ||
                look_for_adapters "$1"
            ;;
    esac
    case "$switch" in
        gl | vulkan)
            [ -n "${!switch}" ] && return 0
            say "CVR_DEVICE=$switch: no such adapter is found, and none can be installed."
            exit 2
            ;;
    esac
    if [ -z "$native$hardware_gl" ] && [ -n "$gl" ]; then
        say "Only GL in software is found, and Vulkan cannot be installed: $gl draws through GL."
    elif [ -z "$native$gl" ] && [ "$switch" = required ]; then
        say "CVR_DEVICE=required: no graphics adapter is found, and none can be installed."
        exit 2
    elif [ -z "$native$gl" ]; then
        say "No graphics adapter is found, and none can be installed: the CPU mirror draws instead."
    fi
}
