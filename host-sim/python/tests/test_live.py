"""Live peers from Python: over loopback, in real time; each test takes seconds."""

import gc
import os
import pathlib
import signal
import socket
import subprocess
import sys
import textwrap
import threading
import time

import cohold
import pandas
import pytest

# A wall that a device which is asked 200 times a second can hold: its force stands for 5 ms.
SOFT = {"contact.stiffness_n_per_m": 100.0, "contact.damping_n_s_per_m": 0.5}


def ports(count=2):
    """Addresses on loopback that nobody has."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    found = ["127.0.0.1:{}".format(one.getsockname()[1]) for one in sockets]
    for one in sockets:
        one.close()
    return found


@pytest.fixture(name="line")
def _line(tmp_path):
    """What the two ends of a line are told, beside their scene."""
    key = tmp_path / "pair.key"
    cohold.generate_key(key)
    one, two = ports()
    return {"listen": one, "connect": two, "key": key}, {"listen": two, "connect": one, "key": key}


def until(is_so, timeout_s=20.0):
    by = time.monotonic() + timeout_s
    while not is_so():
        assert time.monotonic() < by, "it did not come to that"
        time.sleep(0.01)


def zero_for(peer, seconds):
    """Whether coordination pushes the copy with nothing at all for so long."""
    by = time.monotonic() + seconds
    while time.monotonic() < by:
        if abs(peer.state.coordination_force_n) > 1e-6:
            return False
        time.sleep(0.005)
    return True


class Handle:
    """A mass in a hand that holds it with a spring and a damper, in real time, as a slow device would have it."""

    name, axes, is_homed, lets_go_s = "a handle", 1, True, 0.02

    def __init__(self, held_at_m=0.0):
        self.held_at_m, self.position_m, self.velocity, self.force_n = held_at_m, 0.0, 0.0, 0.0
        self.forces, self.calls, self.then = [], [], time.perf_counter()

    def read(self):
        now = time.perf_counter()
        self.calls.append(now)
        while self.then < now:
            push = 200.0 * (self.held_at_m - self.position_m) - 20.0 * self.velocity + self.force_n
            self.velocity += 0.0005 / 0.2 * push
            self.position_m += 0.0005 * self.velocity
            self.then += 0.0005
        return (self.position_m,), (self.velocity,)

    def write(self, force_n):
        (self.force_n,) = force_n
        self.forces.append(self.force_n)


def test_two_peers_hold_one_object_and_a_recording_is_read_back(line, tmp_path, command_line):
    """1 N from each side: where statics say, in one process; what was recorded says the same."""
    record = tmp_path / "one.mcap"
    # Fingers that damp: the scene's own device alone swings for seconds.
    settings = {"device.damping_n_s_per_m": 5.0}
    with (
        cohold.LivePeer("any-network", 1, settings=settings, record=record, **line[0]) as one,
        cohold.LivePeer("any-network", 2, settings=settings, **line[1]) as two,
    ):
        assert one.wait_armed(20) and two.wait_armed(20)
        one.push(1.0)
        two.push(-1.0)
        time.sleep(3.0)
        states = [one.state, two.state]
        second, verdict = one.second, one.verdict
    stiffness = cohold.Scene("any-network")["contact.stiffness_n_per_m"]
    for state, sign in zip(states, (1.0, -1.0)):
        assert state.mode == "armed" and state.fault is None and state.tick > 1000
        # A force holds each hand where it pushes its copy.
        assert sign * state.force_n == pytest.approx(-1.0, abs=0.15)
        assert sign * (state.hand_m - state.object_m) == pytest.approx(1.0 / stiffness, rel=0.25)
        assert state.peer_m == pytest.approx(state.object_m, abs=1e-3)
    assert states[0].object_m == pytest.approx(states[1].object_m, abs=1e-3)
    assert second["state"] == "armed" and second["round_trip_us"] < 100_000
    assert verdict["stable"] is True and len(verdict["one_way_ms"]) == 2
    report = one.report
    assert report["fault"] is None and report["ticks"] >= states[0].tick and not one.running
    assert report["punctuality"]["beats"] > 2500 and report["true_discrepancy_mm"] < 1.0
    assert report["recorded"].endswith("one.mcap")
    # As a recording of the command is read.
    command_line("recording", "convert", record, tmp_path / "one.parquet")
    table = pandas.read_parquet(tmp_path / "one.parquet")
    assert len(table) > 2500
    # What Python saw is the very tick that was recorded.
    (row,) = table[(table["time_s"] - states[0].time_s).abs() < 1e-6].to_dict("records")
    seen = [states[0].hand_m, states[0].object_m, states[0].peer_m, states[0].contact_force_n, states[0].coordination_force_n]
    assert seen == [row[name] for name in ("device_m", "object_m", "decoded_m", "contact_n", "coordination_n")]


def test_it_waits_for_arm_and_lets_go_on_disarm(line):
    with (
        cohold.LivePeer({"object.mass_kg": 0.05}, 1, arm=False, **line[0]) as one,
        cohold.LivePeer({"object.mass_kg": 0.05}, 2, **line[1]) as two,
    ):
        assert not one.wait_armed(1.5) and one.state.mode == "held" and one.state.force_n == 0.0
        assert two.state.mode != "armed"
        one.arm()
        assert one.wait_armed(20) and two.wait_armed(20)
        one.push(2.0)
        until(lambda: one.state.force_n < -0.5)
        one.disarm()
        until(lambda: one.state.mode == "held" and one.state.force_n == 0.0, 1.0)
        one.push(0.0)
        one.arm()
        assert one.wait_armed(20)
        one.clutch = True
        assert one.clutch
        # Free of the shared world: nothing pushes back, however far the hand goes.
        until(lambda: one.state.force_n == 0.0, 1.0)
        one.push(0.2)
        by = time.monotonic() + 0.5
        while time.monotonic() < by:
            assert one.state.force_n == 0.0 and one.state.mode == "armed"


def test_a_hand_goes_where_it_is_told(line):
    """As places come 60 times a second: there with the object, and back against a hand that stays where it is."""
    with cohold.LivePeer("any-network", 1, **line[0]) as one, cohold.LivePeer("any-network", 2, **line[1]) as two:
        assert one.wait_armed(20) and two.wait_armed(20)
        for wrong in (float("nan"), -11.0, (0.0, 0.0)):
            with pytest.raises(ValueError, match="position.* is not allowed"):
                one.move_hand(wrong)
        seen = []
        for frame in range(120):
            one.move_hand(-0.05 * min(frame / 60, 1.0))
            seen.append(one.state.hand_m)
            time.sleep(1 / 60)
        assert seen[-1] == pytest.approx(-0.05, abs=1e-3)
        # At no time was there a jump.
        assert max(abs(later - sooner) for sooner, later in zip(seen, seen[1:])) < 0.01
        two.move_hand(two.state.hand_m)
        one.move_hand(0.02)
        until(lambda: one.state.force_n < -0.5 and two.state.force_n > 0.5, 5.0)
        one.move_hand(None)
        two.move_hand(None)
        time.sleep(0.5)
        assert one.state.fault is None and two.state.fault is None


OTHER = """
    import sys, time, cohold
    listen, connect, key = sys.argv[1:]
    peer = cohold.LivePeer("any-network", 2, listen=listen, connect=connect, key=key)
    assert peer.wait_armed(30)
    peer.push(-2.0)
    print("armed", flush=True)
    {then}
