#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the kernel FreeRTOS V11.2.0 into build/third_party/freertos/. It is part of the crate `freertos-next`.
set -eu

target=build/third_party/freertos
crate_sha256=b7824fb42660c16e1b3b573eef99c2fe5c5cba6294a631c309084635f6bfcbb0
[ -f "$target/tasks.c" ] && exit 0

# shellcheck source=gse/setup/crate_source.sh
. "${0%/*}/crate_source.sh"

echo 'setup: FreeRTOS out of the crate freertos-next'
fetch_crate freertos-next 0.12.0 "$crate_sha256" "$(pwd)/build/setup/freertos" FreeRTOS \
    cortex-m:0.7.10 critical-section:1.2.0 mutex-traits:1.0.1 os-trait:0.11.0
rm -rf "$target.part"
mkdir -p "${target%/*}"
mv "$work/unpacked/freertos-next-0.12.0/FreeRTOS-Kernel" "$target.part"
rm -rf "$target" "$work"
mv "$target.part" "$target" # The directory appears only when it is complete.
