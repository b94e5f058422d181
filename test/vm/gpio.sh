#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Runs the emergency button's test on a line of the kernel's gpio-sim, in a virtual machine.
#
# usage: gpio.sh TEST_PROGRAM
# NACELLE_VM names a program that runs one command in a throw-away machine with this file system:
#   $NACELLE_VM -m "MODULE ..." -t SECONDS -- COMMAND ...      exit code: the command's; 124 too late, 125 the machine died
# NACELLE_GPIOD2 may name a copy of the test program that was linked with libgpiod 2; it is run as well.
set -euo pipefail

inside() {
  mountpoint -q /sys/kernel/config || mount -t configfs none /sys/kernel/config
  for program in "$@"; do
    local device=/sys/kernel/config/gpio-sim/nacelle
    mkdir -p $device/bank
    echo 4 > $device/bank/num_lines
    echo 1 > $device/live
    chip=$(cat $device/bank/chip_name)
    for _ in $(seq 50); do [[ -c /dev/$chip ]] && break; sleep 0.1; done
    NACELLE_GPIO_CHIP=/dev/$chip NACELLE_GPIO_LIVE=$device/live \
      NACELLE_GPIO_PULL=/sys/devices/platform/$(cat $device/dev_name)/$chip/sim_gpio0/pull "$program"
    echo 0 > $device/live 2> /dev/null || true
    rmdir $device/bank $device
  done
}

if [[ ${1:-} == --inside ]]; then
  shift
  inside "$@"
  exit
fi
if [[ -z ${NACELLE_VM:-} ]]; then
  echo "gpio.sh: SKIPPED: NACELLE_VM names no program that runs a command in a virtual machine, so the emergency button was not" \
    "tested on a line of a real kernel driver" >&2
  exit 77
fi
programs=("$(realpath "$1")")
[[ -n ${NACELLE_GPIOD2:-} ]] && programs+=("$(realpath "$NACELLE_GPIOD2")")
$NACELLE_VM -m "configfs gpio-sim" -t 240 -- "$(realpath "$0")" --inside "${programs[@]}"
