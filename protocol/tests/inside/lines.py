"""Events and lines of text, from FORMAT.md alone: for board.py, whose session (peer.py) they are of."""

import struct

from peer import now_us

EVENT, ACK, MORE, END = 3, 4, 1, 2
LINE_US, AGAIN_US = 500_000, 60_000


class Lines:
    """`speak` seals a message, `answer` gives the answer to a line that was said under a word."""

    def __init__(self, speak, answer):
        self.speak, self.answer, self.operator = speak, answer, b""
        self.next, self.early, self.number, self.under_way, self.half = 0, {}, 0, {}, b""

    def begin(self, operator):
        """A session. Events begin again if it is with another incarnation."""
        if operator != self.operator:
            self.operator, self.next, self.early, self.number, self.under_way = operator, 0, {}, 0, {}
        self.half = b""

    def acknowledged(self, message):
        upto, ahead = struct.unpack("<II", message[4:12])
        has = lambda beyond: beyond < 0 or 1 <= beyond <= 32 and ahead >> beyond - 1 & 1
        self.under_way = {number: waits for number, waits in self.under_way.items() if not has(number - upto)}

    def event(self, message, session):
        length, code, number = struct.unpack("<BHI", message[1:8])
        if 0 <= number - self.next < 8:
            self.early[number] = (code, message[8 : 8 + length])
        while self.next in self.early:
            self.next += 1
            self.part(*self.early.pop(self.next - 1), session)
        ahead = sum(1 << at for at in range(32) if self.next + 1 + at in self.early)
        self.speak(struct.pack("<B3xII", ACK, self.next, ahead))

    def part(self, code, payload, session):
        if code == MORE:
            self.half += payload
        elif code == END:
            line, self.half = (self.half + payload[8:]).decode(), b""
            token, word = int.from_bytes(payload[:7], "little"), payload[7]
            is_new = session.began <= token <= now_us() <= token + LINE_US
            self.say(self.answer(line, word) if is_new else "error this line is too old", session)

    def say(self, line, session):
        rest = line.encode()
        while len(rest) > 40:
            self.put(MORE, rest[:48])
            rest = rest[48:]
        self.put(END, session.stamp.to_bytes(7, "little") + b"\0" + rest)

    def put(self, code, payload):
        self.under_way[self.number] = [struct.pack("<BBHI", EVENT, len(payload), code, self.number) + payload, 0]
        self.number += 1

    def again(self):
        """Of those under way, the first eight that are due."""
        for waits in list(self.under_way.values())[:8]:
            if now_us() >= waits[1]:
                waits[1] = now_us() + AGAIN_US
                self.speak(waits[0])
