"""What LeRobot is told of the teleoperator: `--teleop.type=haptic_leader --teleop.key=… `."""

from __future__ import annotations

from dataclasses import dataclass

from lerobot.teleoperators import TeleoperatorConfig
from lerobot_robot_haptic.end import EndConfig

# Where the leader's device is.
PLACES = ("here", "far")


@TeleoperatorConfig.register_subclass("haptic_leader")
@dataclass(kw_only=True)
class HapticLeaderConfig(EndConfig, TeleoperatorConfig):
    listen: str = "127.0.0.1:7701"
    connect: str = "127.0.0.1:7702"
    # "here": at this machine, and this process holds its peer. "far": at another one, whose `cohold peer --number 1` holds it; what it does
    # is what the robot's peer hears of it, and nothing else here is asked for but the scene.
    at: str = "here"

    def __post_init__(self) -> None:
        if self.at not in PLACES:
            raise ValueError(f'at = "{self.at}" is not allowed: it must be "here" or "far"')
