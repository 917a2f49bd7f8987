#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Show which of the packages and files that the project needs are on this machine, and the next step. Changes nothing.
set -eu

row() { printf '  %-22s %-26s %-7s %s\n' "$1" "$2" "$3" "$4"; }

missing_levels=''
packages() {
    row PACKAGE VERSION LEVEL 'NEEDED FOR'
    while read -r wanted level purpose; do
        case $wanted in '#'* | '') continue ;; esac
        name=${wanted%%=*}
        pinned=${wanted#"$name"}
        pinned=${pinned#=}
        version=$(dpkg-query -W -f '${db:Status-Status} ${Version}' "$name" 2>/dev/null || true)
        case $version in
        # shellcheck disable=SC2254 # a pattern
        'installed '${pinned:-*}) row "$name" "${version#installed }" "$level" "$purpose" ;;
        'installed '*) row "$name" "${version#installed }" "$level" "$purpose; $pinned is pinned" ;;
        *) row "$name" MISSING "$level" "$purpose" && missing_levels="$missing_levels $level" ;;
        esac
    done <gse/setup/packages.txt
}

python_packages() {
    row 'PYTHON PACKAGE' VERSION LEVEL 'REQUIRED'
    installed=$(build/venv/bin/python -m pip list --disable-pip-version-check --format=freeze 2>/dev/null || true)
    for level in run pytest; do
        [ "$level" = run ] && list=gse/requirements.txt || list=test/requirements.txt
        for required in $(grep -v '^#' "$list"); do
            name=${required%%==*}
            version=$(echo "$installed" | sed -n "s/^$name==//Ip")
            [ -n "$version" ] || missing_levels="$missing_levels $level"
            row "$name" "${version:-MISSING}" "$level" "${required#*==}"
        done
    done
}

cache=${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/hirosco

# Print the row of a download: it is in build/, in the cache of the user, or not yet fetched.
download() {
    if [ -f "$2" ]; then
        state=present
    elif [ -n "$(find "$cache" -maxdepth 1 -name "$3" 2>/dev/null)" ]; then
        state=cached
    else
        state='fetched by make setup'
    fi
    row "$1" "$state" "$4" "$5"
}

# Print the downloads, and the properties of kernel and account that only some targets need.
machine() {
    row MACHINE STATE LEVEL 'NEEDED FOR'
    download Unity build/third_party/unity/src/unity.c 'cjson-*' unit 'unit tests of the portable core'
    download 'expat, s390x' build/third_party/expat-s390x/lib/libexpat.a 'libexpat1-dev_s390x.deb' s390x 'big-endian programs'
    download 'expat, source' build/third_party/expat/lib/xmlparse.c 'expat-*' rtos 'programs on FreeRTOS'
    download FreeRTOS build/third_party/freertos/tasks.c 'freertos-next-*' rtos 'programs on FreeRTOS'
    download littlefs build/third_party/littlefs/lfs.c 'littlefs2-sys-*' rtos 'programs on FreeRTOS'
    download 'kernel, micro-VM' build/vm/vmlinux 'linux-image-*' hil 'vcan, TIPC where this kernel has none'
    download 'packages of the page' build/station/node_modules/.package-lock.json 'page-*' station 'make gse, film and charts of a report, make check-page'
    row 'Python wheels' "$(ls "$cache/wheels" 2>/dev/null | wc -l) cached" run 'new clones without a network'
    [ "$(id -u)" -eq 0 ] && state=root || { sudo -n true 2>/dev/null && state='sudo' || state=no; }
    row 'may install' "$state" setup 'apt-get without a question'
    limit=$(ulimit -r 2>/dev/null || echo 0)
    [ "$(id -u)" -eq 0 ] && limit=unlimited
    row 'real-time priority' "${limit:-0}" - 'TIME=real with SCHED_FIFO'
    row 'processors' "$(getconf _NPROCESSORS_ONLN)" - '2 are enough'
}

next_step() {
    case $missing_levels in
    *build* | *run*) echo 'Next: make sim-run (installs what is missing, builds, flies the mission)' ;;
    *unit* | *clang* | *s390x* | *docs* | *test* | *hil*) echo 'Next: make test (installs what is missing, builds, runs the tests)' ;;
    *mcdc* | *check* | *full*) echo 'Next: make check (installs what is missing, then checks the house rules)' ;;
    *) [ -d build/bin ] && echo 'Nothing is missing. Next: make sim-run, make test' || echo 'Nothing is missing. Next: make' ;;
    esac
}

packages
echo
python_packages
echo
machine
echo
next_step
