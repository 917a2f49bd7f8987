#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the XML parser expat, built for the big-endian s390x, into build/third_party/expat-s390x/: what a foreign
# program is linked with. The package client fetches and verifies it from wherever this machine gets its packages, with
# package lists of its own: those of the machine, and what is installed on it, stay as they are.
set -eu

target=build/third_party/expat-s390x
[ -f "$target/lib/libexpat.a" ] && exit 0

work=$(pwd)/build/setup/expat-s390x
rm -rf "$work"
mkdir -p "$work/lists/partial" "$work/cache/archives/partial" "$target/lib" "$target/include"
: >"$work/status"

echo "setup: expat for s390x out of the package libexpat1-dev"
(
    cd "$work"
    set -- -qq -o APT::Architecture=s390x -o APT::Architectures::=s390x -o Dir::State::Lists="$work/lists" \
        -o Dir::State::status="$work/status" -o Dir::Cache="$work/cache" -o APT::Sandbox::User="$(id -un)"
    apt-get "$@" update || true # A source without this architecture is no reason to stop.
    apt-get "$@" download libexpat1-dev
    dpkg-deb -x libexpat1-dev_*_s390x.deb unpacked
)
cp "$work"/unpacked/usr/include/expat.h "$work"/unpacked/usr/include/expat_external.h "$target/include/"
cp "$work"/unpacked/usr/include/s390x-linux-gnu/expat_config.h "$target/include/"
cp "$work"/unpacked/usr/share/doc/libexpat1-dev/copyright "$target/"
cp "$work"/unpacked/usr/lib/s390x-linux-gnu/libexpat.a "$target/lib/"
rm -rf "$work"
