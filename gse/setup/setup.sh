#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Install what a target needs: `setup.sh LEVEL`. Each level contains the levels on which it builds. If everything is installed, the
# script ends at once. It installs as root or through `sudo -n`; otherwise it prints the exact command and stops. It never asks for input.
#
#   build   the programs              run     a flight: Python packages    unit    C tests
#   clang   data races, fuzz targets  s390x   big-endian programs          pytest  tests in Python
#   docs    the documentation         test    tests of whole programs      hil     the micro-VM
#   check   analysers                 station packages of the web page     proofs  the model checker CBMC
#   rtos    programs on FreeRTOS      mcdc    condition coverage           full    all of them, and Yamcs
set -eu

level=${1:?usage: setup.sh build|run|unit|clang|pytest|s390x|rtos|docs|station|test|hil|proofs|mcdc|check|full}
here=gse/setup
case $level in
build) levels='build' ;;
run | unit | clang) levels="build $level" ;;
docs) levels='build run docs' ;;
station) levels='build run station' ;;
s390x) levels='build unit s390x' ;;
rtos) levels='build unit rtos' ;;
pytest) levels='build run unit pytest' ;;
test) levels='build run unit clang pytest docs station test' ;;
hil) levels='build run unit clang pytest docs station test hil' ;;
proofs) levels='build proofs' ;;
mcdc) levels='build unit mcdc' ;;
check) levels='build run unit clang pytest proofs mcdc check' ;;
full) levels='build run unit clang s390x rtos pytest docs station test hil proofs mcdc check full' ;;
*) echo "setup: level '$level': expected one of build run unit clang docs station s390x rtos pytest test hil proofs mcdc check full" >&2 && exit 2 ;;
esac

has() { case " $levels " in *" $1 "*) ;; *) return 1 ;; esac; }

# Debian packages of these levels that are not installed, each with its pinned version. An installed package with another version than
# the pinned one is left as it is, and printed.
missing_packages() {
    for wanted in $levels; do
        awk -v level="$wanted" '$1 !~ /^#/ && $2 == level { print $1 }' "$here/packages.txt"
    done | while read -r wanted; do
        name=${wanted%%=*}
        pinned=${wanted#"$name"}
        pinned=${pinned#=}
        status=$(dpkg-query -W -f '${db:Status-Status} ${Version}' "$name" 2>/dev/null || true)
        # npm and cargo may also come from Node.js and Rust themselves; then their Debian packages are not needed.
        case $status in
        installed*) ;;
        *) case $name in npm | cargo-web) command -v "${name%-web}" >/dev/null ;; *) false ;; esac || echo "$wanted" && continue ;;
        esac
        # shellcheck disable=SC2254 # a pattern
        case ${status#installed } in
        ${pinned:-*}) ;;
        *) echo "setup: $name has version ${status#installed }, $pinned is pinned: measured figures may differ" >&2 ;;
        esac
    done
}

install_packages() {
    if ! command -v apt-get >/dev/null; then
        echo "setup: this machine has no apt-get; install the counterparts of the packages in $here/packages.txt," >&2
        echo "setup: then run: touch build/setup/$level" >&2
        return 1
    fi
    missing=$(missing_packages | tr '\n' ' ')
    [ -n "$missing" ] || return 0
    command="sudo apt-get update && sudo apt-get install --no-install-recommends -y $missing"
    as_root=''
    if [ "$(id -u)" -ne 0 ]; then
        if ! sudo -n true 2>/dev/null; then
            echo "setup: these packages are missing and this user may not install them. Run:" >&2
            echo "    $command" >&2
            return 1
        fi
        as_root='sudo -n'
    fi
    echo "setup: installing $missing"
    environment='env DEBIAN_FRONTEND=noninteractive'
    # Continue if a package source cannot be read: the installation below fails if a package is missing.
    $as_root $environment apt-get update -qq || true
    # shellcheck disable=SC2086 # a list of words
    $as_root $environment apt-get -o DPkg::Lock::Timeout=300 install --no-install-recommends -y -qq $missing </dev/null || {
        echo "setup: these packages are missing and cannot be installed now; with a network, run:" >&2
        echo "    $command" >&2
        return 1
    }
}

# Only one setup of this clone runs at a time.
mkdir -p build/setup
exec 9>build/setup/lock
flock 9

# Each part is attempted, so that everything that is missing is reported at once.
failed=''
install_packages || failed=1
if has pytest; then
    sh "$here/python.sh" gse/requirements.txt test/requirements.txt || failed=1
elif has run; then
    sh "$here/python.sh" gse/requirements.txt || failed=1
fi
if has unit; then
    sh "$here/unity.sh" || failed=1
fi
if has station; then
    sh "$here/station.sh" || failed=1
fi
if has s390x; then
    sh "$here/expat_s390x.sh" || failed=1
fi
if has rtos; then
    sh "$here/expat_source.sh" || failed=1
    sh "$here/freertos.sh" || failed=1
    sh "$here/littlefs.sh" || failed=1
fi
if has proofs; then
    sh "$here/cbmc.sh" || failed=1
fi
if has full; then
    sh "$here/yamcs.sh" || failed=1
fi
if [ -n "$failed" ]; then
    echo 'setup: something is missing: see above. With a network, run once for all clones of this user: make setup' >&2
    exit 1
fi
for done_level in $levels; do
    touch "build/setup/$done_level"
done
