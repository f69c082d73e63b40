"""LeRobot's robot `haptic_follower`: the far end of a haptic line, whose peer moves it and feels for it 1000 times a second (docs/guides/lerobot.md)."""

from .config_haptic_follower import HapticFollowerConfig
from .haptic_follower import HapticFollower

__all__ = ["HapticFollower", "HapticFollowerConfig"]
