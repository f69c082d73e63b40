"""One end of a haptic line as LeRobot holds it, robot or teleoperator: a `cohold.LivePeer`, read by key.

Places and forces are of the shared world, in SI units. What cannot be told as it is raises: a reading is never an old one.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import cohold
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

# Names of the shared axes, first to last.
AXES = ("x", "y", "z")
# A peer ticks every millisecond. One that stands still for so long is not there.
OLD_S = 0.5


@dataclass(kw_only=True)
class EndConfig:
    """What an end is told; the same words as `cohold peer` and `cohold.LivePeer`."""

    # Where this end listens and where the other one does, as 192.168.1.12:7701.
    listen: str = "127.0.0.1:7702"
    connect: str = "127.0.0.1:7701"
    # The file with the key that both ends have.
    key: str = ""
    # A built-in scene, or a file; the same at both ends.
    scene: str = "leader-follower"
    # Keys of the scene that differ from it.
    settings: dict[str, Any] = field(default_factory=dict)
    # What is attached, as --device takes it, and what else is told of it: device_axes, device_lets_go_s, …
    device: str = "simulated"
    device_settings: dict[str, Any] = field(default_factory=dict)
    # A recording of every tick beside LeRobot's own at 60 Hz: a file that ends in .mcap.
    record: str | None = None
    # How long a follower's connection, and a leader's first reading, wait until both ends are armed, s.
    wait_s: float = 30.0


def along(axes: int, numbers: float | tuple[float, ...], word: str) -> dict[str, float]:
    """A quantity along the shared axes by key: `x.pos`, …"""
    several = (numbers,) if isinstance(numbers, float) else numbers
    return {f"{axis}.{word}": number for axis, number in zip(AXES[:axes], several, strict=True)}


def places(axes: int, action: Mapping[str, Any]) -> tuple[float, ...]:
    """Where an action wants the hand along each axis, m."""
    wanted = []
    for key in (f"{axis}.pos" for axis in AXES[:axes]):
        if key not in action:
            raise ValueError(f"the action has no {key}: it must have {', '.join(f'{axis}.pos' for axis in AXES[:axes])}, in m")
        wanted.append(float(action[key]))
        if not math.isfinite(wanted[-1]):
            raise ValueError(f"{key} = {wanted[-1]} is not allowed in an action: it must be a number, in m")
    return tuple(wanted)


class End:
    """A peer, from its connection to its end."""

    # Connected ends of robots in this process, for a teleoperator that is on another machine.
    of_robots: list[End] = []

    def __init__(self, config: EndConfig, name: str) -> None:
        self.config, self.name = config, name
        self.axes = int(cohold.Scene(config.scene, config.settings)["axis.shared"])
        self.peer: cohold.LivePeer | None = None
        self._was_armed = False
        self._newest = (-1.0, 0.0)

    def open(self, number: int, **changed: Any) -> None:
        """Holds a peer, which arms as soon as the other end is there; does not wait for that."""
        if self.peer is not None:
            raise DeviceAlreadyConnectedError(f"{self.name} is connected already")
        config = self.config
        told: dict[str, Any] = {
            "listen": config.listen,
            "connect": config.connect,
            "key": config.key,
            "device": config.device,
            "record": config.record,
            "settings": config.settings,
            "patience_s": config.wait_s,
            **config.device_settings,
            **changed,
        }
        self._was_armed, self._newest = False, (-1.0, 0.0)
        self.peer = cohold.LivePeer(config.scene, number, **told)

    def held(self) -> cohold.LivePeer:
        """The peer, if it is connected."""
        if self.peer is None:
            raise DeviceNotConnectedError(f"{self.name} is not connected: call connect() first")
        return self.peer

    def state(self) -> cohold.LiveState:
        """Its newest tick. The first time it waits until both ends are armed."""
        peer = self.held()
        if not self._was_armed:
            self._wait(peer)
        state = peer.state
        if state.fault is not None:
            raise DeviceNotConnectedError(f"{self.name} has stopped, its motors are off: {state.fault}")
        if not peer.running:
            raise DeviceNotConnectedError(f"{self.name} has stopped, its motors are off: {_why(peer)}")
        if state.mode != "armed":
            raise DeviceNotConnectedError(f"{self.name} is armed no more: its peer is {state.mode}")
        now = time.monotonic()
        if state.time_s != self._newest[0]:
            self._newest = (state.time_s, now)
        elif now - self._newest[1] > OLD_S:
            old_s = now - self._newest[1]
            raise DeviceNotConnectedError(f"{self.name} stands still: its newest tick is {old_s:.1f} s old")
        return state

    def _wait(self, peer: cohold.LivePeer) -> None:
        try:
            self._was_armed = peer.wait_armed(self.config.wait_s)
        except RuntimeError as error:
            raise DeviceNotConnectedError(f"{self.name} has stopped: {error}") from error
        if not self._was_armed:
            verdict = peer.verdict
            said = f": {verdict['text']}" if peer.state.mode == "refused" and verdict else ""
            reason = f"after {self.config.wait_s:g} s its peer is {peer.state.mode}{said}"
            raise DeviceNotConnectedError(f"{self.name} is not armed: {_why(peer) if not peer.running else reason}")

    def close(self) -> None:
        """Turns the motors off, tells the other end, and lets go."""
        peer, self.peer = self.peer, None
        if peer is not None:
            peer.disarm()
            peer.close()


def _why(peer: cohold.LivePeer) -> str:
    """Why a peer has ended."""
    try:
        report = peer.report
    except (RuntimeError, OSError) as error:
        return str(error)
    return str((report or {}).get("fault") or "it was told to stop")
