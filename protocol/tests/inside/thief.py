"""Whoever attacks a meeting of two homes, from FORMAT.md ("Meetings") alone, with nothing to install (cryptography: rfc.py).

    python3 thief.py '{"attack": "thief", "link": "haptic://HOST:PORT/..."}'
    python3 thief.py '{"attack": "onlooker", "place": "127.0.0.1:PORT"}'

The thief has read a link that nobody has used. He agrees with the inviter, then sits where the inviter sits and answers whoever comes with the link.
The onlooker has no link. He is the network between both ends and the meeting place, passes everything on, and attacks with the joins that he saw.

Each says on standard error how far he is, and at the end prints what he gained, as JSON.
"""

import collections
import json
import os
import selectors
import signal
import socket
import sys
import time

from rfc import derive, x25519

JOIN, WELCOME, SIGNAL, AGREEMENT, SEALED = 0xF1, 0xF2, 0xF3, 0xF4, 4
OFFER, ANSWER, REFUSAL = 1, 2, 3
SEATED, OTHER, NO_SEAT = 1, 2, 4
NONE, NINE = bytes(16), bytes([9]) + bytes(31)
LETTERS = "abcdefghijklmnopqrstuvwxyz234567"


def say(words):
    print(words, file=sys.stderr, flush=True)


def pair(key):
    secret = derive(key, "pair")
    return secret, x25519(secret, NINE)


def name(public):
    return derive(public, "seat")[:16]


def code(key):
    number = int.from_bytes(derive(key, "code")[:8], "little") % 1_000_000
    return f"{number // 1000:03} {number % 1000:03}"


def read_link(link):
    """The key of a link, and the place's address."""
    place, letters = link.removeprefix("haptic://").split("/")
    bits = "".join(f"{LETTERS.index(letter):05b}" for letter in letters)
    assert len(bits) == 145 and bits[144] == "0", bits
    told = int(bits[:144], 2).to_bytes(18, "big")
    key = told[:16] + bytes(16)
    assert told[16:] == derive(key, "link", place.encode())[:2], "the check of the link"
    return key, address(place)


def address(text):
    host, port = text.rsplit(":", 1)
    return host, int(port)


def open_socket(last):
    """On loopback; with a host of its own where the system has more than one there, as each host has only so many proofs."""
    wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        wire.bind((f"127.0.0.{last}", 0))
    except OSError:
        wire.bind(("127.0.0.1", 0))
    wire.setblocking(False)
    return wire


def came(wire):
    """All that has come, and from where."""
    while True:
        try:
            yield wire.recvfrom(2048)
        except BlockingIOError:
            return
        except ConnectionError:
            continue


def join(side, public, other, cookie=NONE, proof=NONE):
    return bytes([JOIN, side]) + public + other + cookie + proof + os.urandom(8)


def read_welcome(datagram):
    """Bits, cookie, the place's public key."""
    assert len(datagram) == 76 and datagram[0] == WELCOME, datagram.hex()
    return datagram[1], datagram[2:18], datagram[18:50]


class Seat:
    """One seat of a room whose key is known."""

    def __init__(self, wire, place, side, key=None, mine=None, other=None):
        seats = [pair(derive(key, "seat", bytes([at]))) for at in (0, 1)] if key else None
        self.wire, self.place, self.side = wire, place, side
        self.secret, self.public = mine or seats[side]
        self.other = other or name(seats[1 - side][1])
        self.cookie, self.proof, self.agreed, self.bits = NONE, NONE, None, 0

    def ask(self):
        self.wire.sendto(join(self.side, self.public, self.other, self.cookie, self.proof), self.place)

    def hear(self, datagram):
        """Takes a welcome in; asks again at once with a proof if there is something new to prove."""
        self.bits, cookie, place = read_welcome(datagram)
        here = self.wire.getsockname()
        seen = bytes.fromhex("00000000000000000000ffff") + socket.inet_aton(here[0])
        assert datagram[58:76] == here[1].to_bytes(2, "little") + seen, "the address that the place sees"
        new = cookie != self.cookie
        if new:
            self.agreed = self.agreed or x25519(self.secret, place)
            self.cookie, self.proof = cookie, derive(self.agreed, "proof", cookie)[:16]
        if new and not self.bits & SEATED:
            self.ask()


def sits(seat):
    """Takes the seat."""
    end = time.monotonic() + 10
    while time.monotonic() < end:
        seat.ask()
        time.sleep(0.02)
        for datagram, _ in came(seat.wire):
            if datagram[0] == WELCOME:
                seat.hear(datagram)
        if seat.bits & SEATED:
            return
    sys.exit("whoever has the key of a seat takes it")


def offer(key, public):
    return bytes([AGREEMENT, OFFER]) + public + derive(key, "agreement", b"\x01" + public)[:16]


