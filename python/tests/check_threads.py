"""Everything works in any thread, made anywhere, and in forked children. Run by tests/python.rs."""

import gc
import multiprocessing
import os
import signal
import sys
import threading
import warnings
from concurrent.futures import ThreadPoolExecutor

import gymnasium
import numpy as np

import hopper
import hopper.gym
import hopper.pettingzoo

warnings.simplefilter("error")
warnings.filterwarnings("ignore", ".*fork.*", DeprecationWarning)
# What hangs has failed.
signal.alarm(300)

sys.path.insert(0, sys.argv[1])
from planner_python import MyPlanner

world = hopper.World(np.eye(8), np.eye(8, dtype=bool), np.zeros((8, 8), bool))


def flown(env):
    """The digest of a mission, flown by a fixed rule."""
    env.reset(seed=3)
    for action in [1, 2, 1, 2, 2, 1, 2]:
        env.step(action)
    return env.unwrapped.digest()


def stepped(env):
    env.reset(seed=3)
    for action in [1, 2, 1]:
        env.step(np.full(4, action))
    return tuple(env.unwrapped.digest(index) for index in range(4))


def driven(env):
    env.reset(seed=3)
    for action in [1, 2, 1, 3, 0, 2] * 3:
        env.step(action)
    return env.snapshot().actions, env.observe("robot_0").sum(), env.agent_selection


cases = [
    (lambda: gymnasium.make("PlanetaryHopper-v1"), flown),
    (lambda: gymnasium.make_vec("PlanetaryHopper-v1", num_envs=4, vectorization_mode="vector_entry_point"), stepped),
    (hopper.pettingzoo.env, driven),
    (lambda: None, lambda _: hopper.run("hard", "mdp", 2).digest),
    (lambda: None, lambda _: hopper.run("hopper-scout", seed=2).digest),
    (MyPlanner, lambda planner: hopper.run("hard", planner, 2).digest),
    (lambda: None, lambda _: hopper.solve(world).values.sum()),
    (lambda: MyPlanner, hopper.check),
]


def threads():
    for make, use in cases:
        expected = use(make())
        made_here = make()
        with ThreadPoolExecutor(1) as other:
            assert other.submit(use, made_here).result() == expected
            made_there = other.submit(make).result()
            assert use(made_there) == expected
            # And dropped by a third thread.
            held = [made_there]
            del made_there
            dropper = threading.Thread(target=held.clear)
            dropper.start(), dropper.join()
        with ThreadPoolExecutor(4) as pool:
            assert set(pool.map(lambda _: use(make()), range(8))) == {expected}
    gc.collect()


def shared():
    """One environment in several threads at once is an error or a step, never a panic or a hang."""
    for make, _ in cases[:3]:
        env = make()
        env.reset(seed=1)

        def hammer(_):
            for _ in range(50):
                try:
                    env.step(np.full(4, 1) if hasattr(env, "num_envs") else 1)
                except Exception as error:
                    assert "defect" not in str(error), error
                    env.reset(seed=1)

        with ThreadPoolExecutor(4) as pool:
            list(pool.map(hammer, range(4)))


def others_run():
    """Other threads run while a mission is flown, or a world solved."""
    ran = threading.Event()

    class Waits(MyPlanner):
        def decide(self, brief, map, state):
            assert ran.wait(60)
            return super().decide(brief, map, state)

    with ThreadPoolExecutor(1) as pool:
        flight = pool.submit(hopper.run, "hard", Waits(), 1)
        ran.set()
        flight.result()


def interrupted():
    """Ctrl-C ends a mission in this thread."""
    class Holds:
        def decide(self, brief, map, state):
            if state.decision == 5:
                signal.raise_signal(signal.SIGINT)
            return hopper.Action.HOLD

    for planner, scenario in [(Holds(), "hard"), ("mdp", "vast")]:
        timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
        if planner == "mdp":
            timer.start()
        try:
            while True:
                hopper.run(scenario, planner)
        except KeyboardInterrupt:
            pass
        if planner == "mdp":
            timer.join()


def in_child(work):
    """Whether `work` succeeds in a forked child."""
    child = os.fork()
    if child == 0:
        signal.alarm(120)
        code = 1
        try:
            work()
            code = 0
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    return status == 0


def forks():
    for make, use in cases:
        made = make()
        expected = use(made)
        assert in_child(lambda: [use(make()) == expected or os._exit(2), use(made) == expected or os._exit(3)]), use
        assert use(made) == expected, "the parent's is its own"
    env = hopper.pettingzoo.env()
    env.reset(seed=1)

    def stale():
        try:
            env.step(1)
        except hopper.HopperError as error:
            assert "reset()" in str(error)
            env.reset(seed=1)
            env.step(1)
            return
        os._exit(4)

    assert in_child(stale)
    env.step(1)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert set(pool.map(one, range(4))) == {one(0)}
    vector = gymnasium.make_vec("PlanetaryHopper-v1", num_envs=2, vectorization_mode="async")
    vector.reset(seed=1)
    vector.step(np.array([1, 2]))
    vector.close()


def one(_):
    return hopper.run("coverage", seed=1).digest


def fork_in_decide():
    """A child that returns from decide ends: with its mission in hopper.run, by an error in hopper.fly (fork_planner.py)."""
    children = []

    class Forks(MyPlanner):
        def decide(self, brief, map, state):
            if state.decision == 2 and not children:
                children.append(os.fork())
            return super().decide(brief, map, state)

    parent = os.getpid()
    flight = hopper.run("hard", Forks(), 1)
    if os.getpid() != parent:
        os._exit(0)
    assert os.waitpid(children[0], 0)[1] == 0 and flight.digest == hopper.run("hard", MyPlanner(), 1).digest


for part in (threads, shared, others_run, interrupted, forks, fork_in_decide):
    part()
    print(part.__name__, file=sys.stderr, flush=True)
print("{}")
