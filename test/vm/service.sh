#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What nacelle@.service promises, under systemd: .ci/test-deb --service runs this in a virtual machine in which the package is
# installed. It has no network, no devices and a wrong clock. Prints a line for each thing that holds, and ends with 1 at the first that does not.
#
# usage: service.sh, as root
set -euo pipefail
unit=nacelle@robot

fail() {
  echo "FAILED: $1"
  systemctl status "$unit" --no-pager --lines 5 || true
  journalctl -u "$unit" -n 30 --no-pager -o cat || true
  exit 1
}
holds() { printf 'holds: %s (after %d s)\n' "$1" "$SECONDS"; }
# eventually WHAT LIMIT_S COMMAND...: a machine that is emulated is ten times slower.
eventually() {
  local what=$1 end=$((SECONDS + $2))
  shift 2
  while ! "$@" >/run/output 2>&1; do
    ((SECONDS < end)) || { cat /run/output && fail "$what"; }
    sleep 0.5  # the polling period
  done
  holds "$what"
}
of_unit() { systemctl show --property "$1" --value "$unit"; }
restarted() { [[ $(of_unit ActiveState) == active && $(of_unit NRestarts) -ge $1 && $(of_unit MainPID) != "$2" ]]; }
as() { runuser --login --command "$2" "$1"; }
says() { as pilot "$1" | grep -qE "$2"; }

date --set 2010-01-01 >/dev/null
SECONDS=0  # it follows the clock
useradd --create-home pilot
useradd --create-home stranger

# The robot of the guide, with parameters of its own.
cd "$(mktemp -d)"
mkdir -p /etc/nacelle/robot
cp /usr/share/nacelle_launch/config/robot.yaml /etc/nacelle/robot/
cat >robot.launch.yaml <<'END'
launch:
- include:
    file: $(find-pkg-share nacelle_launch)/robot.launch.yaml
    arg:
    - {name: sim, value: 'false'}
    - {name: detector, value: 'false'}
    - {name: config, value: $(dirname)/robot.yaml}
    - {name: base_port, value: /dev/ttyUSB2}   # the machine's console is ttyAMA0
    - {name: camera_device, value: pattern}
END

nacelle service install robot.launch.yaml || fail "nacelle service install"
is_active() { [[ $(of_unit ActiveState) == active ]]; }
eventually "install starts the robot, without network and devices" 120 is_active
[[ $(of_unit User) == nacelle && $(stat -c %U:%G:%a /run/nacelle) == nacelle:nacelle:750 ]] || fail "its user and /run/nacelle"
nacelle service status || fail "nacelle service status"
usermod -aG nacelle pilot
eventually "a member of group nacelle operates it without sudo" 120 says "nacelle component list" "/lidar +active +open fault: DEVICE_LOST"
if as stranger "nacelle component list" >/run/output 2>&1; then fail "a user outside group nacelle reached the robot"; fi
holds "others do not reach it: $(tail -n 1 /run/output)"
logs_name_the_device() { nacelle service logs --component /lidar | grep -q /dev/ttyUSB0; }
eventually "the journal has components as fields" 60 logs_name_the_device

had=$(as pilot "nacelle param get /diff_drive linear.x.max_velocity")
sed -i 's/max_velocity: 0.5/max_velocity: 0.25/' /etc/nacelle/robot/robot.yaml
systemctl reload "$unit" || fail "systemctl reload"
eventually "a reload applies the parameters of the files: 0.25 m/s instead of '$had'" 60 says "nacelle param get /diff_drive linear.x.max_velocity" 0.25

main=$(of_unit MainPID)
kill -KILL "$main"
eventually "it comes back after SIGKILL" 120 restarted 1 "$main"
eventually "its wheels are deactivated then" 120 says "nacelle component list" "/diff_drive +inactive"
eventually "an operator activates them" 60 as pilot "nacelle lifecycle set diff_drive activate"

main=$(of_unit MainPID)
kill -STOP "$main"
eventually "it comes back when the process hangs (watchdog)" 120 restarted 2 "$main"

systemctl stop "$unit"
[[ $(of_unit Result) == success ]] || fail "systemctl stop ended with $(of_unit Result)"
holds "systemctl stop ends it in time"
systemctl start "$unit"
nacelle service remove || fail "nacelle service remove"
[[ $(of_unit ActiveState) == inactive && $(systemctl is-enabled "$unit" 2>&1) != enabled && -e /etc/nacelle/robot/robot.launch.yaml ]] || fail "service remove stops it, and keeps /etc/nacelle"
holds "service remove stops it, and keeps /etc/nacelle"
