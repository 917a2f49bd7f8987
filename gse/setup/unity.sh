#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the unit test framework Unity into build/third_party/unity/. It is part of Debian's source package `cjson`.
# apt-get fetches that package from the package sources of this machine, with separate package lists, so that those of
# the machine do not change. The archive is pinned by its checksum, and kept in the user's cache for other clones and
# for work without a network (docs/decisions/0044).
set -eu

target=build/third_party/unity
archive_sha256=5308fd4bd90cef7aa060558514de6a1a4a0819974a26e6ed13973c5f624c24b2
cached=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/hirosco/cjson-$archive_sha256.tar.gz
[ -f "$target/src/unity.c" ] && exit 0

is_right() { [ -f "$1" ] && echo "$archive_sha256  $1" | sha256sum --check --status; }

work=$(pwd)/build/setup/cjson

fetch() {
    rm -rf "$work"
    mkdir -p "$work/sources" "$work/lists/partial" "$work/cache/archives/partial"
    for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
        [ ! -f "$list" ] || sed -n 's/^deb /deb-src /p' "$list" >"$work/sources/${list##*/}"
    done
    [ ! -f "$work/sources/sources.list" ] || mv "$work/sources/sources.list" "$work/sources/machine.list"
    for list in /etc/apt/sources.list.d/*.sources; do
        [ ! -f "$list" ] || sed 's/^Types:.*/Types: deb-src/' "$list" >"$work/sources/${list##*/}"
    done
    (
        cd "$work"
        set -- -qq -o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$work/sources" \
            -o Dir::State::Lists="$work/lists" -o Dir::Cache="$work/cache" -o APT::Sandbox::User="$(id -un)"
        apt-get "$@" update
        apt-get "$@" source --download-only cjson
    ) || {
        echo 'setup: the source package cjson, which holds Unity, cannot be fetched; is there a network?' >&2
        exit 1
    }
    set -- "$work"/cjson_*.orig.tar.*
    is_right "$1" || {
        echo "setup: $1 is not the pinned archive (sha256 $archive_sha256)" >&2
        exit 1
    }
    archive=$1
    # If no cache can be created, the archive is used for this clone only.
    mkdir -p "${cached%/*}" 2>/dev/null && cp "$archive" "$cached.$$" 2>/dev/null && mv "$cached.$$" "$cached" || true
}

echo 'setup: Unity out of the source package cjson'
if is_right "$cached"; then
    archive=$cached
else
    fetch
fi
rm -rf "$work/unpacked" "$target.part"
mkdir -p "$work/unpacked" "$target.part/examples" # The sources include their settings from examples/.
tar -xf "$archive" -C "$work/unpacked"
cp -r "$work"/unpacked/cJSON-*/tests/unity/src "$work"/unpacked/cJSON-*/tests/unity/docs/license.txt "$target.part/"
cp "$work"/unpacked/cJSON-*/tests/unity/examples/unity_config.h "$target.part/examples/"
rm -rf "$target" "$work"
mv "$target.part" "$target" # The folder appears only when it is complete.
