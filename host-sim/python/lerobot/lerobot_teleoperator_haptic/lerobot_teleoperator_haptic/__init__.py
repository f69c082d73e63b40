"""LeRobot's teleoperator `haptic_leader`: the near end of a haptic line, whose hand feels what the follower meets (docs/guides/lerobot.md)."""

from .config_haptic_leader import HapticLeaderConfig
from .haptic_leader import HapticLeader

__all__ = ["HapticLeader", "HapticLeaderConfig"]
