# SPDX-License-Identifier: Apache-2.0
# Read by other scripts (`.`): fetch a crate that contains sources in C. cargo fetches it; Rust itself is not used. The archive
# is pinned by its checksum, and kept in the user's cache for other clones and for work without a network
# (docs/decisions/0044).

# shellcheck source=gse/setup/debian_source.sh
. "${0%/*}/debian_source.sh"

# write_package CRATE VERSION WORK DEPENDENCY...: a package that depends only on the crate. Empty packages replace the
# dependencies of the crate, NAME:VERSION[:FEATURE], which are not needed.
write_package() {
    crate=$1 version=$2 work=$3
    shift 3
    mkdir -p "$work/src"
    : >"$work/src/lib.rs"
    printf '[package]\nname = "source"\nversion = "0.0.0"\n[dependencies]\n%s = { version = "=%s", default-features = false }\n' \
        "$crate" "$version" >"$work/Cargo.toml"
    echo '[patch.crates-io]' >>"$work/Cargo.toml"
    for other; do
        name=${other%%:*}
        other=${other#*:}
        mkdir -p "$work/empty/$name/src"
        : >"$work/empty/$name/src/lib.rs"
        printf '[package]\nname = "%s"\nversion = "%s"\n' "$name" "${other%:*}" >"$work/empty/$name/Cargo.toml"
        case $other in *:*) printf '[features]\n%s = []\n' "${other#*:}" >>"$work/empty/$name/Cargo.toml" ;; esac
        echo "$name = { path = \"empty/$name\" }" >>"$work/Cargo.toml"
    done
}

# fetch_crate CRATE VERSION SHA256 WORK CONTENT DEPENDENCY...: unpacks the crate into WORK/unpacked/.
fetch_crate() {
    crate=$1 version=$2 sha256=$3 work=$4 content=$5
    shift 5
    cached=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/hirosco/$crate-$sha256.tar.gz
    archive=$cached
    rm -rf "$work"
    if ! is_right "$cached" "$sha256"; then
        write_package "$crate" "$version" "$work" "$@"
        (cd "$work" && cargo fetch --quiet) || {
            echo "setup: the crate $crate, which contains $content, cannot be fetched; is there a network?" >&2
            exit 1
        }
        archive=$(find "${CARGO_HOME:-$HOME/.cargo}/registry/cache" -name "$crate-$version.crate" | head -n 1)
        is_right "$archive" "$sha256" || {
            echo "setup: $archive is not the pinned archive, expected sha256 $sha256: remove it, then run: make setup" >&2
            exit 1
        }
        keep_in_cache "$archive" "$cached"
    fi
    mkdir -p "$work/unpacked"
    tar -xf "$archive" -C "$work/unpacked"
}