"""


def other(line, then):
    words = [line["listen"], line["connect"], str(line["key"])]
    code = textwrap.dedent(OTHER).replace("{then}", then)
    return subprocess.Popen([sys.executable, "-c", code, *words], stdout=subprocess.PIPE, text=True)


def test_the_other_process_is_killed_and_this_one_lets_go(line):
    child = other(line[1], "time.sleep(600)")
    try:
        with cohold.LivePeer("any-network", 1, **line[0]) as peer:
            assert child.stdout is not None and child.stdout.readline() == "armed\n"
            peer.push(2.0)
            until(lambda: abs(peer.state.coordination_force_n) > 1.0)
            os.kill(child.pid, signal.SIGKILL)
            # It carries on more and more slowly while nothing comes, until nothing is left.
            until(lambda: zero_for(peer, 0.5), cohold.Scene("any-network")["safety.fade_s"] + 2.0)
            assert peer.state.fault is None
            report = peer.stop()
        said = [said["notice"] for said in report["notices"]]
        assert "Fading" in said and "Lost" not in said, said
    finally:
        child.kill()
        child.wait()


@pytest.mark.parametrize("then", ["pass", "raise SystemError('this is the end')", "del peer; time.sleep(600)"])
def test_whatever_ends_the_other_says_goodbye(line, then):
    """The end of the process, an exception, the object's own end: the session ends within a second, not after a silence."""
    child = other(line[1], then)
    try:
        with cohold.LivePeer("any-network", 1, **line[0]) as peer:
            assert child.stdout is not None and child.stdout.readline() == "armed\n"
            until(lambda: zero_for(peer, 0.3), 3.0)
            report = peer.stop()
        said = [said["notice"] for said in report["notices"]]
        assert "Lost" in said and "Fading" not in said, said
    finally:
        child.kill()
        child.wait()


