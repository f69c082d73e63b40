"""What LeRobot is told of the robot: `--robot.type=haptic_follower --robot.key=… `."""

from __future__ import annotations

from dataclasses import dataclass, field

from lerobot.cameras import CameraConfig
from lerobot.robots import RobotConfig

from .end import EndConfig

# Who moves the follower.
LEADERS = ("wire", "actions")


@RobotConfig.register_subclass("haptic_follower")
@dataclass(kw_only=True)
class HapticFollowerConfig(EndConfig, RobotConfig):
    # "wire": the leader at the other end, 1000 times a second, and LeRobot's actions are what was done. "actions": LeRobot's own, as in a
    # replay: a simulated leader here takes the follower where they say, and `listen`, `connect` and `key` are not asked for.
    led_by: str = "wire"
    cameras: dict[str, CameraConfig] = field(default_factory=dict)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.led_by not in LEADERS:
            raise ValueError(f'led_by = "{self.led_by}" is not allowed: it must be "wire" or "actions"')
