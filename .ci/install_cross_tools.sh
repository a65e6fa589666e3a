#!/bin/sh
# Install what tests/integration/test_firmware_compiles.py can use beyond the host's gcc:
# a Cortex-M4 compiler with its C library, the emulator that runs the result, a second compiler.
# The tests skip, and say so, where these are absent. Debian and Ubuntu; needs root or sudo.
set -eu

if ! command -v apt-get >/dev/null 2>&1; then
    echo "install_cross_tools.sh: apt-get not found. Install gcc-arm-none-eabi, newlib for it," >&2
    echo "qemu-system-arm and clang with this system's package manager." >&2
    exit 1
fi

as_root=""
if [ "$(id -u)" -ne 0 ]; then
    as_root="sudo"
fi

export DEBIAN_FRONTEND=noninteractive
# The lock is waited for: another package manager may be running.
$as_root apt-get -o DPkg::Lock::Timeout=300 update
$as_root apt-get -o DPkg::Lock::Timeout=300 install -y --no-install-recommends \
    gcc libc6-dev \
    gcc-arm-none-eabi libnewlib-arm-none-eabi \
    qemu-system-arm \
    clang
