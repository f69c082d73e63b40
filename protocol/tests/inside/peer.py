"""The other end of a line in another language, from FORMAT.md alone, with nothing to install (cryptography: rfc.py).

    python3 peer.py '{"key": "FILE", "from": 2, "to": 1, "line": 0, "listen": PORT, "connect": PORT, "seconds": 1.5, "ask": false, "mutate": 0}'

Calls on loopback and answers calls, has a session, says flow each 8 ms, or asks a server for what it has, for so long; then says goodbye. Of a world that came the checksums are computed, too.
With "mutate": SEED it says a message more beside each flow: flows with numbers that are none or far too large, and what it says with bits turned, cut,
grown or made up, each sealed as it should be. Prints what came, as JSON. Of parameters it takes whatever the other end was told: their hashes stand in its greetings.
"""

import hashlib
import json
import os
import random
import socket
import struct
import sys
import time

from rfc import aead, derive, x25519

VERSION, HELLO, WELCOME, SEALED = 4, 1, 2, 3
FLOW, PROBE, REPLY, GOODBYE, ASK, PART = 1, 5, 6, 7, 16, 17
NONE, NINE = bytes(16), bytes([9]) + bytes(31)
PERIOD_S, LIFE_US = 0.008, 1_000_000


def tag(key, body):
    return hashlib.blake2s(body, key=key, digest_size=16).digest()


class Session:
    """The keys of two greetings, and what came under them."""

    def __init__(self, key, mine, theirs, agreed, ends):
        low, high = (mine, theirs) if mine[2] < theirs[2] else (theirs, mine)
        data = bytes([VERSION, low[2], high[2]]) + low[48:80] + high[48:80] + low[40:48] + high[40:48] + agreed
        secret = derive(key, "session", data + theirs[80:81] + theirs[88:184])
        self.number = derive(secret, "number")[:4]
        self.bases = [derive(secret, "direction", bytes(pair)) for pair in (ends, ends[::-1])]
        self.theirs, self.ends = theirs[40:80], ends
        self.began, self.newest, self.stamp, self.confirmed = now_us(), -1, 0, False
        # Of the newest datagram: its byte about the lease, and its echo. When the newest fresh one came.
        self.lease, self.echo, self.fresh_us = 0, 0, self.began

    def key(self, base, sequence):
        return derive(base, "epoch", struct.pack("<Q", sequence >> 20))

    def seal(self, sequence, message, lease=0):
        head = bytes([VERSION, SEALED, *self.ends]) + self.number + struct.pack("<Q", sequence)
        nonce, stamps = bytes(4) + head[8:], struct.pack("<QQ", now_us(), lease << 56 | self.stamp)
        return head + aead(self.key(self.bases[0], sequence), nonce, stamps + message, head)

    def open(self, datagram):
        """The message, if it is authentic, new and fresh; a probe however old it is."""
        head, sealed = datagram[:16], datagram[16:]
        (sequence,) = struct.unpack("<Q", head[8:])
        if head[:4] != bytes([VERSION, SEALED, *self.ends[::-1]]) or head[4:8] != self.number or sequence <= self.newest:
            return None
        key, nonce = self.key(self.bases[1], sequence), bytes(4) + head[8:]
        # The cipher is its own inverse; the tag is that of what comes out.
        body = aead(key, nonce, sealed[:-16], head)[:-16]
        if aead(key, nonce, body, head) != sealed:
            return None
        self.newest = sequence
        # The eighth byte is how many zeros follow the message, the last one is of the lease, which a peer does not heed (board.py does).
        self.stamp, padding, echo = int.from_bytes(body[:7], "little"), body[7], int.from_bytes(body[8:15], "little")
        self.echo, self.lease = echo, body[15]
        if padding > len(body) - 17 or any(body[len(body) - padding :]):
            return None
        body = body[: len(body) - padding]
        fresh = self.began <= echo <= now_us() < echo + LIFE_US
        self.confirmed |= fresh
        self.fresh_us = now_us() if fresh else self.fresh_us
        return body[16:] if fresh or body[16] == PROBE else None


def number(checksum):
    return checksum[:8][::-1].hex()


def now_us():
    return time.monotonic_ns() // 1000


class Peer:
    def __init__(self, key, ends, line):
        self.key, self.ends, self.line = key, ends, line
        self.secret, self.challenge, self.offered_us = os.urandom(32), NONE, 0
        self.ephemeral, self.incarnation = x25519(self.secret, NINE), os.urandom(8)
        self.tables, self.session, self.far, self.sequence = bytes(104), None, NONE, 0
        self.good = {}

    def greet(self, kind, echo):
        if now_us() - self.offered_us >= 100_000:
            self.challenge, self.offered_us = os.urandom(16), now_us()
            self.good[self.challenge] = self.offered_us
        body = bytes([VERSION, kind, *self.ends]) + struct.pack("<I", self.line) + self.challenge + echo
        body += self.incarnation + self.ephemeral + self.tables
        return body + tag(derive(self.key, "greeting", bytes(self.ends)), body)

    def greeted(self, datagram):
        """The three rules; gives the answer, if any."""
        body, ends = datagram[:184], self.ends[::-1]
        authentic = len(datagram) == 200 and body[2:8] == bytes(ends) + struct.pack("<I", self.line)
        if not authentic or datagram[184:] != tag(derive(self.key, "greeting", bytes(ends)), body):
            return None
        self.tables = body[80:184]
        fresh = now_us() - self.good.get(body[24:40], -LIFE_US) < LIFE_US
        if fresh:
            self.far = body[8:24]
        known = self.session and self.session.theirs == body[40:80]
        if known and (fresh or self.session.confirmed):
            return None
        if fresh:
            agreed = x25519(self.secret, body[48:80])
            mine = self.greet(HELLO, NONE)
            self.session = Session(self.key, mine, body, agreed, self.ends)
            return None
        return self.greet(WELCOME, body[8:24]) if body[1] == HELLO else None

    def seal(self, message, lease=0):
        self.sequence += 1
        return self.session.seal(self.sequence - 1, message, lease)


