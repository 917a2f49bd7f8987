#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Install the peers with which `make bench` compares this project, as far as this machine permits. A peer that cannot be
# installed is reported here and skipped by `make bench`. `peers.sh spacepackets` builds only that peer, from the Rust registry; the
# conformance tests need it, too. The script never asks for input and never fails.
set -u

# The versions are exact; the lock files stay in build/.
build_from_registry() {
    peer=$1
    mkdir -p build/peers build/setup
    rm -rf "build/peers/$peer/src"
    cp -R "test/bench/peers/$peer" build/peers/
    if command -v cargo >/dev/null; then
        echo "setup: building the peer $peer (once, up to some minutes)"
        cargo build --release --quiet --manifest-path "build/peers/$peer/Cargo.toml" ||
            echo "setup: $peer cannot be built; everything that needs it is skipped"
    else
        echo "setup: there is no cargo; $peer is skipped"
    fi
    touch "build/setup/peer-$peer"
}

if [ $# -gt 0 ]; then
    build_from_registry "$1"
    exit 0
fi

list=gse/setup/peers.txt
missing=$(awk '$1 !~ /^#/ && NF { print $1 }' "$list" | while read -r name; do
    status=$(dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null || true)
    [ "$status" = installed ] || printf '%s ' "$name"
done)
if [ -n "$missing" ]; then
    as_root=''
    [ "$(id -u)" -eq 0 ] || as_root='sudo -n'
    echo "setup: installing for comparison $missing"
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get update -qq || true
    for name in $missing; do
        $as_root env DEBIAN_FRONTEND=noninteractive apt-get install --no-install-recommends -y -qq "$name" \
            </dev/null >/dev/null || echo "setup: $name cannot be installed; everything that needs it is skipped"
    done
fi

for peer in iceoryx2 spacepackets; do
    build_from_registry "$peer"
done
touch build/setup/peers
