#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the unit test framework Unity into build/third_party/unity/. It is part of Debian's source package `cjson`.
set -eu

target=build/third_party/unity
archive_sha256=5308fd4bd90cef7aa060558514de6a1a4a0819974a26e6ed13973c5f624c24b2
[ -f "$target/src/unity.c" ] && exit 0

# shellcheck source=gse/setup/debian_source.sh
. "${0%/*}/debian_source.sh"

echo 'setup: Unity out of the source package cjson'
fetch_debian_source cjson "$archive_sha256" "$(pwd)/build/setup/cjson" Unity
rm -rf "$work/unpacked" "$target.part"
mkdir -p "$work/unpacked" "$target.part/examples" # The sources include their settings from examples/.
tar -xf "$archive" -C "$work/unpacked"
cp -r "$work"/unpacked/cJSON-*/tests/unity/src "$work"/unpacked/cJSON-*/tests/unity/docs/license.txt "$target.part/"
cp "$work"/unpacked/cJSON-*/tests/unity/examples/unity_config.h "$target.part/examples/"
rm -rf "$target" "$work"
mv "$target.part" "$target" # The directory appears only when it is complete.
