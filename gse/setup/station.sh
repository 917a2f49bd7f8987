#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Install the packages of the page of the light station, as locked in gse/page/package-lock.json, in build/station. npm fetches them and
# verifies their checksums; they are then kept as one archive in the cache of this user, so that other clones need no network
# (docs/decisions/0044). Each fetch is tried once: without a network the setup ends at once.
set -eu

from=gse/page
to=build/station
if cmp -s "$from/package-lock.json" "$to/package-lock.json" && [ -f "$to/node_modules/.package-lock.json" ]; then
    exit 0
fi
version=$(sha256sum <"$from/package-lock.json" | cut -c 1-16)
cached=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/hirosco/page-$version-$(uname -m).tar.gz

# Print the packages of the lock that belong on this machine, by its operating system and processor.
wanted() {
    node -e '
        for (const [path, part] of Object.entries(require(process.argv[1]).packages)) {
            const other = (list, own) => list && !list.includes(own);
            if (path === "" || other(part.os, process.platform) || other(part.cpu, process.arch)) continue;
            console.log(`    ${path.replace(/.*node_modules\//, "")}==${part.version}`);
        }' "$(pwd)/$from/package-lock.json"
}

fetch() {
    (cd "$to" && npm ci --ignore-scripts --prefer-offline --fetch-retries=0 --fetch-timeout=30000 --no-audit --no-fund --loglevel=error \
        >npm.said 2>&1) || return 1
    # If no cache can be created, the packages are installed in this clone only.
    mkdir -p "${cached%/*}" 2>/dev/null && tar -C "$to" -czf "$cached.$$" node_modules 2>/dev/null && mv "$cached.$$" "$cached" || true
}

echo "setup: packages of the page in $from/package-lock.json"
rm -rf "$to/package-lock.json" "$to/node_modules"
mkdir -p "$to"
cp "$from/package.json" "$to/package.json"
cp "$from/package-lock.json" "$to/package-lock.json.part"
mv "$to/package-lock.json.part" "$to/package-lock.json"
# A damaged archive is replaced.
if { [ ! -f "$cached" ] || ! tar -C "$to" -xzf "$cached" 2>/dev/null; } && ! fetch; then
    rm -f "$to/package-lock.json"
    {
        grep -v 'npm error  \|npm error A complete log' "$to/npm.said" | sed 's/^/setup: /'
        echo "setup: the packages of the page cannot be fetched; is there a network? With one, run: make setup"
        echo "setup: $cached does not exist. Missing are:"
        wanted
    } >&2
    exit 1
fi
