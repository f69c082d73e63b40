"""Two devices that MuJoCo simulates, each under a peer, hold one object over a network of one's own.

    python mujoco_device.py          # needs `pip install mujoco`

Each device is a handle of 0.1 kg on a slide in a model of its own, pushed toward the other one with 1 N. A peer's tick is a step of MuJoCo:
place and speed go in, a force comes out. Packets go from one to the other here, 8 ms late, and some are lost.
"""

import random
from collections import deque

import cohold
import mujoco

HANDLE = """
<mujoco>
  <option timestep="0.001" gravity="0 0 0" integrator="implicit"/>
  <worldbody>
    <body>
      <joint name="slide" type="slide" axis="1 0 0" damping="1"/>
      <geom type="sphere" size="0.02" mass="0.1" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
</mujoco>
"""
DELAY_TICKS = 8
LOSS = 0.1


class Handle:
    """A device of MuJoCo's."""

    def __init__(self, push_n: float):
        self.model = mujoco.MjModel.from_xml_string(HANDLE)
        self.data = mujoco.MjData(self.model)
        self.push_n = push_n

    @property
    def position_m(self) -> float:
        return float(self.data.qpos[0])

    @property
    def velocity_m_per_s(self) -> float:
        return float(self.data.qvel[0])

    def step(self, force_n: float) -> None:
        self.data.qfrc_applied[0] = force_n + self.push_n
        mujoco.mj_step(self.model, self.data)


def main() -> None:
    scene = cohold.Scene("any-network")
    peers = [cohold.Peer(scene, number) for number in (1, 2)]
    handles = [Handle(1.0), Handle(-1.0)]
    under_way: list[deque[tuple[int, tuple[float, ...]]]] = [deque(), deque()]
    lost = random.Random(1)
    for tick in range(10_000):
        for at, (peer, handle) in enumerate(zip(peers, handles)):
            # What the other peer sent, if it is there by now.
            line, packet = under_way[1 - at], None
            while line and line[0][0] <= tick:
                packet = line.popleft()[1]
            force_n, sent = peer.tick(handle.position_m, handle.velocity_m_per_s, packet)
            if sent is not None and lost.random() >= LOSS:
                under_way[at].append((tick + DELAY_TICKS, sent))
            handle.step(force_n)
            if peer.fault:
                raise SystemExit(f"peer {at + 1} stopped: {peer.fault}")
    for number, (peer, handle) in enumerate(zip(peers, handles), 1):
        print(f"peer {number}: object at {1e3 * peer.object_m:.3f} mm, handle at {1e3 * handle.position_m:.3f} mm")
    print(f"apart: {1e3 * abs(peers[0].object_m - peers[1].object_m):.3f} mm")


if __name__ == "__main__":
    main()
