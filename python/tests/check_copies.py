"""Copies, pickles and snapshots of environments go on as the environments do. Run by tests/python.rs."""

import copy
import dataclasses
import os
import pathlib
import pickle
import subprocess
import sys
import tempfile
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
    for other in (again, copy.copy(flight), copy.deepcopy(flight)):
        assert other == flight and other in [flight] and not other != flight
    assert flight != hopper.run("hard", "mdp", 3) and flight != "flight"


#: A mission of rovers.
ROVERS = """
[truth.terrain.obstacles]
width_cells = {width}
height_cells = 12
cell_size_m = 1.0
percent = 10.0
seed = {seed}

[brief]
profile = "hopper"

{robots}
"""

#: One of them.
ROVER = """
[[robots]]
body = "rover"
start = [{}, 0]
heading = "north"
speed_mps = 1.0
"""


def rovers(seed=0, width=12, count=2):
    return ROVERS.format(seed=seed, width=width, robots="".join(ROVER.format(11 * number) for number in range(count)))


def model(rise=0.3):
    x, y = np.meshgrid(np.arange(30), np.arange(20))
    rows = 2 + rise * np.sin(x / 3.0)
    header = "ncols 30\nnrows 20\nxllcorner 500000\nyllcorner 4000000\ncellsize 1\nNODATA_value -9999\n"
    return header + "\n".join(" ".join(f"{height:.4f}" for height in row) for row in rows)


def flown(env):
    """Identity, seed and actions of a mission that goes on from here."""
    for action in [1, 2, 1, 3, 2]:
        env.step(action)
    return dataclasses.astuple(env.snapshot())[:3]


def files():
    """Environments stay on the ground that they were made with, whatever becomes of the file and of the working folder."""
    home = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        os.mkdir("other")
        scenario, dem = pathlib.Path("mine.toml"), pathlib.Path("dem.asc")
        scenario.write_text(rovers())
        dem.write_text(model())
        env = hopper.pettingzoo.env(scenario="mine.toml")
        env.reset(seed=1)
        env.step(1)
        snapshot, shape, digest = env.snapshot(), env.observation_space("robot_0").shape, hopper.run("mine.toml", seed=4).digest
        kept, planes = pickle.dumps(env), env.observe("robot_1")
        for change in [rovers(seed=5), rovers(width=15), rovers(count=1), "", None]:
            scenario.unlink() if change is None else scenario.write_text(change)
            os.chdir("other")
            for other in (env, copy.deepcopy(env), pickle.loads(kept)):
                other.restore(snapshot)
                assert other.snapshot() == snapshot and equal(other.observe("robot_1"), planes), "other ground"
                expected = flown(env) if other is env else expected
                assert other is env or flown(other) == expected
                other.reset(seed=2)
                assert other.observe("robot_1").shape == shape and other.snapshot().scenario == snapshot.scenario
            os.chdir("..")
        scenario.write_text(rovers(seed=5))
        strange = hopper.pettingzoo.env(scenario="mine.toml")
        strange.reset(seed=1)
        try:
            strange.restore(snapshot)
        except hopper.HopperError as error:
            assert "a snapshot needs to be of this scenario" in str(error), error
        else:
            raise AssertionError("a snapshot of other ground needs to be refused")
        scenario.write_text(rovers())
        assert hopper.run("mine.toml", seed=4).digest == digest

        env = gymnasium.make("hopper.gym:PlanetaryHopper-v1", dem="dem.asc")
        many = gymnasium.make_vec("PlanetaryHopper-v1", num_envs=2, dem="dem.asc")
        env.reset(seed=1), many.reset(seed=1)
        env.step(1), many.step(np.array([1, 2]))
        expected = env.unwrapped.digest()
        pathlib.Path("env").write_bytes(pickle.dumps((env, many)))
        read = "import pickle, sys; env, many = pickle.load(open(sys.argv[1], 'rb')); env.step(2); print(env.unwrapped.digest())"
        env.step(2)
        os.chdir("other")
        again = subprocess.run([sys.executable, "-c", read, "../env"], capture_output=True, text=True)
        assert again.stdout.strip() == env.unwrapped.digest(), again.stderr
        copy.deepcopy(env).reset(seed=2)
        os.chdir("..")
        for change, text in [(model(0.2), "a file that it names has changed"), (None, "dem.asc")]:
            dem.unlink() if change is None else dem.write_text(change)
            assert copy.deepcopy(env).unwrapped.digest() == env.unwrapped.digest()
            try:
                pickle.loads(pathlib.Path("env").read_bytes())
            except hopper.HopperError as error:
                assert text in str(error), error
            else:
                raise AssertionError("another elevation model needs to be refused")
        os.chdir(home)


def every_scenario():
    """A scenario is pickled as it was read."""
    for name in ["hard", "heterogeneous", "treasures", "hills"]:
        env = hopper.gym.HopperEnv(scenario=name)
        env.reset(seed=1)
        assert pickle.loads(pickle.dumps(env)).snapshot() == env.snapshot()
    for name in ["coverage", "coverage-8"]:
        env = hopper.pettingzoo.env(scenario=name, profile="hopper")
        env.reset(seed=1)
        assert pickle.loads(pickle.dumps(env)).snapshot() == env.snapshot()


for use in (Gym(single, ()), Gym(many, (3,)), Rovers(), Parallel()):
    copies(use), snapshots(use)
    print(type(use).__name__, file=sys.stderr, flush=True)
ended()
flights()
files()
every_scenario()
print("{}")
