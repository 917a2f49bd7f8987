#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the kernel FreeRTOS V11.2.0 into build/third_party/freertos/. It is part of the crate `freertos-next`, which cargo
# fetches; Rust itself is not used. The archive is pinned by its checksum, and kept in the user's cache for other clones
# and for work without a network (docs/decisions/0044).
set -eu

target=build/third_party/freertos
crate=freertos-next
version=0.12.0
archive_sha256=b7824fb42660c16e1b3b573eef99c2fe5c5cba6294a631c309084635f6bfcbb0
[ -f "$target/tasks.c" ] && exit 0

# shellcheck source=gse/setup/debian_source.sh
. "${0%/*}/debian_source.sh"

work=$(pwd)/build/setup/freertos
cached=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/hirosco/$crate-$archive_sha256.tar.gz

# A package that depends only on the crate. Empty packages replace the dependencies of the crate, which are not needed.
write_package() {
    mkdir -p "$work/src"
    : >"$work/src/lib.rs"
    printf '[package]\nname = "kernel"\nversion = "0.0.0"\n[dependencies]\n%s = { version = "=%s", default-features = false }\n' \
        "$crate" "$version" >"$work/Cargo.toml"
    echo '[patch.crates-io]' >>"$work/Cargo.toml"
    for other in cortex-m:0.7.10 critical-section:1.2.0 mutex-traits:1.0.1 os-trait:0.11.0; do
        name=${other%:*}
        mkdir -p "$work/empty/$name/src"
        : >"$work/empty/$name/src/lib.rs"
        printf '[package]\nname = "%s"\nversion = "%s"\n' "$name" "${other#*:}" >"$work/empty/$name/Cargo.toml"
        echo "$name = { path = \"empty/$name\" }" >>"$work/Cargo.toml"
    done
}

fetch() {
    write_package
    (cd "$work" && cargo fetch --quiet) || {
        echo "setup: the crate $crate, which contains FreeRTOS, cannot be fetched; is there a network?" >&2
        exit 1
    }
    archive=$(find "${CARGO_HOME:-$HOME/.cargo}/registry/cache" -name "$crate-$version.crate" | head -n 1)
    is_right "$archive" "$archive_sha256" || {
        echo "setup: $crate-$version.crate is not the pinned archive (sha256 $archive_sha256)" >&2
        exit 1
    }
    keep_in_cache "$archive" "$cached"
}

echo "setup: FreeRTOS out of the crate $crate"
rm -rf "$work"
archive=$cached
is_right "$cached" "$archive_sha256" || fetch
rm -rf "$target.part"
mkdir -p "$work/unpacked" "${target%/*}"
tar -xf "$archive" -C "$work/unpacked"
mv "$work/unpacked/$crate-$version/FreeRTOS-Kernel" "$target.part"
rm -rf "$target" "$work"
mv "$target.part" "$target" # The folder appears only when it is complete.
