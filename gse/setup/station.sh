#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Install the packages of the page of the light station, as locked in gse/page/package-lock.json, in build/station. Nothing is fetched if
# they are installed already; npm keeps what it has fetched for the other clones of this user.
set -eu

from=gse/page
to=build/station
mkdir -p "$to"
if cmp -s "$from/package-lock.json" "$to/package-lock.json" && [ -f "$to/node_modules/.package-lock.json" ]; then
    exit 0
fi
echo "setup: packages of the page in $from/package-lock.json"
rm -f "$to/package-lock.json"
cp "$from/package.json" "$to/package.json"
cp "$from/package-lock.json" "$to/package-lock.json.part"
mv "$to/package-lock.json.part" "$to/package-lock.json"
if ! (cd "$to" && npm ci --ignore-scripts --prefer-offline --no-audit --no-fund --loglevel=error >npm.said 2>&1); then
    sed 's/^/setup: /' "$to/npm.said" >&2
    rm -f "$to/package-lock.json"
    echo "setup: the packages of the page cannot be fetched; is there a network? With one, run: make setup" >&2
    exit 1
fi
