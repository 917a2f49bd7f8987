#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the XML parser expat, built for the big-endian s390x, into build/third_party/expat-s390x/. Programs for that
# processor are linked with it. apt-get fetches and verifies it from the package sources of this machine, with separate
# package lists: the lists and the installed packages of the machine do not change. The package is kept in the user's cache
# for other clones and for work without a network.
set -eu

target=build/third_party/expat-s390x
[ -f "$target/lib/libexpat.a" ] && exit 0

work=$(pwd)/build/setup/expat-s390x
cached=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/hirosco/libexpat1-dev_s390x.deb
rm -rf "$work"

fetch() {
    mkdir -p "$work/lists/partial" "$work/cache/archives/partial"
    : >"$work/status"
    cd "$work"
    set -- -qq -o APT::Architecture=s390x -o APT::Architectures::=s390x -o Dir::State::Lists="$work/lists" \
        -o Dir::State::status="$work/status" -o Dir::Cache="$work/cache" -o APT::Sandbox::User="$(id -un)"
    apt-get "$@" update || true # A package source may not have this architecture.
    apt-get "$@" download libexpat1-dev &&
        dpkg-deb -x libexpat1-dev_*_s390x.deb unpacked || {
        echo 'setup: the package libexpat1-dev of s390x cannot be fetched; is there a network?' >&2
        exit 1
    }
    # If no cache can be created, the package is used for this clone only.
    mkdir -p "${cached%/*}" 2>/dev/null && cp libexpat1-dev_*_s390x.deb "$cached.$$" 2>/dev/null &&
        mv "$cached.$$" "$cached" || true
}

echo "setup: expat for s390x from the package libexpat1-dev"
mkdir -p "$work"
# `fetch` changes the directory, so it runs in a subshell.
[ -f "$cached" ] && dpkg-deb -x "$cached" "$work/unpacked" 2>/dev/null || (fetch)
mkdir -p "$target/lib" "$target/include"
cp "$work"/unpacked/usr/include/expat.h "$work"/unpacked/usr/include/expat_external.h "$target/include/"
cp "$work"/unpacked/usr/include/s390x-linux-gnu/expat_config.h "$target/include/"
cp "$work"/unpacked/usr/share/doc/libexpat1-dev/copyright "$target/"
cp "$work"/unpacked/usr/lib/s390x-linux-gnu/libexpat.a "$target/lib/"
rm -rf "$work"