def answer(key, agreed, mine, theirs):
    masked = bytes(one ^ other for one, other in zip(mine, derive(key, "mask", theirs)))
    return bytes([AGREEMENT, ANSWER]) + masked + derive(agreed, "agreement", b"\x02" + mine)[:16]


def shared_key(key, product, accepts, invites):
    return derive(key, "agreed", product + accepts + invites)


def thief(link):
    key, place = read_link(link)
    wire = open_socket(66)
    seats = [Seat(wire, place, side, key) for side in (0, 1)]
    secret, accepts = pair(os.urandom(32))

    # To the inviter he is whoever was invited.
    sits(seats[1])
    got, end = None, time.monotonic() + 10
    while got is None and time.monotonic() < end:
        seats[1].ask()
        wire.sendto(offer(key, accepts), place)
        time.sleep(0.05)
        for datagram, _ in came(wire):
            if datagram[:2] == bytes([AGREEMENT, ANSWER]):
                got = datagram
    assert got, "the inviter answers the first right offer"
    invites = bytes(one ^ other for one, other in zip(got[2:34], derive(key, "mask", accepts)))
    assert derive(invites, "invite")[:16] == key[:16], "the link commits the inviter to this key"
    agreed = shared_key(key, x25519(secret, invites), accepts, invites)
    assert got == answer(key, agreed, invites, accepts), "the answer is the inviter's"
    say(f"agreed with the inviter: {code(agreed)}")

    # To whoever was invited he is to be the inviter. Both have the key of this seat, so he asks for it again and again.
    sits(seats[0])
    say("sits where the inviter sat")
    own_secret, own = pair(os.urandom(32))
    told = {"code": code(agreed), "offers": 0, "sent": collections.Counter(), "others": 0, "reads": 0}
    known = {}
    answered, end, beat = False, time.monotonic() + 12, 0.0
    while time.monotonic() < end:
        if time.monotonic() >= beat:
            beat = time.monotonic() + 0.02
            seats[0].ask()
        time.sleep(0.002)
        for datagram, _ in came(wire):
            if datagram[0] == WELCOME:
                seats[0].hear(datagram)
                continue
            if datagram[0] in (SEALED, SIGNAL):
                told["reads"] += 1
                continue
            if datagram == got:
                # Offers of his that crossed the answer are answered again.
                continue
            theirs = datagram[2:34]
            if len(datagram) != 50 or datagram != offer(key, theirs) or theirs == accepts:
                told["others"] += 1
                continue
            told["offers"] += 1
            if theirs not in known:
                # With his own pair he makes a key that he knows; with the inviter's public key, products that he can make.
                his = shared_key(key, x25519(own_secret, theirs), theirs, own)
                guess = shared_key(key, x25519(own_secret, theirs), theirs, invites)
                reused = shared_key(key, x25519(secret, invites), theirs, invites)
                known[theirs] = {
                    "replayed": got,
                    "his own": answer(key, his, own, theirs),
                    "his product, the inviter's key": answer(key, guess, invites, theirs),
                    "the product of before": answer(key, reused, invites, theirs),
                    "the key of before": answer(key, agreed, invites, theirs),
                    "the inviter's tag": answer(key, agreed, invites, theirs)[:34] + got[34:],
                    "no key": answer(key, shared_key(key, bytes(32), theirs, bytes(32)), bytes(32), theirs),
                }
            for how, bytes_ in known[theirs].items():
                wire.sendto(bytes_, place)
                told["sent"][how] += 1
            if told["offers"] >= 10 and not answered:
                answered = True
                say("has answered all offers")
                end = time.monotonic() + 2
    print(json.dumps(told))


class Onlooker:
    """The network between the ends and the place: passes everything on, and remembers the joins."""

    def __init__(self, place):
        self.place, self.outside, self.inside = place, open_socket(1), {}
        self.ready = selectors.DefaultSelector()
        self.ready.register(self.outside, selectors.EVENT_READ, None)
        # The newest join of each seat, by side and public key.
        self.joins, self.seen, self.passed = {}, 0, 0

    def pass_on(self, wait_s, first):
        """What waits; `first` is called with the first join of each seat before that is passed on."""
        for key, _ in self.ready.select(wait_s):
            for datagram, source in came(key.fileobj):
                if key.data is not None:
                    self.outside.sendto(datagram, key.data)
                    continue
                if source not in self.inside:
                    self.inside[source] = open_socket(1)
                    self.ready.register(self.inside[source], selectors.EVENT_READ, source)
                if len(datagram) == 90 and datagram[0] == JOIN:
                    seat, self.seen = (datagram[1], datagram[2:34]), self.seen + 1
                    if seat not in self.joins:
                        first(datagram)
                    self.joins[seat] = datagram
                self.passed += datagram[0] == SEALED
                self.inside[source].sendto(datagram, self.place)


