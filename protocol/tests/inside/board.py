"""A board's operator port in another language, from FORMAT.md alone, with nothing to install (sessions: peer.py; lease.py, lines.py; cryptography: rfc.py).

    python3 board.py '{"key": "FILE", "number": 2, "manner": "honest", "drops": [], "lease_s": 0.2}'

It listens on loopback, runs its side of the lease, and answers lines. Ticks are sent at most 125 times a second. Manners, other than honest:

    deaf    motors that run alone stay on after a stop, and it says so: it has not heard the stop
    stuck   the same, but it says that it has heard the stop
    stale   the same, but after a stop it says "off" with the number of an older word
    late    when the first stop arrives, its path is cut, both ways: the stop is lost, and motors that run alone stay on

"drops" are lengths of datagrams, and 0 is all: once its motors have been on, the path loses what it sends with such a length.
SIGUSR1 makes board and path honest again.
Says on standard error how far it is. After SIGINT it prints what it did, as JSON; times are ms since it started.
"""

import json
import os
import signal
import socket
import struct
import sys

from lease import ALONE, LEASED, NAMES, OFF, RUN, Lease, ms, say
from lines import ACK, EVENT, Lines
from peer import GOODBYE, LIFE_US, NINE, PROBE, REPLY, SEALED, VERSION, Peer, now_us
from rfc import derive, x25519

SAMPLE, PERIOD_US = 9, 20_000
GETS = {"timing.control_period_s": "0.001", "axis.shared": "1"}


def text(words):
    return struct.pack("<I", len(words)) + words.encode()


TABLE = derive(bytes(32), "table", text("operator") + text("version") + b"n" + struct.pack("<d", 2.0))[:6]
TABLES = b"\1" + bytes(7) + TABLE + bytes(90)


