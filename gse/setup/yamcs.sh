#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fetch the packages of gse/yamcs/pom.xml (Yamcs) from Maven Central into build/yamcs/lib. Ends at once if they are installed.
set -eu

pom=gse/yamcs/pom.xml
place=build/yamcs
if cmp -s "$pom" "$place/pom.xml"; then
    exit 0
fi
echo 'setup: Yamcs from Maven Central'
mkdir -p "$place"
rm -rf "$place/lib.part"
mvn -q -B -f "$pom" dependency:copy-dependencies -DincludeScope=runtime -DoutputDirectory="$(pwd)/$place/lib.part" || {
    echo 'setup: Yamcs cannot be fetched from Maven Central; is there a network? With one, run: make setup' >&2
    exit 1
}
rm -rf "$place/lib"
mv "$place/lib.part" "$place/lib"
cp "$pom" "$place/pom.xml"
