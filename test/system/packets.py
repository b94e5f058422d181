# SPDX-License-Identifier: Apache-2.0
"""What really leaves a machine: every frame of a link, as its network card would send it.

usage: packets.py LINK     says "ready", then writes each frame to standard output as its length (4 bytes, big endian) and its
                           bytes, until standard input ends
"""
import os
import select
import socket
import struct
import subprocess
import sys
import tempfile

EVERY_PROTOCOL = 0x0003  # ETH_P_ALL of linux/if_ether.h


class Packets:
    """Frames of a machine's link, from now until stop()."""

    def __init__(self, machine, link="lan0"):
        self.file = tempfile.TemporaryFile()
        self.process = subprocess.Popen(
            machine.within("/usr/bin/python3", "-B", __file__, link), stdin=subprocess.PIPE, stdout=self.file, stderr=subprocess.PIPE
        )
        if self.process.stderr.readline() != b"ready\n":
            raise AssertionError(f"no packets of {link} can be had")

    def stop(self):
        """All that came, one behind the other."""
        self.end()
        self.file.seek(0)
        return self.file.read()

    def end(self):
        if self.process.poll() is None:
            self.process.stdin.close()
            self.process.wait()
            self.process.stderr.close()

    def close(self):
        self.end()
        self.file.close()


def write_frames(link):
    # The sent ones too; a large buffer, since images come in bursts.
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(EVERY_PROTOCOL)) as tap:
        tap.setsockopt(socket.SOL_SOCKET, 33, 64 << 20)  # SO_RCVBUFFORCE
        tap.bind((link, EVERY_PROTOCOL))
        os.write(2, b"ready\n")
        while True:
            readable, _, _ = select.select([tap, sys.stdin], [], [])
            if tap in readable:
                frame = tap.recv(65536)
                sys.stdout.buffer.write(struct.pack(">I", len(frame)) + frame)
            elif not os.read(0, 1):
                return


if __name__ == "__main__":
    write_frames(sys.argv[1])