def test_a_device_in_python_is_held(line):
    one, two = Handle(), Handle()
    # A busy machine may keep Python from answering for longer than a hand should be left alone.
    busy = {"settings": SOFT, "device_silent_s": 0.2}
    with (
        cohold.LivePeer("any-network", 1, device=one, **busy, **line[0]) as left,
        cohold.LivePeer("any-network", 2, device=two, **busy, **line[1]) as right,
    ):
        assert left.wait_armed(20) and right.wait_armed(20), (left, right)
        one.held_at_m, two.held_at_m = 0.01, -0.01
        time.sleep(3.0)
        states = [left.state, right.state]
        calls = list(one.calls)
    # It is asked again 5 ms after it was asked, and 2 ms after it answered, or later. Python may be late to note a call: by less than what has passed
    # since the call before, so that any n calls in a row take 5 ms for each gap but the first, and 2 ms for that.
    soonest = min(later - sooner - 0.005 * (gaps - 1) for gaps in range(1, len(calls)) for sooner, later in zip(calls, calls[gaps:]))
    assert soonest > 0.002 - 1e-6 and len(calls) > 100
    assert [state.mode for state in states] == ["armed", "armed"], states
    # They push against each other: hands are held back, by springs of 200 N/m against walls of 100 N/m, each from its side.
    assert states[0].force_n < -0.2 and states[1].force_n > 0.2
    assert states[0].force_n == pytest.approx(-states[1].force_n, abs=0.3)
    assert left.report["device"]["name"] == "a handle" and left.report["device"]["round_trip"]
    # Whoever ends lets go first.
    assert one.forces[-1] == two.forces[-1] == 0.0


@pytest.mark.parametrize("how", ["raises", "hangs"])
def test_a_device_that_raises_or_hangs_lets_go(line, how):
    class Bad(Handle):
        bad = False

        def read(self):
            if self.bad and how == "raises":
                raise OSError("its cable is out")
            if self.bad:
                time.sleep(0.3)
            return super().read()

    bad = Bad()
    with (
        cohold.LivePeer("any-network", 1, settings=SOFT, device=bad, **line[0]) as one,
        cohold.LivePeer("any-network", 2, settings=SOFT, **line[1]) as two,
    ):
        assert one.wait_armed(20) and two.wait_armed(20)
        bad.held_at_m = 0.01
        two.push(-1.0)
        until(lambda: one.state.force_n < -0.2)
        bad.bad = True
        start = time.monotonic()
        until(lambda: one.state.fault is not None or not one.running, 1.0)
        assert time.monotonic() - start < 0.2 and one.state.force_n == 0.0
        assert one.wait(5.0)
        report = one.report
    assert ("fault 24" if how == "raises" else "fault 23") in report["fault"]
    assert ("OSError: its cable is out" in report["fault"]) == (how == "raises")
    assert bad.forces[-1] == 0.0


def test_an_exception_and_garbage_collection_let_go(line):
    with pytest.raises(ZeroDivisionError):
        with cohold.LivePeer("any-network", 1, **line[0]) as peer:
            1 / 0
    assert not peer.running
    # Its socket is free again, and nobody who does not hold it keeps it.
    peer = cohold.LivePeer("any-network", 1, **line[0])
    before = threading.active_count()
    del peer
    gc.collect()
    cohold.LivePeer("any-network", 1, **line[0]).close()
    assert threading.active_count() == before


