"""One peer alone, with a device and a network from Python: what two of them do is what a pair does."""

import copy
import math
from collections import deque

import cohold
import pytest

SCENE = "paper-5.2-passive-wave-16ms"
PERIOD_S = 0.001


class Handle:
    """A mass and a damper under forces toward +x, by semi-implicit Euler."""

    def __init__(self, mass_kg=0.1, damping_n_s_per_m=1.0):
        self.mass_kg, self.damping = mass_kg, damping_n_s_per_m
        self.position_m = self.velocity = 0.0

    def step(self, force_n):
        self.velocity += PERIOD_S / self.mass_kg * (force_n - self.damping * self.velocity)
        self.position_m += PERIOD_S * self.velocity


class Line:
    """Carries packets, each as late as the other."""

    def __init__(self, ticks):
        self.ticks, self.under_way = ticks, deque()

    def carry(self, now, packet):
        if packet is not None:
            self.under_way.append((now + self.ticks, packet))
        return self.under_way.popleft()[1] if self.under_way and self.under_way[0][0] <= now else None


def run(scene, pushes, ticks, scalar="f64"):
    peers = [cohold.Peer(scene, number, scalar) for number in (1, 2)]
    handles, lines, came = [Handle(), Handle()], [Line(8), Line(8)], [None, None]
    for now in range(ticks):
        sent = [None, None]
        for at in (0, 1):
            force, sent[at] = peers[at].tick(handles[at].position_m, handles[at].velocity, came[at])
            handles[at].step(force + pushes[at])
        # What is sent in a period arrives before one eight later at the soonest.
        came = [lines[1].carry(now + 1, sent[1]), lines[0].carry(now + 1, sent[0])]
    return peers, handles


def test_two_peers_come_to_rest_where_statics_say():
    """1 N from each side: copies are F/K_T apart as each believes, hands F/K_LC into their copies."""
    scene = cohold.Scene(SCENE)
    peers, handles = run(scene, (1.0, -1.0), 20_000)
    assert [peer.fault for peer in peers] == [None, None] and all(peer.engaged for peer in peers)
    assert all(abs(handle.velocity) < 1e-6 for handle in handles)
    contact = scene["contact.stiffness_n_per_m"]
    for peer, handle, sign in zip(peers, handles, (1.0, -1.0)):
        assert sign * (handle.position_m - peer.object_m) == pytest.approx(1.0 / contact, rel=1e-3)
    # Squeezed together: peer 1's copy goes further than peer 2's.
    assert peers[0].object_m > peers[1].object_m


@pytest.mark.parametrize("scalar", ["f32", "f64", "i32f32"])
def test_a_copy_is_a_saved_state(scalar):
    scene = cohold.Scene(SCENE)
    peer = cohold.Peer(scene, 1, scalar)
    places = [0.001 * math.sin(0.01 * tick) for tick in range(400)]

    def go_on(peer, packet=None):
        return [peer.tick(place, 0.0, packet) for place in places]

    once = go_on(peer)
    saved = copy.copy(peer)
    then, hash_then = go_on(peer), peer.state_hash()
    assert go_on(saved) == then and saved.state_hash() == hash_then
    peer.reset()
    assert peer.ticks == 0 and go_on(peer) == once


def test_packets_are_numbers_with_names():
    peer = cohold.Peer(cohold.Scene(SCENE), 1)
    _, packet = peer.tick(0.0, 0.0)
    assert len(packet) == len(peer.PACKET) == 6
    # The next is due eight ticks later.
    assert [peer.tick(0.0, 0.0)[1] is None for _ in range(8)] == [True] * 7 + [False]


def test_several_axes():
    peer = cohold.Peer(cohold.Scene("space"), 2)
    force, packet = peer.tick((0.001, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert len(force) == 3 and len(packet) == 3 and len(packet[0]) == 6
    peer.tick([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], packet)
    with pytest.raises(ValueError, match="position_m = 0.001 is not allowed: it must have shape"):
        peer.tick(0.001, 0.0)
    with pytest.raises(ValueError, match="packet is not allowed: it must have a tuple of 3"):
        peer.tick([0.0] * 3, [0.0] * 3, packet[:2])


def test_what_is_no_number_stops_it():
    scene = cohold.Scene(SCENE)
    for hand, packet in (((math.nan, 0.0), None), ((0.0, 0.0), (math.nan,) * 6)):
        peer = cohold.Peer(scene, 1)
        peer.tick(0.0, 0.0)
        force, _ = peer.tick(*hand, packet)
        assert force == 0.0 and peer.fault is not None and not peer.engaged


def test_refusals():
    scene = cohold.Scene(SCENE)
    with pytest.raises(ValueError, match="number = 3 is not allowed: it must be 1 or 2"):
        cohold.Peer(scene, 3)
    with pytest.raises(ValueError, match="packet is not allowed: it must have 6 numbers"):
        cohold.Peer(scene, 1).tick(0.0, 0.0, (1.0, 2.0))
