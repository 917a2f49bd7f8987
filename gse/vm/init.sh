#!/bin/busybox sh
# SPDX-License-Identifier: Apache-2.0
# First process of the micro-VM. Mounts a temporary overlay over the file system of the machine, runs the script of the
# control directory in it, writes its exit code to that directory, and switches the power off. Errors are reported on the console.
export PATH=/bin:/sbin

end() {
    poweroff -f
    sleep 60
}
fail() {
    echo "micro-VM: $*"
    end
}

mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs devtmpfs /dev 2>/dev/null
# shellcheck disable=SC2046 # a list of words
modprobe -a $(cat /modules-at-boot) || fail 'a module cannot be loaded'

plan9='trans=virtio,version=9p2000.L,msize=262144'
mount -t 9p -o "$plan9,cache=none" control /control || fail 'the control directory cannot be mounted (9p)'
# shellcheck disable=SC1091 # written for each start: directory, out, interactive, cans
. /control/parameters

mount -t 9p -o "$plan9,ro,cache=loose" root /host || fail 'the file system of the machine cannot be mounted (9p)'
mount -t tmpfs -o mode=755 tmpfs /over && mkdir /over/upper /over/work
mount -t overlay -o lowerdir=/host,upperdir=/over/upper,workdir=/over/work overlay /guest ||
    fail 'the overlay cannot be mounted'
mount -t proc proc /guest/proc
mount -t sysfs sysfs /guest/sys
mount -t devtmpfs devtmpfs /guest/dev
mkdir -p /guest/dev/pts /guest/dev/shm
ln -s /proc/self/fd /guest/dev/fd
for number in 0:stdin 1:stdout 2:stderr; do
    ln -s "/proc/self/fd/${number%:*}" "/guest/dev/${number#*:}"
done
mount -t devpts -o gid=5,mode=620,ptmxmode=666 devpts /guest/dev/pts
mount -t tmpfs -o mode=1777 tmpfs /guest/dev/shm
mount -t tmpfs -o mode=755 tmpfs /guest/run
mkdir -p /guest/run/lock /guest/run/vm
case $directory/ in
/tmp/*) ;; # The project is in /tmp: keep it visible through the overlay.
*) mount -t tmpfs -o mode=1777 tmpfs /guest/tmp ;;
esac
[ -d /guest/lib/modules ] || mkdir -p /guest/lib/modules
modules=lib/modules/$(uname -r)
mkdir -p "/guest/$modules" && mount --bind "/$modules" "/guest/$modules"
mkdir -p "/guest$out" && mount -t 9p -o "$plan9,cache=none" out "/guest$out" ||
    fail "the output directory $out cannot be mounted (9p)"
mount --bind /control /guest/run/vm

hostname hirosco-vm
ip link set lo up
[ "$cans" -eq 0 ] || modprobe kvaser_pci || fail 'no driver for the CAN controllers (kvaser_pci)'

# Write the exit code atomically, and end.
leave() {
    echo "$1" >/control/code.part && mv /control/code.part /control/code
    end
}

if [ "$interactive" = yes ]; then
    modprobe virtio_console || fail 'no driver for the terminal (virtio_console)'
    tries=0 # The device appears some time after its driver.
    while [ ! -c /dev/hvc0 ]; do
        tries=$((tries + 1))
        [ $tries -lt 300 ] || fail 'the terminal /dev/hvc0 does not appear'
        sleep 0.1
    done
    : >/control/booted
    setsid -c chroot /guest /bin/sh /run/vm/guest.sh <>/dev/hvc0 >&0 2>&1
    leave $?
fi

# The command writes into pipes, so that its programs may open /dev/stdout and /dev/stderr again. Its remaining processes are
# killed, so that the pipes end and all output is in the control directory before the exit code.
mkfifo /stdout /stderr
cat /stdout >/control/stdout &
out_writer=$!
cat /stderr >/control/stderr &
err_writer=$!
exec 3>/stdout 4>/stderr
: >/control/booted
chroot /guest /bin/sh /run/vm/guest.sh </dev/null >&3 2>&4 3>&- 4>&-
code=$?
exec 3>&- 4>&-
for process in /proc/[0-9]*; do
    [ ! "$process/root/" -ef /guest ] || kill -9 "${process#/proc/}" 2>/dev/null
done
wait $out_writer $err_writer
leave $code