ODD = [float("nan"), float("inf"), -float("inf"), 3.4e38, -3.4e38, 1e-45, 1e3, -1e3, 50.0, -50.0, 1.0, -1.0, 0.01, 0.0]


def mutated(dice, tick, honest):
    """A message that no honest end would say."""
    kind = dice.randrange(4)
    if kind == 0:
        odd = [dice.choice(ODD) for _ in range(5)]
        return struct.pack("<BBHIfffddI", FLOW, dice.randrange(4), 0, tick, *odd, dice.choice([tick, 0, 2**32 - 1, dice.getrandbits(32)]))
    if kind == 1:
        flags, ahead = dice.getrandbits(8), dice.choice([0, 1, 2**16, 2**31])
        return struct.pack("<BBHIfffddI", FLOW, flags, 0, (tick + ahead) % 2**32, *[dice.uniform(-9, 9) for _ in range(5)], tick)
    if kind == 2:
        turned = bytearray(honest)
        for _ in range(dice.randrange(1, 9)):
            turned[dice.randrange(len(turned))] ^= 1 << dice.randrange(8)
        return bytes(turned[: dice.randrange(1, len(turned) + 1)]) + dice.randbytes(dice.choice([0, 0, 1, 40]))
    return bytes([dice.choice([1, 2, 3, 4, 5, 6, 8, 9, 10, 11, *range(16, 21), dice.getrandbits(8)])]) + dice.randbytes(dice.randrange(120))


def main(key, ends, line, listen, connect, seconds, ask, mutate):
    peer = Peer(key, ends, line)
    wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    wire.bind(("127.0.0.1", listen))
    say = lambda datagram: wire.sendto(datagram, ("127.0.0.1", connect))
    dice = random.Random(mutate)
    seen = {"flows": 0, "mutated": 0, "replies": 0, "confirmed": False, "world": None, "computed": None, "objects": 0}
    parts = {}
    patience, end, beat, tick = time.monotonic() + 30, None, 0.0, 0
    while time.monotonic() < (end or patience):
        session = peer.session
        if time.monotonic() >= beat:
            beat, tick = time.monotonic() + PERIOD_S, tick + 8
            if not (session and session.confirmed):
                say(peer.greet(HELLO, peer.far if session else NONE))
            if session:
                say(peer.seal(struct.pack("<B3xQ", PROBE, now_us())))
            if session and session.confirmed and ask:
                topic = tick // 8 % 4
                say(peer.seal(struct.pack("<BBHBBBBfff", ASK, topic, 0, 0, 0, 7, 0, 0, 0, 0) + b"\xff\xff\xff\xff" + bytes(28)))
            elif session and session.confirmed:
                flow = struct.pack("<BBHIfffddI", FLOW, 1, 0, tick, 0, 0, 0, 0, 0, tick)
                say(peer.seal(flow))
                message = mutated(dice, tick, flow) if mutate else None
                # Who says goodbye is gone.
                if message and message[0] != GOODBYE:
                    seen["mutated"] += 1
                    say(peer.seal(message))
        wire.settimeout(max(beat - time.monotonic(), 0.0005))
        try:
            datagram = wire.recv(2048)
        except (TimeoutError, ConnectionError):
            continue
        if datagram[:1] == bytes([VERSION]) and datagram[1] in (HELLO, WELCOME):
            answer = peer.greeted(datagram)
            answer and say(answer)
            continue
        message = session and session.open(datagram)
        if not message:
            continue
        if session.confirmed and end is None:
            end = time.monotonic() + seconds
        kind = message[0]
        if kind == FLOW:
            seen["flows"] += 1
        elif kind == REPLY:
            seen["replies"] += 1
        elif kind == PART:
            parts[message[1], struct.unpack("<H", message[2:4])[0]] = message[16:]
            seen["world"] = number(message[8:16])
        elif kind == PROBE:
            (sent,) = struct.unpack("<Q", message[4:12])
            say(peer.seal(struct.pack("<B3xQQQ", REPLY, sent, now_us(), now_us())))
        elif kind == GOODBYE:
            break
    if peer.session:
        say(peer.seal(struct.pack("<B3x", GOODBYE)))
        seen["confirmed"] = peer.session.confirmed
    records = [part for (topic, _), part in sorted(parts.items()) if topic in (1, 3)]
    if records and all(number(record[-8:]) == number(derive(bytes(32), "record", record[:-8])) for record in records):
        seen["objects"] = sum(topic == 3 for topic, _ in parts)
        seen["computed"] = number(derive(bytes(32), "world", parts.get((0, 0), b"") + b"".join(records)))
    print(json.dumps(seen))


if __name__ == "__main__":
    told = json.loads(sys.argv[1])
    with open(told["key"]) as file:
        shared = bytes.fromhex(file.read().strip())
    main(shared, [told["from"], told["to"]], *(told[name] for name in ("line", "listen", "connect", "seconds", "ask", "mutate")))
