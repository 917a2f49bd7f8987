#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Install the Python packages of lists in the environment build/venv: `python.sh LIST...`. Wheels are taken from the cache of this
# user. When one is not there, all are fetched from the package index and cached, so that other clones need no network.
set -eu

venv=build/venv
cache=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/hirosco/wheels
mkdir -p "$cache" 2>/dev/null && [ -w "$cache" ] || cache=build/setup/wheels
part=$cache/part.$$
[ -x "$venv/bin/python" ] || /usr/bin/python3 -m venv "$venv"

options=''
for list; do options="$options -r $list"; done
# shellcheck disable=SC2086 # lists of words
from_cache() { "$venv/bin/python" -m pip --quiet --disable-pip-version-check install --no-index --find-links "$cache" $options; }

fetch() {
    mkdir -p "$part"
    # shellcheck disable=SC2086
    "$venv/bin/python" -m pip -qq --disable-pip-version-check --no-input --retries 2 wheel --use-pep517 \
        --wheel-dir "$part" $options 2>"$part/said" && mv "$part"/*.whl "$cache/"
}

# Packages of the lists that are neither installed nor cached.
missing() {
    grep -hv '^#' "$@" | while read -r wanted; do
        name=$(echo "${wanted%%==*}" | tr 'A-Z.-' 'a-z__')
        found=$(find "$venv/lib" "$cache" \( -iname "$name-${wanted#*==}.dist-info" -o -iname "$name-${wanted#*==}-*.whl" \))
        [ -n "$found" ] || echo "    $wanted"
    done
}

echo "setup: Python packages of $*"
if ! from_cache 2>/dev/null; then
    trap 'rm -rf "$part"' EXIT
    if ! fetch || ! from_cache; then
        {
            sed -n 's/^ERROR: /setup: /p' "$part/said"
            echo "setup: Python packages cannot be fetched from the package index; is there a network? Neither installed nor in"
            echo "setup: $cache are:"
            missing "$@"
        } >&2
        exit 1
    fi
fi
# The command `gse` and `import hirosco_gse` use this working tree.
site=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
printf '%s\n' "$(pwd)" "$(pwd)/gse" >"$site/hirosco.pth"
printf '#!/bin/sh\nexec "%s/bin/python" -m hirosco_gse "$@"\n' "$(pwd)/$venv" >"$venv/bin/gse"
chmod +x "$venv/bin/gse"
