#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the file system littlefs v2.9 into build/third_party/littlefs/. It is part of the crate `littlefs2-sys`.
set -eu

target=build/third_party/littlefs
crate_sha256=999d08bb7fae46d63ecb98d2474d28f7af1a6c928a51b4dfe5f1804abf9afc46
[ -f "$target/lfs.c" ] && exit 0

# shellcheck source=gse/setup/crate_source.sh
. "${0%/*}/crate_source.sh"

echo 'setup: littlefs out of the crate littlefs2-sys'
fetch_crate littlefs2-sys 0.4.0 "$crate_sha256" "$(pwd)/build/setup/littlefs" littlefs \
    bindgen:0.70.1:runtime cc:1.0.0
rm -rf "$target.part"
mkdir -p "$target.part"
for name in lfs.c lfs.h lfs_util.c lfs_util.h LICENSE.md; do
    cp "$work/unpacked/littlefs2-sys-0.4.0/littlefs/$name" "$target.part/"
done
rm -rf "$target" "$work"
mv "$target.part" "$target" # The directory appears only when it is complete.
