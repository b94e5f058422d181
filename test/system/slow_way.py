# SPDX-License-Identifier: Apache-2.0
"""Passes frames on between two links, each so many seconds after it came: slow_way.py LINK LINK SECONDS."""
import collections
import contextlib
import os
import select
import socket
import sys
import time

PACKET_OUTGOING = 4  # linux/if_packet.h


def without_checksum(frame):
    """Clears the UDP checksum, which a veth leaves to the last device. 0 means none (RFC 768)."""
    is_udp = frame[12:14] == b"\x08\x00" and frame[23] == socket.IPPROTO_UDP
    is_first = is_udp and (frame[20] & 0x1F) == 0 and frame[21] == 0
    if is_first:
        at = 14 + 4 * (frame[14] & 0x0F) + 6
        frame[at : at + 2] = bytes(2)
    return frame


def main():
    links = []
    for name in sys.argv[1:3]:
        link = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x0003))
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        link.bind((name, 0))
        links.append(link)
    delay_s = float(sys.argv[3])
    with contextlib.suppress(PermissionError):  # without real-time priority, the delay is less exact
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
    on_their_way = collections.deque()
    print("ready", flush=True)
    while True:
        wait_s = max(0.0, on_their_way[0][0] - time.monotonic()) if on_their_way else None
        for link in select.select(links, [], [], wait_s)[0]:
            data, address = link.recvfrom(65536)
            if address[2] != PACKET_OUTGOING:
                other = links[1 - links.index(link)]
                on_their_way.append((time.monotonic() + delay_s, other, without_checksum(bytearray(data))))
        while on_their_way and on_their_way[0][0] <= time.monotonic():
            _, other, frame = on_their_way.popleft()
            other.send(frame)


if __name__ == "__main__":
    main()
