"""A board's side of the lease, from FORMAT.md alone: for board.py. What an operator's end wants is a byte in each of its datagrams."""

import sys

from peer import now_us

OFF, LEASED, ALONE = 0, 1, 2
NAMES = ["off", "leased", "alone"]
RUN = 2
START_US = now_us()


def ms():
    return (now_us() - START_US) // 1000


def say(words):
    print(words, file=sys.stderr, flush=True)


class Lease:
    """The three rules. Each turn of the motors is put down: when, to what, and why."""

    def __init__(self, lease_us):
        self.lease_us = lease_us
        self.motors, self.turns, self.operator, self.run = OFF, [], None, None
        self.word, self.echo, self.used = 0, 0, False

    def turn(self, motors, why):
        if motors != self.motors:
            self.motors = motors
            self.turns.append([ms(), NAMES[motors], why])
            say(f"motors {NAMES[motors]}: {why}")

    def hear(self, operator, word, echo):
        if (operator, word) != (self.operator, self.word):
            self.operator, self.word, self.echo, self.used = operator, word, 0, False
        self.echo = max(self.echo, echo)
        if word & 1:
            self.turn(OFF, "stop")

    def fresh(self):
        return now_us() < self.echo + self.lease_us

    def start(self, word, motors, line):
        """Why the line is refused, if it is."""
        if word != self.word or word & 3 != RUN:
            return "nobody lets it run"
        if not self.fresh() or self.used or self.motors != OFF:
            return "this run is too old, has started before, or motors are on"
        self.used, self.run = True, (self.operator, word)
        self.turn(motors, line)
        return None

    def look(self):
        if self.motors == LEASED and self.run != (self.operator, self.word):
            self.turn(OFF, "another word")
        if self.motors == LEASED and not self.fresh():
            self.turn(OFF, "lease")
