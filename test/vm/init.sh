#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The first program of a virtual machine of vmrun.sh: the shared root, read-only, with a file system in memory above it.
box=/bin/busybox
fail() { echo "vmrun: $1"; $box poweroff -f; }
for module in /modules/*; do $box insmod "$module" || echo "vmrun: $module cannot be loaded"; done
share=trans=virtio,version=9p2000.L,msize=262144
$box mount -t 9p -o ro,$share,cache=loose root /lower || fail "the root is not shared"
$box mount -t tmpfs -o size=50% tmpfs /upper && $box mkdir -p /upper/files /upper/work
$box mount -t overlay -o lowerdir=/lower,upperdir=/upper/files,workdir=/upper/work overlay /new || fail "no overlay of the root"
for folder in proc sys dev run tmp out; do $box mkdir -p /new/$folder; done
$box mount -t proc proc /new/proc
$box mount -t sysfs sys /new/sys
$box mount -t devtmpfs dev /new/dev
$box mkdir -p /new/dev/pts /new/dev/shm
$box mount -t devpts devpts /new/dev/pts
$box mount -t tmpfs -o mode=755 tmpfs /new/run
for folder in tmp dev/shm; do $box mount -t tmpfs tmpfs /new/$folder; done
$box mount -t 9p -o rw,$share,cache=none out /new/out || fail "there is no /out"
$box mount -t cgroup2 none /new/sys/fs/cgroup 2>/dev/null
$box ip link set lo up
modules=/new/lib/modules/$($box uname -r)
$box mkdir -p "$modules"
$box mount -t 9p -o ro,$share,cache=loose modules "$modules"
if [ -e /new/out/.vmrun.service ]; then
  units=/new/run/systemd/system
  $box mkdir -p $units/multi-user.target.wants
  $box cp /new/out/.vmrun.service $units/vmrun.service
  $box ln -s ../vmrun.service $units/multi-user.target.wants/
  exec $box switch_root /new /lib/systemd/systemd
fi
exec $box switch_root /new /bin/bash /out/.vmrun
