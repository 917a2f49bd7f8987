#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Install the Python packages of lists in the environment build/venv: `python.sh LIST...`. Wheels are installed from the cache of this
# user. If one is missing there, all are fetched from the package index into the cache, so that other clones need no network.
set -eu

venv=build/venv
cache=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/hirosco/wheels
mkdir -p "$cache" 2>/dev/null && [ -w "$cache" ] || cache=build/setup/wheels
part=$cache/part.$$
lists=$*
options=''
for list; do options="$options -r $list"; done

# Print the packages of the lists that are in none of these directories.
lacking() {
    # shellcheck disable=SC2086 # lists of words
    grep -hv '^#' $lists | while read -r wanted; do
        file=$(echo "${wanted%%==*}" | tr 'A-Z.-' 'a-z__')-${wanted#*==}
        [ -n "$(find "$@" \( -iname "$file.dist-info" -o -iname "$file-*.whl" \))" ] || echo "    $wanted"
    done
}

# shellcheck disable=SC2086
fetch() {
    "$venv/bin/python" -m pip -qq --disable-pip-version-check --no-input --retries 2 wheel --use-pep517 \
        --wheel-dir "$part" $options 2>>"$part/said" && mv "$part"/*.whl "$cache/"
}

# shellcheck disable=SC2086
install() {
    "$venv/bin/python" -m pip -qq --disable-pip-version-check install --no-index --find-links "$cache" $options 2>>"$part/said"
}

echo "setup: Python packages of $lists"
[ -x "$venv/bin/python" ] || /usr/bin/python3 -m venv "$venv"
mkdir -p "$part"
trap 'rm -rf "$part"' EXIT
is_fetched=''
if [ -n "$(lacking "$cache")" ]; then
    fetch || true
    is_fetched=1
fi
# A cached wheel may be damaged, or a dependency that no list names may be missing.
if ! install && { [ -n "$is_fetched" ] || ! fetch || ! install; }; then
    {
        sed -n 's/^ERROR: /setup: /p' "$part/said"
        echo "setup: Python packages cannot be fetched from the package index; is there a network? Neither installed nor in"
        echo "setup: $cache are:"
        lacking "$venv/lib" "$cache"
    } >&2
    exit 1
fi
# The command `gse` and `import hirosco_gse` use this working tree.
site=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
printf '%s\n' "$(pwd)" "$(pwd)/gse" >"$site/hirosco.pth"
printf '#!/bin/sh\nexec "%s/bin/python" -m hirosco_gse "$@"\n' "$(pwd)/$venv" >"$venv/bin/gse"
chmod +x "$venv/bin/gse"
