"""Copies, pickles and snapshots of environments go on as the environments do. Run by tests/python.rs."""

import copy
import dataclasses
import pickle
import sys
import warnings

import gymnasium
import numpy as np

import hopper
import hopper.gym
import hopper.pettingzoo

warnings.simplefilter("error")


def equal(one, other):
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(equal(one[name], other[name]) for name in one)
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(equal, one, other))
    return np.array_equal(one, other)


def single():
    return gymnasium.make("hopper.gym:PlanetaryHopper-v1", scenario="treasures")


def many():
    return gymnasium.make_vec("hopper.gym:PlanetaryHopper-v1", num_envs=3, vectorization_mode="vector_entry_point", scenario="sandy")


class Gym:
    """How an environment of gymnasium is used."""

    def __init__(self, make, shape):
        self.make, self.shape = make, shape

    def actions(self, count, seed):
        return list(np.random.default_rng(seed).integers(5, size=(count, *self.shape)))

    def go(self, env, actions):
        trace = []
        for action in actions:
            trace.append(env.step(action if self.shape else int(action)))
            if not self.shape and (trace[-1][2] or trace[-1][3]):
                # The next mission is drawn by the copied generator.
                trace.append(env.reset())
        return trace

    def digests(self, env):
        return [env.unwrapped.digest(index) for index in range(3)] if self.shape else env.unwrapped.digest()


class Rovers:
    """How an environment of pettingzoo is used."""

    make = staticmethod(hopper.pettingzoo.env)

    def actions(self, count, seed):
        return [int(action) for action in np.random.default_rng(seed).integers(5, size=count)]

    def go(self, env, actions):
        trace = []
        for action in actions:
            env.step(action)
            trace.append((env.last()[:4], env.agent_selection, dict(env.rewards), env.observe("robot_1")))
        return trace

    def digests(self, env):
        return dataclasses.astuple(env.snapshot())[:3]


class Parallel(Rovers):
    make = staticmethod(hopper.pettingzoo.parallel_env)

    def go(self, env, actions):
        return [env.step(dict.fromkeys(env.agents, action)) for action in actions]


def copies(use):
    for copied in (copy.copy, copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))):
        if copied is copy.copy and isinstance(use, Gym) and not use.shape:
            # gymnasium's wrappers share what they wrap.
            copied = lambda env: copy.copy(env.unwrapped)
        env = use.make()
        copied(env)
        env.reset(seed=5)
        use.go(env, use.actions(20, 1))
        other, before = copied(env), use.digests(env)
        assert use.digests(other) == before
        ahead, others_ahead = use.actions(60, 2), use.actions(7, 3)
        use.go(copied(env), others_ahead)
        assert use.digests(env) == before, "a copy moves nothing but itself"
        expected = use.go(env, ahead)
        assert use.digests(other) == before
        assert equal(use.go(other, ahead), expected) and use.digests(other) == use.digests(env)
        copied(other).close()
        use.go(other, others_ahead)


def snapshots(use):
    env, other = use.make(), use.make()
    env.reset(seed=6), other.reset(seed=99)
    inner, others_inner = getattr(env, "unwrapped", env), getattr(other, "unwrapped", other)
    if isinstance(use, Parallel):
        inner, others_inner = env, other
    use.go(env, use.actions(15, 1))
    snapshot, before = pickle.loads(pickle.dumps(inner.snapshot())), use.digests(env)
    assert snapshot == inner.snapshot()
    ahead = use.actions(60, 2)
    expected = use.go(env, ahead)
    for _ in range(2):
        inner.restore(snapshot)
        assert use.digests(env) == before and inner.snapshot() == snapshot
        assert equal(use.go(env, ahead), expected)
    others_inner.restore(snapshot)
    assert equal(use.go(other, ahead), expected)
    env.close()


def ended():
    """Environments whose mission is over are copied as well."""
    env = single()
    env.reset(seed=1)
    while not any(env.step(4)[2:4]):
        pass
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert other.unwrapped.digest() == env.unwrapped.digest()
        try:
            other.step(1)
        except gymnasium.error.ResetNeeded:
            other.reset(seed=2)
            other.step(1)
        else:
            raise AssertionError("a mission that is over needs a reset")
    env = hopper.pettingzoo.env()
    env.reset(seed=1)
    while not any(env.terminations.values()) and not any(env.truncations.values()):
        env.step(0)
    snapshot = env.snapshot()
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert other.flight().digest == env.flight().digest
        while other.agents:
            other.step(None)
        other.restore(snapshot)
        assert other.agents and other.flight().digest == env.flight().digest


def flights():
    flight = hopper.run("hard", "mdp", 2)
    again = pickle.loads(pickle.dumps(flight))
    assert again.digest == flight.digest and again._repr_svg_() == flight._repr_svg_() and equal(again.rows, flight.rows)
    assert copy.deepcopy(flight).digest == flight.digest


for use in (Gym(single, ()), Gym(many, (3,)), Rovers(), Parallel()):
    copies(use), snapshots(use)
    print(type(use).__name__, file=sys.stderr, flush=True)
ended()
flights()
print("{}")
