# SPDX-License-Identifier: Apache-2.0
"""Prints a line for each frame that comes in by a link: "arp", "igmp ...", "icmp ...", "udp FROM TO GUID_PREFIX", ...

usage: capture.py LINK
The prefix is the participant's whose RTPS message it is, "-" where it is none. What this machine sends itself is left out,
but on lo, where all of it comes in.
"""
import socket
import struct
import sys

ETH_P_ALL, ETH_P_IP, ETH_P_ARP, PACKET_OUTGOING = 3, 0x0800, 0x0806, 4
PROTOCOLS = {1: "icmp", 2: "igmp", 6: "tcp", 17: "udp"}


def told(kind, packet):
    """What stands in a packet without its frame's header."""
    if kind == ETH_P_ARP:
        return "arp"
    if kind != ETH_P_IP:
        return f"other {kind:#06x}"
    header, (flags,) = (packet[0] & 15) * 4, struct.unpack("!H", packet[6:8])
    source, destination = socket.inet_ntoa(packet[12:16]), socket.inet_ntoa(packet[16:20])
    protocol, rest = PROTOCOLS.get(packet[9], f"ip {packet[9]}"), packet[header:]
    if protocol != "udp":
        return f"{protocol} {source} {destination}"
    if flags & 0x1FFF:
        return f"fragment {source} {destination}"
    ports = struct.unpack("!HH", rest[:4])
    prefix = rest[16:28].hex() if rest[8:12] == b"RTPS" else "-"
    return f"udp {source}:{ports[0]} {destination}:{ports[1]} {prefix}"


def main():
    link = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(ETH_P_ALL))
    link.bind((sys.argv[1], ETH_P_ALL))
    print("ready", flush=True)
    while True:
        packet, (_, kind, direction, *_) = link.recvfrom(65536)
        if direction != PACKET_OUTGOING:
            print(told(kind, packet), flush=True)


if __name__ == "__main__":
    try:
        main()
    except (KeyboardInterrupt, BrokenPipeError, OSError):
        pass
