"""A second implementation of meetings, from FORMAT.md alone, to make vectors.rs's literals: `python3 vectors.py`, nothing to install."""

import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).parents[4] / "protocol/tests/inside"))
from rfc import derive, x25519  # noqa: E402

NINE = bytes([9]) + bytes(31)


def pair(key):
    secret = derive(key, "pair")
    return secret, x25519(secret, NINE)


def code(key):
    number = int.from_bytes(derive(key, "code")[:8], "little") % 1_000_000
    return f"{number // 1000:03} {number % 1000:03}"


def link(secret, place):
    check = derive(secret + bytes(16), "link", place.encode())[:2]
    bits = "".join(f"{byte:08b}" for byte in secret + check) + "0"
    letters = "abcdefghijklmnopqrstuvwxyz234567"
    return f"haptic://{place}/" + "".join(letters[int(bits[at : at + 5], 2)] for at in range(0, 145, 5))


key = bytes([7] * 32)
seats = [pair(derive(key, "seat", bytes([side]))) for side in (0, 1)]
names = [derive(public, "seat")[:16] for _, public in seats]
place, cookie = pair(bytes([5] * 32)), bytes(range(16))
proof = derive(x25519(seats[1][0], place[1]), "proof", cookie)[:16]
assert proof == derive(x25519(place[0], seats[1][1]), "proof", cookie)[:16]
print("seat", seats[1][1].hex(), "other", names[0].hex(), "room", derive(names[0] + names[1], "room")[:16].hex())
print("place", place[1].hex(), "proof", proof.hex())

(_, invites), (accepts_secret, accepts) = pair(bytes([1] * 32)), pair(bytes([2] * 32))
secret = derive(invites, "invite")[:16]
k = secret + bytes(16)
agreed = derive(k, "agreed", x25519(accepts_secret, invites) + accepts + invites)
masked = bytes(one ^ other for one, other in zip(invites, derive(k, "mask", accepts)))
print(link(secret, "203.0.113.1:4000"))
print("offer", (b"\xf4\x01" + accepts + derive(k, "agreement", b"\x01" + accepts)[:16]).hex())
print("answer", (b"\xf4\x02" + masked + derive(agreed, "agreement", b"\x02" + invites)[:16]).hex())
print("key", agreed.hex(), "code", code(agreed))
