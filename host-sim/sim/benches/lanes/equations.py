"""The equations of equations.c with NumPy, stacked: one array element a scene. Arguments: number type, scenes, ticks."""

import sys
import time

import numpy as np

real, scenes, ticks = np.dtype(sys.argv[1]).type, int(sys.argv[2]), int(sys.argv[3])
T = 0.001
keep_v = np.exp(-1.0 * T / 0.1)
to_x, gain_v = 0.1 * (1 - keep_v), 1 - keep_v
gain_x = T - to_x
angle = 2 * np.pi * 60 * T
keep, take = real(np.exp(-angle)), real(-np.expm1(-angle))
root, velocity_to_wave, force_to_wave = real(np.sqrt(80.0)), real(np.sqrt(20.0)), real(1 / np.sqrt(80.0))
period, gain, contact_k, contact_b, damping = real(T), real(T / 0.02), real(1000), real(2), real(2)
most, step = real(40), real(20)
stiffness = (1e5 * (0.2 + 0.04 * (np.arange(scenes) % 16))).astype(real)
inverse_loop = (1 / (40.0 + 2.0 + 1e5 * (0.2 + 0.04 * (np.arange(scenes) % 16)) * T)).astype(real)


class Peer:
    """Every result goes into a place that is there already."""

    def __init__(self):
        self.x_h, self.v_h, self.motor, self.pushed, self.wide = (np.zeros(scenes) for _ in range(5))
        rows = (np.zeros(scenes, real) for _ in range(9))
        self.x_o, self.v_o, self.carry_o, self.x_d, self.carry_d, self.y, self.u_in, self.sent, self.force = rows
        self.a, self.b, self.contact, self.v_d, self.coordination = (np.zeros(scenes, real) for _ in range(5))

    def sum(self, total, carry, term):
        """total + term, with the carry of Kahan's sum."""
        a, b = self.a, self.b
        np.subtract(term, carry, out=a)
        np.add(total, a, out=b)
        np.subtract(b, total, out=carry)
        np.subtract(carry, a, out=carry)
        total[:] = b

    def tick(self, push):
        a, b, contact, v_d, coordination = self.a, self.b, self.contact, self.v_d, self.coordination
        a[:] = self.x_h
        np.subtract(a, self.x_o, out=contact)
        np.multiply(contact, contact_k, out=contact)
        a[:] = self.v_h
        np.subtract(a, self.v_o, out=a)
        np.multiply(a, contact_b, out=a)
        np.add(contact, a, out=contact)
        np.subtract(self.x_d, self.x_o, out=a)
        np.multiply(stiffness, a, out=a)
        np.multiply(self.u_in, root, out=v_d)
        np.subtract(v_d, a, out=v_d)
        np.multiply(self.v_o, damping, out=a)
        np.add(v_d, a, out=v_d)
        np.multiply(v_d, inverse_loop, out=v_d)
        np.multiply(v_d, period, out=coordination)
        self.sum(self.x_d, self.carry_d, coordination)
        np.subtract(self.x_d, self.x_o, out=coordination)
        np.multiply(stiffness, coordination, out=coordination)
        np.subtract(v_d, self.v_o, out=a)
        np.multiply(a, damping, out=a)
        np.add(coordination, a, out=coordination)
        np.multiply(v_d, velocity_to_wave, out=a)
        np.multiply(coordination, force_to_wave, out=b)
        np.subtract(a, b, out=a)
        np.multiply(a, take, out=a)
        np.multiply(self.y, keep, out=self.y)
        np.add(self.y, a, out=self.y)
        np.add(contact, coordination, out=a)
        np.multiply(a, gain, out=a)
        np.add(self.v_o, a, out=self.v_o)
        np.multiply(self.v_o, period, out=v_d)
        self.sum(self.x_o, self.carry_o, v_d)
        np.negative(contact, out=a)
        np.clip(a, -most, most, out=a)
        np.subtract(a, self.force, out=a)
        np.clip(a, -step, step, out=a)
        np.add(self.force, a, out=self.force)
        pushed, wide = self.pushed, self.wide
        np.add(self.motor, push, out=pushed)
        np.multiply(self.v_h, to_x, out=wide)
        np.add(self.x_h, wide, out=self.x_h)
        np.multiply(pushed, gain_x, out=wide)
        np.add(self.x_h, wide, out=self.x_h)
        np.multiply(self.v_h, keep_v, out=self.v_h)
        np.multiply(pushed, gain_v, out=wide)
        np.add(self.v_h, wide, out=self.v_h)
        self.motor[:] = self.force


best = np.inf
for _ in range(3):
    one, two = Peer(), Peer()
    start = time.process_time()
    for n in range(ticks):
        if n % 8 == 0:
            if n > 0:
                one.u_in[:], two.u_in[:] = two.sent, one.sent
            one.sent[:], two.sent[:] = one.y, two.y
        one.tick(1.0)
        two.tick(-(1.0 + 0.25 * np.sin(3.0 * (n * T))))
    best = min(best, time.process_time() - start)
print(1e-6 * ticks * scenes / best, float(two.x_o[0]))
