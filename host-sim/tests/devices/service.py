"""Haply's service for an Inverse3 that goes wrong, from RFC 6455 and the messages in the vendor's documentation alone, with nothing to install.

    python3 service.py '{"wrong": "unasked"}'

Listens on loopback and says where on standard error. It serves one client: lists its devices, then answers each message with one state. "reach" on standard
input moves the hand by 20 mm within a second. "go wrong" makes it:

    unasked   it says each state twice
    hidden    the same, with a ping before each state
    frozen    it says one state again and again, in which the device moves at 0.2 m/s

It ends when its client has gone, or three seconds after it went wrong, and prints what was asked of it since then, as JSON.
"""

import base64
import gc
import hashlib
import json
import os
import socket
import struct
import sys
import threading
import time

TEXT, CLOSE, PING = 1, 8, 9
FOR_S, MOVES_M_PER_S, REACH_M = 3.0, 0.2, 0.02


def say(words):
    print(words, file=sys.stderr, flush=True)


def frame(kind, data):
    """One whole message of a server's: not masked (RFC 6455, 5.2)."""
    length = bytes([len(data)]) if len(data) < 126 else b"\x7e" + struct.pack(">H", len(data))
    return bytes([0x80 | kind]) + length + data


class Client:
    """The other end of the WebSocket."""

    def __init__(self, wire):
        self.wire, self.came = wire, b""
        wire.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        while b"\r\n\r\n" not in self.came:
            self.came += wire.recv(4096)
        head, self.came = self.came.split(b"\r\n\r\n", 1)
        fields = (line.split(b":", 1) for line in head.split(b"\r\n")[1:])
        fields = {name.lower(): value.strip() for name, value in fields}
        key = fields[b"sec-websocket-key"] + b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
        accepts = base64.b64encode(hashlib.sha1(key).digest())
        upgrade = b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        wire.sendall(upgrade + b"Sec-WebSocket-Accept: " + accepts + b"\r\n\r\n")

    def messages(self):
        """What comes within a millisecond, each of one masked frame; ends with the line."""
        self.wire.settimeout(0.001)
        try:
            more = self.wire.recv(65536)
        except (TimeoutError, BlockingIOError):
            return
        if not more:
            raise ConnectionError("the client has gone")
        self.came += more
        while len(self.came) >= 6:
            kind, length, at = self.came[0] & 15, self.came[1] & 127, 2
            if length == 126:
                length, at = struct.unpack(">H", self.came[2:4])[0], 4
            if len(self.came) < at + 4 + length:
                return
            mask, data = self.came[at : at + 4] * (length // 4 + 1), self.came[at + 4 : at + 4 + length]
            self.came = self.came[at + 4 + length :]
            if kind == CLOSE:
                raise ConnectionError("the client has closed the line")
            if kind == TEXT:
                yield json.loads(bytes(one ^ other for one, other in zip(data, mask)))

    def send(self, frames):
        self.wire.settimeout(2)
        self.wire.sendall(frames)


class Device:
    """A hand that no force moves."""

    def __init__(self):
        self.reaches_s, self.force = None, [0.0] * 3

    def motion(self, now):
        """Of least jerk."""
        share = 0.0 if self.reaches_s is None else min(now - self.reaches_s, 1.0)
        place = REACH_M * share**3 * (10 - 15 * share + 6 * share**2)
        return place, 30 * REACH_M * share**2 * (1 - share) ** 2

    def state(self, now, moves=None):
        place, speed = self.motion(now)
        xyz = lambda x, y=0.0, z=0.0: {"x": x, "y": y, "z": z}
        state = {
            "cursor_position": xyz(place),
            "cursor_velocity": xyz(speed if moves is None else moves),
            "current_cursor_force": xyz(*self.force),
            "control_domain": "cartesian",
            "control_mode": "force",
            "mode": "force_control",
        }
        status = {"calibrated": True, "in_use": True, "power_supply": True, "ready": True}
        told = {"session_id": 7, "inverse3": [{"device_id": "049D", "state": state, "status": status}]}
        told |= {"verse_grip": [], "wireless_verse_grip": []}
        return frame(TEXT, json.dumps(told).encode())


def main(wrong):
    orders = []
    threading.Thread(target=lambda: orders.extend(line.strip() for line in sys.stdin), daemon=True).start()
    listens = socket.create_server(("127.0.0.1", 0))
    say(f"listens on 127.0.0.1:{listens.getsockname()[1]}")
    listens.settimeout(60)
    client, device = Client(listens.accept()[0]), Device()
    # A device has a processor of its own, where the system gives it one.
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
    except (AttributeError, OSError):
        pass
    gc.disable()
    client.send(device.state(time.monotonic()))
    # When each state was made that the client reads one after the other, one for each message of its own.
    made, asked, frozen, wrong_s = [], 0, None, None
    told = {"most_before_n": 0.0, "asked": 0, "pushes": 0, "last_push_s": 0.0, "oldest_s": 0.0, "oldest_before_s": 0.0, "gone": False}
    patience = time.monotonic() + 60
    while time.monotonic() < (patience if wrong_s is None else wrong_s + FOR_S):
        for order in [orders.pop(0) for _ in orders[:1]]:
            now = time.monotonic()
            if order == "reach":
                device.reaches_s = now
            elif order == "go wrong":
                wrong_s = now
                frozen = device.state(now, MOVES_M_PER_S)
        try:
            for heard in client.messages():
                now = time.monotonic()
                vector = heard.get("inverse3", [{}])[0].get("commands", {}).get("set_cursor_force", {}).get("vector")
                device.force = [vector[axis] for axis in "xyz"] if vector else device.force
                pushes = any(device.force)
                # Whoever pushes has read an answer to each earlier message.
                age_s = now - made[asked - 1] if asked else 0.0
                asked += 1
                if wrong_s is None:
                    told["most_before_n"] = max(told["most_before_n"], -device.force[0])
                    told["oldest_before_s"] = max(told["oldest_before_s"], age_s * pushes)
                else:
                    told["asked"] += 1
                if wrong_s is not None and pushes:
                    told["pushes"] += 1
                    told["last_push_s"], told["oldest_s"] = now - wrong_s, max(told["oldest_s"], age_s)
                if wrong_s is None or wrong == "none":
                    made.append(now)
                    client.send(device.state(now))
                elif wrong == "frozen":
                    made.append(wrong_s)
                    client.send(frozen)
                else:
                    made += [now, now]
                    ping = frame(PING, b"") if wrong == "hidden" else b""
                    client.send((device.state(now) + ping) * 2)
        except ConnectionError:
            told["gone"] = True
            break
    print(json.dumps(told))


if __name__ == "__main__":
    main(json.loads(sys.argv[1])["wrong"])
