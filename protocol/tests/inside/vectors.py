"""A second implementation of the format's cryptography, from FORMAT.md and the RFCs alone, to make vectors.rs's vectors.

Run it (`python3 vectors.py`, nothing to install) and compare with the literals in vectors.rs.
"""

import hashlib
import struct


def derive(key, label, data=b""):
    return hashlib.blake2s(label.encode().ljust(16, b"\0") + data, key=key, digest_size=32).digest()


def chacha20_block(key, counter, nonce):
    state = list(struct.unpack("<4I8I", b"expand 32-byte k" + key)) + [counter] + list(struct.unpack("<3I", nonce))
    x = state[:]

    def quarter(a, b, c, d):
        for i, j, k, r in ((a, b, d, 16), (c, d, b, 12), (a, b, d, 8), (c, d, b, 7)):
            x[i] = (x[i] + x[j]) & 0xFFFFFFFF
            v = x[k] ^ x[i]
            x[k] = (v << r | v >> (32 - r)) & 0xFFFFFFFF

    for _ in range(10):
        quarter(0, 4, 8, 12), quarter(1, 5, 9, 13), quarter(2, 6, 10, 14), quarter(3, 7, 11, 15)
        quarter(0, 5, 10, 15), quarter(1, 6, 11, 12), quarter(2, 7, 8, 13), quarter(3, 4, 9, 14)
    return struct.pack("<16I", *((a + b) & 0xFFFFFFFF for a, b in zip(x, state)))


def poly1305(key, message):
    r = int.from_bytes(key[:16], "little") & 0x0FFFFFFC0FFFFFFC0FFFFFFC0FFFFFFF
    acc = 0
    for i in range(0, len(message), 16):
        acc = (acc + int.from_bytes(message[i : i + 16] + b"\1", "little")) * r % ((1 << 130) - 5)
    return ((acc + int.from_bytes(key[16:], "little")) & ((1 << 128) - 1)).to_bytes(16, "little")


def aead(key, nonce, text, data):
    stream = b"".join(chacha20_block(key, 1 + i, nonce) for i in range(len(text) // 64 + 1))
    sealed = bytes(a ^ b for a, b in zip(text, stream))
    pad = lambda b: b + bytes(-len(b) % 16)
    mac = pad(data) + pad(sealed) + struct.pack("<QQ", len(data), len(sealed))
    return sealed + poly1305(chacha20_block(key, 0, nonce)[:32], mac)


# RFC 8439, 2.8.2: this implementation itself is right.
RFC = aead(
    bytes(range(0x80, 0xA0)),
    bytes.fromhex("070000004041424344454647"),
    b"Ladies and Gentlemen of the class of '99: If I could offer you only one tip for the future, sunscreen would be it.",
    bytes.fromhex("50515253c0c1c2c3c4c5c6c7"),
)
assert RFC[-16:].hex() == "1ae10b594f09e26a7e902ecbd0600691", RFC[-16:].hex()

P25519 = (1 << 255) - 19


def x25519(scalar, point):
    """RFC 7748, section 5."""
    k = int.from_bytes(scalar, "little") & ~7 & ((1 << 255) - 1) | 1 << 254
    x1 = int.from_bytes(point, "little") & ((1 << 255) - 1)
    x2, z2, x3, z3 = 1, 0, x1, 1
    for bit in reversed(range(255)):
        swap = k >> bit & 1
        if swap:
            x2, x3, z2, z3 = x3, x2, z3, z2
        a, b, c, d = x2 + z2, x2 - z2, x3 + z3, x3 - z3
        aa, bb, da, cb = a * a % P25519, b * b % P25519, d * a % P25519, c * b % P25519
        x3, z3 = (da + cb) ** 2 % P25519, x1 * (da - cb) ** 2 % P25519
        x2, z2 = aa * bb % P25519, (aa - bb) * (aa + 121665 * (aa - bb)) % P25519
        if swap:
            x2, x3, z2, z3 = x3, x2, z3, z2
    return (x2 * pow(z2, P25519 - 2, P25519) % P25519).to_bytes(32, "little")


# RFC 7748, 5.2: the first vector.
RFC = x25519(
    bytes.fromhex("a546e36bf0527c9d3b16154b82465edd62144c0ac1fc5a18506a2244ba449ac4"),
    bytes.fromhex("e6db6867583030db3594c1a424b15f7c726624ec26b3353b10a903a6d0ab1c4c"),
)
assert RFC.hex() == "c3da55379de9c6908e94ea4df28d084f32eccf03491c71f754b4075577a28552", RFC.hex()

VERSION = 2
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


def seal(source, sink, sequence, message, echo=0):
    base = derive(secret, "direction", bytes([source, sink]))
    key = derive(base, "epoch", struct.pack("<Q", sequence >> 20))
    head = bytes([VERSION, 3, source, sink]) + number + struct.pack("<Q", sequence)
    return head + aead(key, bytes(4) + struct.pack("<Q", sequence), struct.pack("<QQ", SEALED, echo) + message, head)


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
