#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the source of the XML parser expat into build/third_party/expat/, for processors that Debian has no library for:
# programs on a real-time operating system compile it. It is Debian's source package `expat`.
set -eu

target=build/third_party/expat
archive_sha256=ab00ee05c7067fd10a35c5d2a4922ebba746ddd50ff83b79c828da17bbdf1757
[ -f "$target/lib/xmlparse.c" ] && exit 0

# shellcheck source=gse/setup/debian_source.sh
. "${0%/*}/debian_source.sh"

echo 'setup: the source package expat'
fetch_debian_source expat "$archive_sha256" "$(pwd)/build/setup/expat" expat
rm -rf "$work/unpacked" "$target.part"
mkdir -p "$work/unpacked" "$target.part"
tar -xf "$archive" -C "$work/unpacked"
cp -r "$work"/unpacked/libexpat-*/expat/lib "$work"/unpacked/libexpat-*/expat/COPYING "$target.part/"
# Its configuration for a little-endian processor without an operating system. Without good random numbers (XML_POOR_ENTROPY)
# hostile input could slow the parser down; here it reads only the descriptors of the project.
printf '#define %s\n' 'BYTEORDER 1234' 'HAVE_MEMMOVE 1' 'XML_CONTEXT_BYTES 1024' 'XML_DTD 1' 'XML_NS 1' 'XML_POOR_ENTROPY 1' \
    >"$target.part/lib/expat_config.h"
rm -rf "$target" "$work"
mv "$target.part" "$target" # The directory appears only when it is complete.
