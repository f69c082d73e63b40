"""A scene like that of equations.c in MuJoCo: two devices and two copies on slides, springs and dampers between them, no delay. Argument: ticks."""

import sys
import time

import mujoco

ticks = int(sys.argv[1])
slide = '<body><joint type="slide" axis="1 0 0" name="{0}" damping="{1}"/><geom size="0.01" mass="{2}" contype="0" conaffinity="0"/></body>'
spring = '<fixed springlength="0" stiffness="{2}" damping="2"><joint joint="{0}" coef="1"/><joint joint="{1}" coef="-1"/></fixed>'
bodies = slide.format("h1", 1, 0.1) + slide.format("o1", 0, 0.02) + slide.format("o2", 0, 0.02) + slide.format("h2", 1, 0.1)
springs = spring.format("h1", "o1", 1000) + spring.format("o1", "o2", 1000) + spring.format("h2", "o2", 1000)
model = mujoco.MjModel.from_xml_string(
    f'<mujoco><option timestep="0.001" gravity="0 0 0"/><worldbody>{bodies}</worldbody><tendon>{springs}</tendon></mujoco>'
)
data = mujoco.MjData(model)
best = float("inf")
for _ in range(3):
    mujoco.mj_resetData(model, data)
    data.qfrc_applied[:] = [1.0, 0.0, 0.0, -1.0]
    start = time.process_time()
    # All steps in one call.
    mujoco.mj_step(model, data, ticks)
    best = min(best, time.process_time() - start)
print(1e-6 * ticks / best, data.qpos[2])
