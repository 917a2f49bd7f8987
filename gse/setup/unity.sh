#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the unit test framework Unity into build/third_party/unity/. It travels inside Debian's source package
# `cjson`; the package client fetches that from wherever this machine gets its packages, with package lists of its
# own, so that those of the machine stay as they are.
set -eu

target=build/third_party/unity
archive_sha256=5308fd4bd90cef7aa060558514de6a1a4a0819974a26e6ed13973c5f624c24b2
[ -f "$target/src/unity.c" ] && exit 0

work=$(pwd)/build/setup/cjson
rm -rf "$work"
mkdir -p "$work/sources" "$work/lists/partial" "$work/cache/archives/partial"

for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    [ ! -f "$list" ] || sed -n 's/^deb /deb-src /p' "$list" >"$work/sources/${list##*/}"
done
[ ! -f "$work/sources/sources.list" ] || mv "$work/sources/sources.list" "$work/sources/machine.list"
for list in /etc/apt/sources.list.d/*.sources; do
    [ ! -f "$list" ] || sed 's/^Types:.*/Types: deb-src/' "$list" >"$work/sources/${list##*/}"
done

echo "setup: Unity out of the source package cjson"
(
    cd "$work"
    set -- -qq -o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$work/sources" \
        -o Dir::State::Lists="$work/lists" -o Dir::Cache="$work/cache" -o APT::Sandbox::User="$(id -un)"
    apt-get "$@" update
    apt-get "$@" source --download-only cjson
)
set -- "$work"/cjson_*.orig.tar.*
echo "$archive_sha256  $1" | sha256sum --check --quiet
tar -xf "$1" -C "$work"
mkdir -p "$target"
cp -r "$work"/cJSON-*/tests/unity/src "$work"/cJSON-*/tests/unity/docs/license.txt "$target/"
mkdir -p "$target/examples" # The sources include their settings from there.
cp "$work"/cJSON-*/tests/unity/examples/unity_config.h "$target/examples/"
rm -rf "$work"
