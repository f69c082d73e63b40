"""The leader's end of a haptic line as a teleoperator of LeRobot's.

Its hand feels what the follower meets over the wire, 1000 times a second. LeRobot's `send_feedback`, which its loops call for one robot only and
60 times a second, is not used.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

from lerobot.teleoperators import Teleoperator
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError
from lerobot_robot_haptic.end import AXES, End, along

from .config_haptic_leader import HapticLeaderConfig


class HapticLeader(Teleoperator):
    """Peer 1 of a haptic scene. Actions along each shared axis, of the shared world: `x.pos` (m) is where its hand is, and `x.force` (N) what
    that hand feels. Of a leader that is far they are what the robot's peer knows: where the leader's copy of the object is, as the line has it, and the
    force with which the line holds it there.
    """

    config_class = HapticLeaderConfig
    name = "haptic_leader"

    def __init__(self, config: HapticLeaderConfig) -> None:
        super().__init__(config)
        self.config = config
        self.end = End(config, f"{self.name} {config.id}" if config.id else self.name)
        self._is_far_connected = False

    @cached_property
    def action_features(self) -> dict[str, Any]:
        return {f"{axis}.{word}": float for word in ("pos", "force") for axis in AXES[: self.end.axes]}

    @property
    def feedback_features(self) -> dict[str, Any]:
        return {}

    @property
    def is_connected(self) -> bool:
        return self.end.peer is not None or self._is_far_connected

    @property
    def is_calibrated(self) -> bool:
        return True

    def connect(self, calibrate: bool = True) -> None:
        """Holds the peer, which arms when the other end is there; the first action waits for that."""
        if self._is_far_connected:
            raise DeviceAlreadyConnectedError(f"{self.end.name} is connected already")
        if self.config.at == "far":
            self._is_far_connected = True
        else:
            self.end.open(1)
        self.configure()

    def calibrate(self) -> None:
        """Nothing to do: a device is homed before it is armed, and says so itself."""

    def configure(self) -> None:
        """Nothing to do: the scene is what it is told, and both ends compare it before they arm."""

    def get_action(self) -> dict[str, Any]:
        if self._is_far_connected:
            return self._far()
        state = self.end.state()
        return {**along(self.end.axes, state.hand_m, "pos"), **along(self.end.axes, state.force_n, "force")}

    def _far(self) -> dict[str, Any]:
        ends = End.of_robots
        if len(ends) != 1:
            must = "a leader that is far is known by the one haptic_follower of this process"
            raise DeviceNotConnectedError(f"{self.end.name} is not known: {must}, and {len(ends)} are connected")
        (robot,) = ends
        state, second = robot.state(), robot.held().second
        # Of a whole second in which both ends were armed.
        if second is not None and second["done_s"] >= 1.0 and not second["live_share"]:
            raise DeviceNotConnectedError(f"{self.end.name} is gone: nothing has come from {robot.config.connect} for a second")
        pulled = along(robot.axes, state.coordination_force_n, "force")
        return {**along(robot.axes, state.peer_m, "pos"), **{key: -force for key, force in pulled.items()}}

    def send_feedback(self, feedback: dict[str, Any]) -> None:
        """Nothing to do: the hand feels the follower already."""

    def disconnect(self) -> None:
        """Turns the motors off, tells the other end, and lets go."""
        if self._is_far_connected:
            self._is_far_connected = False
            return
        self.end.held()
        self.end.close()
