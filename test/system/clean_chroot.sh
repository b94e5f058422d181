#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The promise to a stranger: in a clean Debian 12 that has nothing but git, `git clone`, `./dev run` and `./dev test` work, and
# nothing else is typed. Needs root. The packages come from where this machine gets its own.
# usage: clean_chroot.sh [COMMAND of ./dev ...]     default: run test
#   SUITE=trixie    another Debian
#   KEEP=DIR        make or use the chroot DIR and leave it there
set -euo pipefail
((EUID == 0)) || { echo "clean_chroot.sh: needs root" >&2; exit 1; }
checkout=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.." && pwd)
suite=${SUITE:-bookworm}
commands=("$@")
if ((${#commands[@]} == 0)); then commands=(run test); fi
"$checkout/dev" setup chroot

# The first mirror of this machine's own configuration, in either of apt's two formats.
mirror=$({ cat /etc/apt/sources.list /etc/apt/sources.list.d/*.sources /etc/apt/sources.list.d/*.list 2>/dev/null || true; } |
  sed -nE 's/^URIs:[[:space:]]*([^[:space:]]+).*/\1/p; s/^deb[[:space:]]+(\[[^]]*\][[:space:]]+)?([^[:space:]]+)[[:space:]].*/\2/p' |
  grep -E '/debian/?$' | head -n 1)
[[ -n $mirror ]] || { echo "clean_chroot.sh: no Debian mirror in /etc/apt" >&2; exit 1; }

chroot_dir=${KEEP:-$(mktemp -d /var/tmp/nacelle-chroot.XXXXXX)}
clean_up() {
  local mounted
  # Deepest first; a busy one is detached, so that nothing of this machine is ever below the folder that is removed.
  for mounted in dev/shm dev/pts proc; do
    if mountpoint -q "$chroot_dir/$mounted"; then umount "$chroot_dir/$mounted" || umount -l "$chroot_dir/$mounted"; fi
  done
  if [[ -z ${KEEP:-} ]] && ! grep -q " $chroot_dir/" /proc/mounts; then rm -rf --one-file-system "$chroot_dir"; fi
}
trap clean_up EXIT
trap 'exit 130' INT TERM

if [[ ! -x $chroot_dir/usr/bin/git ]]; then
  echo "=== debootstrap $suite"
  debootstrap --variant=minbase --include=git,ca-certificates "$suite" "$chroot_dir" "$mirror" >"$chroot_dir.log" 2>&1 ||
    { tail -n 20 "$chroot_dir.log" >&2; exit 1; }
  rm -f "$chroot_dir.log"
fi
# How packages are fetched on this machine (a proxy, say) holds inside too; its sources do for their own suite only.
if [[ -d /etc/apt/apt.conf.d ]]; then
  grep -lE '^\s*Acquire::' /etc/apt/apt.conf.d/* 2>/dev/null | xargs -r cp -t "$chroot_dir/etc/apt/apt.conf.d/"
fi
cp -L /etc/resolv.conf /etc/hosts "$chroot_dir/etc/" 2>/dev/null || true
mkdir -p "$chroot_dir/proc" "$chroot_dir/dev/pts" "$chroot_dir/dev/shm"
mountpoint -q "$chroot_dir/proc" || mount -t proc proc "$chroot_dir/proc"
mountpoint -q "$chroot_dir/dev/pts" || mount -t devpts -o newinstance,ptmxmode=0666,mode=0620 devpts "$chroot_dir/dev/pts"
ln -sf pts/ptmx "$chroot_dir/dev/ptmx"
mountpoint -q "$chroot_dir/dev/shm" || mount -t tmpfs tmpfs "$chroot_dir/dev/shm"

inside() { env -i HOME=/srv PATH=/usr/sbin:/usr/bin:/sbin:/bin CI="${CI:-}" ${http_proxy:+http_proxy="$http_proxy"} chroot "$chroot_dir" "$@"; }
# A clone of what is committed here, handed in as one file, so that nothing of this machine needs to be visible inside.
git -c safe.directory='*' -C "$checkout" bundle create "$chroot_dir/srv/nacelle.bundle" HEAD >/dev/null 2>&1
inside rm -rf /srv/nacelle
inside git -c advice.detachedHead=false clone -q /srv/nacelle.bundle /srv/nacelle
for command in "${commands[@]}"; do
  echo "=== in a clean $suite: ./dev $command"
  begin=$SECONDS
  # shellcheck disable=SC2086  # a command with its arguments
  inside bash -c 'cd /srv/nacelle && exec ./dev "$@"' dev $command </dev/null
  echo "=== ./dev $command: exit 0 after $((SECONDS - begin)) s"
done