class Board(Peer):
    def __init__(self, key, number, manner, drops, lease_s):
        super().__init__(key, [number, 0], 0)
        self.tables = TABLES
        self.lease, self.lines = Lease(round(1e6 * lease_s)), Lines(self.speak, self.hear)
        self.manner, self.drops, self.is_cut, self.been_on, self.stop = manner, drops, False, False, None
        self.beat = self.tick = self.until = self.every = 0
        self.told = {"motors": self.lease.turns, "stops": [], "runs": [], "lines": [], "refused": 0, "ticks": 0, "lost": 0}
        self.wire, self.to = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), None
        self.wire.bind(("127.0.0.1", 0))
        self.wire.settimeout(0.002)

    def heal(self, *_):
        self.manner, self.drops, self.is_cut, self.stop = "honest", [], False, None
        say("honest again")

    def send(self, datagram):
        if self.is_cut or self.been_on and (len(datagram) in self.drops or 0 in self.drops):
            self.told["lost"] += 1
        else:
            self.wire.sendto(datagram, self.to)

    def speak(self, message):
        """Seals it with what is said of the motors, and the number of the newest word of this operator, if he has said one."""
        own = self.session.confirmed and self.session.theirs[:8] == self.lease.operator
        number, motors = self.lease.word >> 2 if own else 0, self.lease.motors
        if self.stop is not None:
            number = self.stop >> 2 if self.manner == "stuck" else number
            motors = OFF if self.manner == "stale" else motors
        self.send(self.seal(message, number << 2 | motors))

    def receive(self, datagram, source):
        if len(datagram) == 200 and datagram[0] == VERSION and datagram[1] < SEALED:
            answer, self.to = self.greeted(datagram), source
            assert self.tables == TABLES, "both ends have the table that FORMAT.md names"
            answer and self.send(answer)
            return
        session = self.session
        before = session and (session.newest, session.confirmed)
        message = session and session.open(datagram)
        if not session or session.newest == before[0]:
            self.told["refused"] += 1
            return
        self.to = source
        if session.confirmed and not before[1]:
            # Whoever comes next has another ephemeral, and challenges of before are good no more.
            self.secret, self.good, self.offered_us = os.urandom(32), {}, 0
            self.ephemeral, self.every = x25519(self.secret, NINE), 0
            self.lines.begin(session.theirs[:8])
        if session.confirmed and self.heeds(session.lease):
            self.lease.hear(session.theirs[:8], session.lease, session.echo)
        if message and not self.is_cut:
            self.take(message)

    def heeds(self, word):
        """Puts down a stop or a run. Each manner but one ignores a stop of what runs alone."""
        if word & 3 == RUN:
            self.told["runs"].append([ms(), word >> 2])
        if not word & 1:
            return True
        self.told["stops"].append([ms(), word >> 2])
        if self.manner == "honest" or self.lease.motors != ALONE:
            return True
        if self.stop is None:
            say(f"ignores the stop: {self.manner}")
        self.stop, self.is_cut = word, self.manner == "late"
        return False

    def take(self, message):
        kind = message[0]
        if kind == PROBE:
            self.speak(struct.pack("<B3xQQQ", REPLY, struct.unpack("<Q", message[4:12])[0], now_us(), now_us()))
        elif kind == GOODBYE:
            self.session = None
        elif kind == ACK:
            self.lines.acknowledged(message)
        elif kind == EVENT:
            self.lines.event(message, self.session)

    def hear(self, line, word):
        """The answer to a line. Whoever ignores stops answers `disarm` all the same."""
        (first, rest), answer = (line.split(maxsplit=1) + ["", ""])[:2], f"ok {line}"
        if first == "disarm":
            self.manner == "honest" and self.lease.turn(OFF, line)
            answer = "ok disarmed"
        elif first in ("arm", "check"):
            refused = self.lease.start(word, ALONE if rest == "alone" else LEASED, line)
            answer = f"error {refused}" if refused else answer.replace("arm", "armed")
            self.until = now_us() + 300_000 if first == "check" and not refused else self.until
        elif first == "stream":
            self.every = 0 if rest == "off" else max(8, int(rest))
        elif first == "get":
            answer = f"ok {rest} = {GETS[rest]}" if rest in GETS else "error there is no such key"
        elif first == "status":
            answer = f"ok board {self.ends[0]} {NAMES[self.lease.motors]}"
        self.told["lines"].append([ms(), line, answer])
        say(f"line {line}: {answer}")
        return answer

    def look(self):
        """Time passes."""
        now, session = now_us(), self.session
        if self.until and now >= self.until:
            self.until = 0
            self.lease.turn(OFF, "the check is over")
        self.lease.look()
        self.been_on |= self.lease.motors != OFF
        if session and now >= session.fresh_us + (12 * PERIOD_US if session.confirmed else LIFE_US):
            self.session = session = None
        if session and now >= self.beat:
            self.beat = now + PERIOD_US
            self.speak(struct.pack("<B3xQ", PROBE, now))
        session and session.confirmed and self.lines.again()
        if session and session.confirmed and self.every and ms() >= self.tick + self.every:
            self.tick, on = ms(), self.lease.motors != OFF
            self.told["ticks"] += 1
            self.speak(struct.pack("<BBH", SAMPLE, 108, 1) + struct.pack("<I8xBBBB", self.tick, on, 0, on, 0) + bytes(92))


def main(key, *told):
    board, asked = Board(key, *told), []
    signal.signal(signal.SIGINT, lambda *_: asked.append("to end"))
    signal.signal(signal.SIGUSR1, board.heal)
    say(f"listens on 127.0.0.1:{board.wire.getsockname()[1]}")
    while not asked and ms() < 120_000:
        try:
            datagram, source = board.wire.recvfrom(2048)
        except (TimeoutError, ConnectionError):
            pass
        else:
            board.is_cut or board.receive(datagram, source)
        board.look()
    print(json.dumps(board.told))


if __name__ == "__main__":
    told = json.loads(sys.argv[1])
    with open(told["key"]) as file:
        shared = bytes.fromhex(file.read().split()[-1])
    main(shared, *(told[name] for name in ("number", "manner", "drops", "lease_s")))
