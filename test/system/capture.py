# SPDX-License-Identifier: Apache-2.0
"""What passes a link of another network namespace, frame by frame, as the network card has it."""
import ctypes
import os
import select
import socket
import struct
import threading

import rtps

ETH_P_ALL, ETH_P_IP, ETH_P_ARP, PACKET_OUTGOING, SO_RCVBUFFORCE = 3, 0x0800, 0x0806, 4, 33
PROTOCOLS = {1: "icmp", 2: "igmp", 6: "tcp", 17: "udp"}


class Capture:
    """From now on until close(). What the machine itself sends is left out unless `sent`; on lo all of it comes in, too."""

    def __init__(self, machine, link="lan0", sent=False):
        self.all, self.announced, self.sent = [], 0, sent
        self.socket = within_network_of(machine.holder.pid, lambda: socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_ALL)))
        self.socket.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 64 << 20)  # images come in bursts
        self.socket.bind((link, ETH_P_ALL))
        self.over, self.end = os.pipe()
        self.thread = threading.Thread(target=self.read)
        self.thread.start()

    def read(self):
        while self.over not in (ready := select.select([self.socket, self.over], [], [])[0]) or self.socket in ready:
            frame, (_, _, direction, *_) = self.socket.recvfrom(65536)
            if self.sent or direction != PACKET_OUTGOING:
                self.all.append(frame)

    def stop(self):
        """All that was there has been read."""
        if self.thread.is_alive():
            os.write(self.end, b"!")
            self.thread.join()

    def close(self):
        self.stop()
        self.socket.close()
        os.close(self.over)
        os.close(self.end)

    def frames(self):
        """A line for each: "arp", "igmp FROM TO", "udp FROM:PORT TO:PORT GUID_PREFIX" ("-": no RTPS), ..."""
        return [told(frame) for frame in self.all[:]]

    def speakers(self):
        """The GUID prefixes of the participants that sent something."""
        return {line.split()[3] for line in self.frames() if line.startswith("udp ")} - {"-"}

    def announcements(self):
        """(kind, prefix of the participant, parameters) of each that has passed since the last call."""
        new, self.announced = self.all[self.announced :], len(self.all)
        for frame in new:
            if payload := udp_payload(frame):
                yield from rtps.announcements_of(payload)


def within_network_of(pid, make):
    clone_newnet, libc = 0x40000000, ctypes.CDLL(None, use_errno=True)
    with open("/proc/thread-self/ns/net") as ours, open(f"/proc/{pid}/ns/net") as theirs:
        if libc.setns(theirs.fileno(), clone_newnet) != 0:
            raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
        try:
            return make()
        finally:
            libc.setns(ours.fileno(), clone_newnet)


def told(frame):
    (kind,), packet = struct.unpack("!H", frame[12:14]), frame[14:]
    if kind != ETH_P_IP:
        return "arp" if kind == ETH_P_ARP else f"other {kind:#06x}"
    source, destination = socket.inet_ntoa(packet[12:16]), socket.inet_ntoa(packet[16:20])
    protocol = PROTOCOLS.get(packet[9], f"ip {packet[9]}")
    if protocol != "udp":
        return f"{protocol} {source} {destination}"
    if struct.unpack("!H", packet[6:8])[0] & 0x1FFF:
        return f"fragment {source} {destination}"
    rest = packet[(packet[0] & 15) * 4 :]
    ports = struct.unpack("!HH", rest[:4])
    prefix = rest[16:28].hex() if rest[8:12] == b"RTPS" else "-"
    return f"udp {source}:{ports[0]} {destination}:{ports[1]} {prefix}"


def udp_payload(frame):
    """None where it is not UDP over IPv4 in one piece."""
    if len(frame) < 42 or frame[12:14] != b"\x08\x00" or frame[23] != socket.IPPROTO_UDP:
        return None
    if struct.unpack_from(">H", frame, 20)[0] & 0x3FFF:
        return None
    start = 14 + (frame[14] & 0x0F) * 4
    return frame[start + 8 : start + struct.unpack_from(">H", frame, start + 4)[0]]
