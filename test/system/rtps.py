# SPDX-License-Identifier: Apache-2.0
"""Reads announcements: what participants say of themselves and of their writers and readers (RTPS 2.3, 9.6.2.2)."""
import struct

INFO_SRC, DATA = 0x0C, 0x15
LITTLE_ENDIAN, WITH_INLINE_QOS, WITH_PAYLOAD = 0x01, 0x02, 0x04
KINDS = {0x000100C2: "SPDP", 0x000003C2: "SEDP-pub", 0x000004C2: "SEDP-sub"}
# Names of test/data/ros2_wire; the others stay numbers there too.
NAMES = {0x02: "PARTICIPANT_LEASE_DURATION", 0x05: "TOPIC_NAME", 0x07: "TYPE_NAME", 0x0F: "DOMAIN_ID", 0x15: "PROTOCOL_VERSION",
         0x16: "VENDORID", 0x1A: "RELIABILITY", 0x1B: "LIVELINESS", 0x1D: "DURABILITY", 0x1E: "DURABILITY_SERVICE", 0x23: "DEADLINE",
         0x2B: "LIFESPAN", 0x2C: "USER_DATA", 0x31: "DEFAULT_UNICAST_LOCATOR", 0x32: "METATRAFFIC_UNICAST_LOCATOR",
         0x33: "METATRAFFIC_MULTICAST_LOCATOR", 0x40: "HISTORY", 0x48: "DEFAULT_MULTICAST_LOCATOR", 0x50: "PARTICIPANT_GUID",
         0x58: "BUILTIN_ENDPOINT_SET", 0x59: "PROPERTY_LIST", 0x5A: "ENDPOINT_GUID"}  # fmt: skip
TEXTS, BYTES = ("TOPIC_NAME", "TYPE_NAME"), ("USER_DATA",)


def announcements_of(message):
    if message[:4] != b"RTPS":
        return
    prefix, at = message[8:20].hex(), 20
    while at + 4 <= len(message):
        kind, flags = message[at], message[at + 1]
        length = struct.unpack_from("<H" if flags & LITTLE_ENDIAN else ">H", message, at + 2)[0]
        body = message[at + 4 : at + 4 + length] if length else message[at + 4 :]
        if kind == INFO_SRC:  # the submessages that follow are of another participant than the header names
            prefix = body[8:20].hex()
        if kind == DATA and flags & WITH_PAYLOAD and flags & LITTLE_ENDIAN:
            writer = struct.unpack_from(">I", body, 8)[0]
            start = 4 + struct.unpack_from("<H", body, 2)[0]
            if flags & WITH_INLINE_QOS:
                start += parameters(body[start:])[1]
            if writer in KINDS:
                yield KINDS[writer], prefix, dict(map(as_recorded, parameters(body[start + 4 :])[0]))
        if not length:
            return
        at += 4 + length


def parameters(data):
    """The list, and how many bytes it takes."""
    found, at = [], 0
    while at + 4 <= len(data):
        number, length = struct.unpack_from("<HH", data, at)
        at += 4
        if number == 1:
            break
        found.append((number, data[at : at + length]))
        at += length
    return found, at


def as_recorded(parameter):
    number, value = parameter
    name = NAMES.get(number, f"0x{number:04x}" if number > 0xFF else hex(number))
    if name in TEXTS:
        return name, value[4 : 3 + struct.unpack_from("<I", value)[0]].decode()
    if name in BYTES:
        return name, value[4 : 4 + struct.unpack_from("<I", value)[0]].decode("latin1")
    return name, value.hex()
