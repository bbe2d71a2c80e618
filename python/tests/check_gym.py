"""The environments: gymnasium's checks, and digests of live missions. Prints what tests/python.rs compares."""

import json
import sys
import warnings

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env

import hopper
import hopper.gym

warnings.simplefilter("error")
warnings.filterwarnings("ignore", ".*out of date.*")


def rolled(scenario, profile, seed, window):
    """A mission flown by a fixed rule, and the actions taken."""
    env = gymnasium.make("Hopper-v0", scenario=scenario, profile=profile, window=window)
    observation, info = env.reset(seed=seed)
    assert info["seed"] == seed
    actions, total = [], 0.0
    while True:
        dx, dy = observation["numbers"][2:4]
        planes = observation["planes"]
        if window:
            here = window // 2, window // 2
        else:
            here = int(observation["numbers"][1]), int(observation["numbers"][0])
        assert planes[3][here] == 1
        wanted = [1 if dy > 0 else 3, 2 if dx > 0 else 4] if abs(dy) >= abs(dx) else [2 if dx > 0 else 4, 1 if dy > 0 else 3]
        action = wanted[len(actions) % 7 == 6]
        observation, reward, terminated, truncated, info = env.step(action)
        actions.append(action)
        total += reward
        if terminated or truncated:
            return actions, env.unwrapped.digest(), info, total


class Replay:
    """Commands the actions of an environment."""

    name = "replay"

    def __init__(self, actions):
        self.actions = actions

    def decide(self, brief, map, state):
        return self.actions[state.decision]


def same_digests():
    for scenario, profile in [("hard", None), ("sandy", "hopper"), ("heterogeneous", None), ("treasures", None)]:
        for seed in (1, 2, 3, 4):
            actions, digest, info, _ = rolled(scenario, profile, seed, 11 if seed % 2 else 0)
            flight = hopper.run(scenario, Replay(actions), seed, profile=profile)
            assert flight.digest == digest, (scenario, seed)
            summary = flight.summary
            assert (summary["steps"], summary["outcome"]) == (info["steps"], info["status"].replace(" ", "_")), (summary, info)


def same_maps():
    """The planes of the whole map are those of the observed map."""
    env = gymnasium.make("Hopper-v0", scenario="heterogeneous", window=0)
    seen = []

    class Watching(Replay):
        def decide(self, brief, map, state):
            planes = seen[state.decision]
            assert (planes[3] == map.seen).all()
            assert (planes[0] == np.where(map.seen, map.height_m, 0).astype("f4")).all()
            assert (planes[1] == map.sand).all() and (planes[2] == (map.seen & ~map.passable)).all()
            return super().decide(brief, map, state)

    observation, _ = env.reset(seed=9)
    env.action_space.seed(9)
    actions, over = [], False
    while not over:
        seen.append(observation["planes"])
        actions.append(env.action_space.sample())
        observation, _, terminated, truncated, _ = env.step(actions[-1])
        over = terminated or truncated
    assert hopper.run("heterogeneous", Watching(actions), 9).digest == env.unwrapped.digest()


def vector():
    single = [gymnasium.make("Hopper-v0", scenario="sandy") for _ in range(5)]
    many = gymnasium.make_vec("Hopper-v0", num_envs=5, scenario="sandy")
    assert isinstance(many, hopper.gym.HopperVectorEnv)
    observations, _ = many.reset(seed=30)
    assert many.observation_space.contains(observations)
    ones = [env.reset(seed=30 + index)[0] for index, env in enumerate(single)]
    random, over = np.random.default_rng(3), [False] * 5
    ended = 0
    for _ in range(400):
        for index in range(5):
            for name in ("planes", "numbers"):
                assert (observations[name][index] == ones[index][name]).all()
        actions = random.integers(5, size=5)
        observations, rewards, terminated, truncated, _ = many.step(actions)
        for index, env in enumerate(single):
            if over[index]:
                seed = many.told(index)[0]
                ones[index], reward, ends = env.reset(seed=seed)[0], 0.0, (False, False)
                ended += 1
            else:
                ones[index], reward, *ends, _ = env.step(actions[index])
            assert (reward, *ends) == (rewards[index], terminated[index], truncated[index])
            over[index] = any(ends)
            assert env.unwrapped.digest() == many.digest(index)
    assert ended > 5


def checked():
    for window in (11, 0):
        env = gymnasium.make("Hopper-v0", window=window)
        check_env(env.unwrapped, skip_render_check=True)
    for arguments, text in [
        ({"window": 4}, "odd window"), ({"scenario": "patrol"}, "one goal"), ({"scenario": "coverage"}, "one goal"),
        ({"scenario": "nowhere"}, "nowhere"),
    ]:
        try:
            gymnasium.make("Hopper-v0", **arguments)
        except hopper.HopperError as error:
            assert text in str(error), error
        else:
            raise AssertionError(f"{arguments} needs to be refused")


checked()
same_digests()
same_maps()
vector()
actions, digest, _, _ = rolled("hard", None, 3, 11)
print(json.dumps({"actions": actions, "digest": digest}))
