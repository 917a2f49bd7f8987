#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the bounded model checker CBMC into build/third_party/cbmc/. Debian 12 has no such package: apt-get fetches the
# package of Debian 13, in the version below, and the libraries that it needs. Its own loader starts it with these libraries, so
# that the libraries of the machine do not change. apt-get reads the package sources of this machine with the name of that
# release, and separate package lists. The packages are kept in the user's cache for other clones and for work without a
# network.
set -eu

version=6.6.0-4
release=trixie
libraries='libc6 libstdc++6 libgcc-s1 minisat zlib1g'
target=build/third_party/cbmc
[ -f "$target/$version" ] && exit 0

work=$(pwd)/build/setup/cbmc-packages
cached=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/hirosco/cbmc-$version-$(dpkg --print-architecture)
rm -rf "$work"
mkdir -p "$work/sources" "$work/lists/partial" "$work/cache/archives/partial" "$work/packages" "$work/unpacked"

fetch() {
    for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list /etc/apt/sources.list.d/*.sources; do
        grep -q '[[:space:]]bookworm' "$list" 2>/dev/null || continue
        sed "s/\([[:space:]]\)bookworm/\1$release/g" "$list" >"$work/sources/${list##*/}"
    done
    [ ! -f "$work/sources/sources.list" ] || mv "$work/sources/sources.list" "$work/sources/machine.list"
    : >"$work/status"
    cd "$work/packages"
    set -- -qq -o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$work/sources" \
        -o Dir::State::Lists="$work/lists" -o Dir::State::status="$work/status" -o Dir::Cache="$work/cache" \
        -o Acquire::Languages=none -o APT::Sandbox::User="$(id -un)"
    apt-get "$@" update || true # The download below fails if no source has the packages.
    # shellcheck disable=SC2086 # a list of words
    apt-get "$@" download "cbmc=$version" $libraries || {
        echo "setup: the package cbmc $version of Debian 13 cannot be fetched; is there a network? make proofs needs it," >&2
        echo 'setup: and make check runs the quick proofs. With a network, run once for all clones: make build/setup/proofs' >&2
        exit 1
    }
    # If no cache can be created, the packages are used for this clone only.
    rm -rf "$cached.$$"
    { mkdir -p "${cached%/*}" && cp -r "$work/packages" "$cached.$$" && mv "$cached.$$" "$cached"; } 2>/dev/null ||
        rm -rf "$cached.$$"
}

unpack() {
    for package in "$1"/*.deb; do
        dpkg-deb -x "$package" "$work/unpacked" || return 1
    done
}

echo "setup: CBMC $version out of the package cbmc of Debian 13"
if ! { [ -d "$cached" ] && unpack "$cached" 2>/dev/null; }; then
    rm -rf "$work/unpacked" "$cached"
    mkdir "$work/unpacked"
    (fetch)
    unpack "$work/packages"
fi
rm -rf "$target.part" "$target"
mkdir -p "$target.part/lib"
cp "$work/unpacked/usr/bin/cbmc" "$work/unpacked/usr/share/doc/cbmc/copyright" "$target.part/"
for library in libc libm libstdc++ libgcc_s libminisat libz ld-linux; do
    find "$work/unpacked" -name "$library[.-]*so*" -exec cp -L {} "$target.part/lib/" \;
done
mv "$target.part" "$target"
loader=$(find "$target/lib" -name 'ld-linux*')
"$loader" --library-path "$target/lib" "$target/cbmc" --version >"$work/version"
mv "$work/version" "$target/$version" # Only a program that runs is complete.
rm -rf "$work"
