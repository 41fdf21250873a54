#!/usr/bin/env bash
# Builds the library and the controller around it, and runs that. The linker is the check that no panic can be reached: panics call a function that is
# defined nowhere.
set -euo pipefail
cd "$(dirname "$0")"
cargo build --release
library=${CARGO_TARGET_DIR:-target}/release/libcontroller.a
cc -O2 -Wall -Wextra -o "${library%/*}/controller" main.c "$library" -Wl,--gc-sections -lm
"${library%/*}/controller"
