"""A second implementation of the format, from FORMAT.md alone, to make vectors.rs's vectors. Its cryptography is rfc.py.

Run it (`python3 vectors.py`, nothing to install) and compare with the literals in vectors.rs.
"""

import hashlib
import struct

from rfc import aead, derive, x25519

VERSION = 4
K = bytes([7] * 32)
ONE, TWO = 1, 2
C1, C2 = bytes(range(16)), bytes(range(16, 32))
S1, S2 = bytes(range(0x40, 0x60)), bytes(range(0x80, 0xA0))
NINE = bytes([9]) + bytes(31)
E1, E2 = x25519(S1, NINE), x25519(S2, NINE)
X = x25519(S1, E2)
assert X == x25519(S2, E1)
I1, I2 = 0x0102030405060708, 0x1112131415161718


def text(s):
    return struct.pack("<I", len(s)) + s.encode()


def table(name, *pairs):
    data = text(name)
    for key, value in pairs:
        if isinstance(value, bool):
            data += text(key) + b"f" + bytes([value])
        elif isinstance(value, float):
            data += text(key) + b"n" + struct.pack("<d", value)
        else:
            data += text(key) + b"t" + text(value)
    return derive(bytes(32), "table", data)[:6]


TABLES = [
    table("timing", ("control_period_s", 0.001), ("ticks_per_packet", 8.0)),
    table("coordination", ("comm", "wave"), ("one_sided", True)),
]
tables = b"".join(TABLES) + bytes(6 * (16 - len(TABLES)))
count = bytes([len(TABLES)])

# A hello from peer 1 to peer 2.
body = bytes([VERSION, 1, ONE, TWO, 0, 0, 0, 0]) + C1 + C2 + struct.pack("<Q", I1) + E1 + count + bytes(7) + tables
hello = body + hashlib.blake2s(body, key=derive(K, "greeting", bytes([ONE, TWO])), digest_size=16).digest()
print("HELLO", hello.hex())

secret = derive(K, "session", bytes([VERSION, ONE, TWO]) + E1 + E2 + struct.pack("<QQ", I1, I2) + X + count + tables)
number = derive(secret, "number")[:4]
flow = struct.pack("<BBHIfffddI", 1, 1, 0, 4711, 0.25, -0.5, 1.5, 2.0, 3.0, 4712)


# Everything is sealed at 1 s of its sender's clock.
SEALED = 1_000_000


def seal(source, sink, sequence, message, echo=0, lease=0, padding=0):
    base = derive(secret, "direction", bytes([source, sink]))
    key = derive(base, "epoch", struct.pack("<Q", sequence >> 20))
    head = bytes([VERSION, 3, source, sink]) + number + struct.pack("<Q", sequence)
    stamps = SEALED.to_bytes(7, "little") + bytes([padding]) + echo.to_bytes(7, "little") + bytes([lease])
    return head + aead(key, bytes(4) + struct.pack("<Q", sequence), stamps + message + bytes(padding), head)


print("FLOW", seal(ONE, TWO, 0, flow).hex())
print("LATER_FLOW", seal(ONE, TWO, (5 << 20) + 3, flow).hex())
# A server's line 300: its key, and a hello on it.
line = derive(K, "line", struct.pack("<I", 300))
body = bytes([VERSION, 1, ONE, TWO]) + struct.pack("<I", 300) + C1 + C2 + struct.pack("<Q", I1) + E1 + count + bytes(7) + tables
tag = hashlib.blake2s(body, key=derive(line, "greeting", bytes([ONE, TWO])), digest_size=16).digest()
print("LINE_HELLO_TAG", tag.hex())


# A world of one region and one object, and the messages that carry it.
def summed(record):
    return record + derive(bytes(32), "record", record)[:8]


OBJECT = summed(struct.pack("<IIB3x7f16x", 5, 6, 1, 0.0, 0.5, 2.0, 0.5, 0.25, 1000.0, 2.0))
REGION = summed(struct.pack("<BBH4f4x", 3, 1, 0, -1.0, -1.0, 1.0, 1.0))
MANIFEST = struct.pack("<IHBBf", 9, 1, 1, 0, 0.125)
WORLD = derive(bytes(32), "world", MANIFEST + REGION + OBJECT)[:8]
print("WORLD", WORLD.hex())


def part(topic, payload):
    return struct.pack("<BBHB3x", 17, topic, 0, 8) + WORLD + payload


print("ASK", seal(TWO, ONE, 10, struct.pack("<BBHBBBBfff", 16, 3, 0, 1, 0, 8, 0, 1.0, -2.0, 3.0) + b"\1" + bytes(31)).hex())
print("PART_MANIFEST", seal(ONE, TWO, 11, part(0, MANIFEST)).hex())
print("PART_REGION", seal(ONE, TWO, 12, part(1, REGION)).hex())
print("PART_PAGE", seal(ONE, TWO, 13, part(2, b"\1" + bytes(3) + OBJECT[-8:] + bytes(56))).hex())
print("PART_OBJECT", seal(ONE, TWO, 14, part(3, OBJECT)).hex())
print("PRESENCE", seal(TWO, ONE, 15, struct.pack("<BBHIIffff", 18, 1, 0, 77, 300, 0.5, -0.5, 1.5, -1.5)).hex())
# An answer to the flow: it echoes when that was sealed.
print("PROBE_BACK", seal(TWO, ONE, 9, struct.pack("<B3xQ", 5, 123456789), SEALED).hex())
# The same from an end that lets the other run, by word 5, and whose messages are as long as the longest event.
print("PADDED_PROBE", seal(TWO, ONE, 9, struct.pack("<B3xQ", 5, 123456789), SEALED, 5 << 2 | 2, 56 - 12).hex())
