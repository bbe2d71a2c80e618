"""The environment of several rovers: pettingzoo's checks, and the digest of the same mission in lockstep."""

import contextlib
import io
import json
import warnings

import numpy as np
from pettingzoo.test import api_test, parallel_api_test, seed_test

import hopper
import hopper.pettingzoo


class Replay:
    def __init__(self, actions):
        self.actions = actions

    def decide(self, brief, map, state):
        # An action that was vetoed is a hold in the environment.
        return hopper.Action.HOLD if self.actions[state.decision] in state.vetoed else self.actions[state.decision]


def same_digest(seed):
    env = hopper.pettingzoo.env(scenario="coverage")
    env.reset(seed=seed)
    random, actions, rewards = np.random.default_rng(seed), [], 0.0
    for agent in env.agent_iter():
        planes, reward, terminated, truncated, _ = env.last()
        rewards += reward
        if terminated or truncated:
            env.step(None)
            continue
        y, x = np.argwhere(planes[5] == 1)[0]
        visits = {}
        for action, (dx, dy) in enumerate([(0, 1), (1, 0), (0, -1), (-1, 0)], start=1):
            to = y + dy, x + dx
            if 0 <= to[0] < planes.shape[1] and 0 <= to[1] < planes.shape[2] and planes[1][to]:
                visits[action] = planes[3][to] + 0.5 * random.random()
        action = min(visits, key=visits.get, default=0)
        actions.append(action + 4 if action else 0)
        env.step(action)
    flight = env.flight()
    again = hopper.run("coverage", Replay(actions), seed)
    assert flight.digest == again.digest and flight.summary["steps"] == again.summary["steps"]
    # The cells of the four starts are covered before anybody moves.
    assert rewards == flight.rows["visits"][-1] - 4, (rewards, flight.rows["visits"][-1])
    return flight.digest


with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
    warnings.simplefilter("ignore")
    api_test(hopper.pettingzoo.env(), num_cycles=300)
    parallel_api_test(hopper.pettingzoo.parallel_env(), num_cycles=300)
    seed_test(hopper.pettingzoo.env, num_cycles=50)
for make in (hopper.pettingzoo.env, hopper.pettingzoo.parallel_env):
    env = make()
    # What the environment has from reset on, and what needs it.
    names = ["agents", "num_agents"] + (["rewards", "agent_selection", "last"] if make is hopper.pettingzoo.env else [])
    for use in [*(lambda name=name: (getattr(env, name), env.last()) for name in names), lambda: env.step({}), lambda: env.step(1)]:
        try:
            use()
        except hopper.HopperError as error:
            assert "the mission is not begun: call reset()" in str(error), error
        else:
            raise AssertionError("a mission that is not begun needs a reset")
    assert not hasattr(env, "agents") and not hasattr(env, "nothing")
    env.reset(seed=1)
    assert env.num_agents == 4
try:
    hopper.pettingzoo.env(scenario="hard")
except hopper.HopperError as error:
    assert "rovers that cover ground, got scenario hard" in str(error), error
else:
    raise AssertionError("a hopper's mission needs to be refused")
print(json.dumps([same_digest(seed) for seed in (1, 2)]))
