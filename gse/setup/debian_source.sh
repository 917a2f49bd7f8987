# SPDX-License-Identifier: Apache-2.0
# Read by other scripts (`.`): fetch the original archive of a Debian source package. apt-get fetches it from the package
# sources of this machine, with separate package lists, so that those of the machine do not change. The archive is pinned
# by its checksum, and kept in the user's cache for other clones and for work without a network (docs/decisions/0044).

# is_right FILE SHA256
is_right() { [ -f "$1" ] && echo "$2  $1" | sha256sum --check --status; }

# keep_in_cache FILE CACHED. If no cache can be created, the archive is used for this clone only.
keep_in_cache() {
    mkdir -p "${2%/*}" 2>/dev/null && cp "$1" "$2.$$" 2>/dev/null && mv "$2.$$" "$2" || true
}

# fetch_debian_source PACKAGE SHA256 WORK CONTENT: sets `archive`.
fetch_debian_source() {
    work=$3
    cached=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/hirosco/$1-$2.tar.gz
    archive=$cached
    is_right "$cached" "$2" && return 0
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
        package=$1
        cd "$work"
        set -- -qq -o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$work/sources" \
            -o Dir::State::Lists="$work/lists" -o Dir::Cache="$work/cache" -o APT::Sandbox::User="$(id -un)"
        apt-get "$@" update
        apt-get "$@" source --tar-only --download-only "$package"
    ) || {
        echo "setup: the source package $1, which contains $4, cannot be fetched; is there a network?" >&2
        exit 1
    }
    for archive in "$work/$1"_*.orig.tar.*; do
        case $archive in *.asc) continue ;; esac
        break
    done
    is_right "$archive" "$2" || {
        echo "setup: $archive is not the pinned archive, expected sha256 $2: remove it, then run: make setup" >&2
        exit 1
    }
    keep_in_cache "$archive" "$cached"
}