def test_nobody_there_is_an_error_that_says_so(line):
    peer = cohold.LivePeer("any-network", 1, patience_s=0.5, **line[0])
    with pytest.raises(RuntimeError, match=f"nobody answered from {line[0]['connect']} within 0.5 s"):
        peer.wait(10)
    with pytest.raises(RuntimeError, match="nobody answered"):
        with peer:
            pass


def test_refusals(line, tmp_path):
    end = line[0]

    def refused(match, kind=ValueError, scene="any-network", number=1, **changed):
        with pytest.raises(kind, match=match):
            cohold.LivePeer(scene, number, **{**end, **changed})

    refused("number = 3 is not allowed", number=3)
    refused('listen = "here" is not allowed: it must be an address and a port', listen="here")
    refused("cannot read the key file", kind=OSError, key=tmp_path / "none.key")
    refused("seconds = -1 is not allowed", seconds=-1.0)
    refused("a recording ends in .mcap", record="run.csv")
    refused("object.mass_kg = -1 is not allowed", settings={"object.mass_kg": -1})
    refused("device_axes x,x,y is not allowed: three different ones", device="haply", device_axes="x,x,y")
    refused("colour is not known", colour="red")
    refused("has no method read", device=object())
    refused("cannot listen on", kind=OSError, listen="192.0.2.1:7001")

    class Unknown(Handle):
        lets_go_s = None

    refused("nobody knows how long a handle holds a force", device=Unknown(), settings=SOFT)
    with cohold.LivePeer("any-network", 1, device=Handle(), settings=SOFT, **end) as peer:
        with pytest.raises(ValueError, match="push is for a simulated device"):
            peer.push(1.0)
        with pytest.raises(ValueError, match="move_hand is for a simulated device"):
            peer.move_hand(0.0)


WRITTEN = """
    import sys, cohold

    class Nothing:
        name, sends, keys, reads, gains = "nothing", "motion", {}, (), ()
        def start(self, values, local):
            return local
        def receive(self, values, state, packet):
            return packet
        def couple(self, values, state, local, contact_force_n, age_ticks):
            return state, 0.0, state
        def send(self, values, state, local):
            return local

    cohold.add_law(Nothing())
    listen, connect, key = sys.argv[1:]
    cohold.LivePeer({"coordination.comm": "nothing"}, 1, listen=listen, connect=connect, key=key)
"""


def test_a_law_in_python_is_not_asked_in_a_tick(line):
    """In a process of its own, for a law is known for the life of one."""
    words = [line[0]["listen"], line[0]["connect"], str(line[0]["key"])]
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(WRITTEN), *words], capture_output=True, text=True, timeout=60)
    assert 'ValueError: coordination.comm = "nothing" is not allowed in a live peer' in done.stderr


def blocks():
    page = (pathlib.Path(__file__).parents[3] / "docs/guides/python.md").read_text()
    return [block.split("```")[0] for block in page.split("```python\n")[1:]]


def test_the_pages_two_peers_run(tmp_path):
    (code,) = [block for block in blocks() if "LivePeer(" in block]
    for port, free in zip(("127.0.0.1:7001", "127.0.0.1:7002"), ports()):
        assert code.count(port) == 2
        code = code.replace(port, free)
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "armed" in done.stdout and (tmp_path / "left.mcap").exists()


def test_the_pages_device_is_one(line, tmp_path):
    """As it stands there it is armed, and mypy takes it for a device."""
    (code,) = [block for block in blocks() if "class Handle" in block]
    file = tmp_path / "handle.py"
    file.write_text(
        f'{code}\nimport cohold\ncohold.LivePeer({{}}, 1, listen="", connect="", key="", device=Handle()).close()\n'
    )
    done = subprocess.run([sys.executable, "-m", "mypy", str(file)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    made: dict = {}
    exec(code, made)
    with cohold.LivePeer("any-network", 1, device=made["Handle"](), settings=SOFT, **line[0]) as peer:
        with cohold.LivePeer("any-network", 2, settings=SOFT, **line[1]):
            assert peer.wait_armed(20)