class Stranger:
    """An address of the onlooker's."""

    def __init__(self, last, place):
        self.wire, self.place, self.cookie, self.bits, self.others = open_socket(last), place, NONE, [], 0
        self.own = pair(os.urandom(32))

    def send(self, datagram):
        self.wire.sendto(datagram, self.place)

    def hear(self):
        for datagram, _ in came(self.wire):
            if datagram[0] == WELCOME:
                bits, self.cookie, _ = read_welcome(datagram)
                self.bits.append(bits)
            else:
                self.others += 1

    def attacks(self, seen):
        """What can be made of a join that was seen, at this address."""
        side, public, other, proof, nonce = seen[1:2], seen[2:34], seen[34:50], seen[66:82], seen[82:]
        there, cookie, free = bytes([JOIN]), self.cookie, bytes([1 - seen[1]])
        return {
            "as it was": seen,
            "own cookie": there + side + public + other + cookie + proof + nonce,
            "no proof": there + side + public + other + cookie + NONE + nonce,
            "random proof": there + side + public + other + cookie + os.urandom(16) + nonce,
            "own secret": there + side + public + other + cookie + derive(self.own[0], "proof", cookie)[:16] + nonce,
            "public key as product": there + side + public + other + cookie + derive(public, "proof", cookie)[:16] + nonce,
            # The free seat. Only its name is known, until somebody asks for it.
            "free seat, this key": there + free + public + name(public) + cookie + proof + nonce,
            "free seat, its name as key": there + free + other + bytes(16) + name(public) + cookie + proof + nonce,
            "free seat, own key": there + free + self.own[1] + name(public) + cookie + os.urandom(16) + nonce,
        }


def onlooker(place):
    network = Onlooker(address(place))
    # A host may send 20 proofs each second. Eight hosts stay below that.
    strangers = [Stranger(last, network.place) for last in range(2, 10)]
    beat_s = 0.01 if strangers[0].wire.getsockname()[0] == "127.0.0.2" else 0.1
    tried, before, live, beat, turns, todo = collections.Counter(), 0, 0, 0.0, 0, []
    # He may sit in a room of his own, made of an own pair and of the name of a seat that he saw. Nobody else is there.
    own, alone = None, {"seated": False, "other": False, "others": 0}

    def first(datagram):
        """He is the network: his own joins for a seat are there before the one that he saw."""
        for stranger in strangers:
            stranger.hear()
            tried["first"] += 1
            stranger.send(stranger.attacks(datagram)["own cookie"])

    say(f"between: 127.0.0.1:{network.outside.getsockname()[1]}")
    end, asked = time.monotonic() + 60, []
    signal.signal(signal.SIGINT, lambda *_: asked.append("to end"))
    while time.monotonic() < end and not asked:
        network.pass_on(0.002, first)
        if time.monotonic() < beat or not network.joins:
            continue
        beat, turns = time.monotonic() + beat_s, turns + 1
        stranger = strangers[turns % len(strangers)]
        stranger.hear()
        # Each kind for each seat, the newest join of it.
        todo = todo or [(seat, how) for seat in network.joins for how in stranger.attacks(network.joins[seat])]
        seat, how = todo.pop(0)
        stranger.send(stranger.attacks(network.joins[seat])[how])
        tried[how] += 1
        before, live = before + (len(network.joins) == 1 and stranger.cookie != NONE), live + (network.passed > 0)
        if before == 40 and len(network.joins) == 1:
            say("has tried to take the free seat")
            before += 1
        own = own or Seat(open_socket(10), network.place, 1 - seat[0], mine=pair(os.urandom(32)), other=name(seat[1]))
        if turns % 8 == 0:
            own.ask()
        for datagram, _ in came(own.wire):
            if datagram[0] == WELCOME:
                own.hear(datagram)
                alone["seated"] |= bool(own.bits & SEATED)
                alone["other"] |= bool(own.bits & OTHER)
            else:
                alone["others"] += 1
    bits = [bits for stranger in strangers for bits in stranger.bits]
    told = {"tried": tried, "live": live, "seats_seen": len(network.joins), "joins_seen": network.seen, "passed": network.passed}
    told |= {"welcomes": len(bits), "seated": sum(one & SEATED for one in bits), "refused": sum(one == NO_SEAT for one in bits)}
    told |= {"others": sum(stranger.others for stranger in strangers), "own_room": alone}
    print(json.dumps(told))


if __name__ == "__main__":
    told = json.loads(sys.argv[1])
    thief(told["link"]) if told["attack"] == "thief" else onlooker(told["place"])
