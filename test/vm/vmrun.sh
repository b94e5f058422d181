#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs one command in a throw-away virtual machine, amd64 or arm64 (QEMU's q35 or virt, emulated: never KVM, which is there and stands
# still on machines that are virtual themselves). The machine's root is a folder of this one, or all of it, read-only below a file system
# in memory, so that programs run where they were built.
#
# usage: vmrun.sh -k KERNEL [-r ROOT] [-s FOLDER]... [-m "MODULE[:OPTION=VALUE]... ..."] [-p CPU] [-c CPUS] [-M MB] [-t SECONDS]
#                 [-o FOLDER] [-d IMAGE] [-i] [-v] -- COMMAND [ARGS]
#   -k  what .ci/kernel printed              -r  the root: what .ci/sysroot printed, or / (default)
#   -s  a folder that has the same path in the machine; what is written there is lost
#   -m  modules to load first                -o  a folder that is /out in the machine, and is written to
#   -p  QEMU's name of the processor: max (amd64's default), cortex-a72 (a Pi 4, arm64's default), cortex-a76 (a Pi 5, pages of 16 KiB)
#   -d  a disk: the machine's /dev/vda, if virtio_blk is among the modules
#   -i  starts the root's systemd first, and the command as a service of it
#   -v  shows the kernel's messages
# With -o, FOLDER/.pid holds the number of QEMU's process while it runs.
# Exit code: the command's; 124: not ready within SECONDS (default 300); 125: the machine ended before the command.
set -euo pipefail
die() { printf '%s\n' "vmrun.sh: $1" >&2; exit 2; }
kernel="" root=/ modules="" cpu="" cpus=2 memory=2048 limit=300 out="" disk="" init=false shares=() quiet="quiet loglevel=3"
while getopts k:r:s:m:p:c:M:t:o:d:iv option; do
  case $option in
    k) kernel=$OPTARG ;; r) root=$OPTARG ;; s) shares+=("$(realpath "$OPTARG")") ;; m) modules=$OPTARG ;; p) cpu=$OPTARG ;;
    c) cpus=$OPTARG ;; M) memory=$OPTARG ;; t) limit=$OPTARG ;; o) out=$OPTARG ;; d) disk=$OPTARG ;; i) init=true ;; v) quiet="loglevel=7" ;;
    *) exit 2 ;;
  esac
done
shift $((OPTIND - 1))
if [[ -e $kernel/Image ]]; then
  machine=(qemu-system-aarch64 -M virt -cpu "${cpu:-cortex-a72}" -kernel "$kernel/Image") console=ttyAMA0
elif [[ -e $kernel/vmlinux ]]; then
  machine=(qemu-system-x86_64 -M q35 -cpu "${cpu:-max}" -kernel "$kernel/vmlinux") console="ttyS0 mitigations=off"
else
  die "-k '$kernel' holds no kernel: pass the folder that .ci/kernel prints"
fi
[[ -e $root/usr/bin/bash ]] || die "-r '$root' has no bash: pass the folder that .ci/sysroot prints"
(($# > 0)) || die "no command was given"
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
out=${out:-$temporary/out}
mkdir -p "$out"
out=$(realpath "$out")
rm -f "$out/.status" "$out/.pid" "$out/.vmrun.service"
if $init; then
  cat >"$out/.vmrun.service" <<'TEXT'
[Service]
ExecStart=/bin/bash /out/.vmrun
StandardOutput=tty
StandardError=tty
TTYPath=/dev/console
TEXT
fi

# What the machine runs as root after init.sh.
{
  echo 'export PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/tmp TERM=dumb PYTHONUTF8=1'
  echo 'read -r up rest </proc/uptime; exec </dev/null'
  echo '[[ -e /dev/fd ]] || ln -s /proc/self/fd /dev/fd'
  for number in "${!shares[@]}"; do
    printf 'mkdir -p %q /run/share%d/{lower,upper,work}\n' "${shares[number]}" "$number"
    printf 'mount -t 9p -o ro,trans=virtio,version=9p2000.L,msize=262144,cache=loose share%d /run/share%d/lower\n' "$number" "$number"
    printf 'mount -t overlay -o lowerdir=/run/share%d/lower,upperdir=/run/share%d/upper,workdir=/run/share%d/work overlay %q\n' \
      "$number" "$number" "$number" "${shares[number]}"
  done
  for module in $modules; do
    echo "modprobe ${module//:/ } || echo 'vmrun: $module cannot be loaded'"
  done
  # shellcheck disable=SC2016  # the machine's own
  echo 'read -r rest page rest < <(grep -m 1 KernelPageSize /proc/self/smaps)'
  # shellcheck disable=SC2016
  echo 'echo "vmrun: Linux $(uname -r), pages of $page KiB, ready after $up s"'
  printf 'cd /; ('
  printf ' %q' "$@"
  # shellcheck disable=SC2016
  echo ' ); echo $? >/out/.status; sync; echo o >/proc/sysrq-trigger; sleep 60'
} >"$out/.vmrun"

share() {  # NAME FOLDER [OPTION]
  machine+=(-fsdev "local,id=$1,path=$2,security_model=none,multidevs=remap${3:+,$3}" -device "virtio-9p-pci,fsdev=$1,mount_tag=$1")
}
machine+=(-accel "tcg,thread=multi" -m "$memory" -smp "$cpus" -nodefaults -nographic -no-reboot -serial stdio
  -pidfile "$out/.pid" -device virtio-rng-pci -initrd "$kernel/initrd.cpio" -append "console=$console panic=-1 $quiet")
if [[ -n $disk ]]; then machine+=(-drive "file=$disk,format=raw,if=none,id=disk" -device "virtio-blk-pci,drive=disk"); fi
share root "$root" readonly=on
share out "$out"
share modules "$(echo "$kernel"/lib/modules/*)" readonly=on
for number in "${!shares[@]}"; do share "share$number" "${shares[number]}" readonly=on; done
status=0
# Without the control characters of amd64's firmware.
timeout -k 5 "$limit" "${machine[@]}" </dev/null 2>&1 | sed -u -e 's/\r$//; s/\x1b\[[?0-9;]*[a-zA-Z]//g; s/\x1bc//g; /^SeaBIOS/d; s/^Booting from ROM\.*//' || status=${PIPESTATUS[0]}
if [[ -s $out/.status ]]; then exit "$(<"$out/.status")"; fi
if ((status == 124)); then exit 124; fi
exit 125
