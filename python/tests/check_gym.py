"""The environments: gymnasium's checks, and digests of live missions. Prints what tests/python.rs compares."""

import json
import pathlib
import tempfile
import warnings

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env

import hopper
import hopper.gym

# Nothing that a user does by the book warns: MuJoCo's robot is called Hopper, too.
warnings.simplefilter("error")


def rolled(scenario, profile, seed, window, **named):
    """A mission flown by a fixed rule, and the actions taken."""
    env = gymnasium.make("PlanetaryHopper-v1", scenario=scenario, profile=profile, window=window, **named)
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
    env = gymnasium.make("PlanetaryHopper-v1", scenario="heterogeneous", window=0)
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
    single = [gymnasium.make("PlanetaryHopper-v1", scenario="sandy") for _ in range(5)]
    many = gymnasium.make_vec("PlanetaryHopper-v1", num_envs=5, scenario="sandy")
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
        env = gymnasium.make("PlanetaryHopper-v1", window=window)
        check_env(env.unwrapped, skip_render_check=True)
    # Its check of rendering warns that a window may need a screen.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        check_env(gymnasium.make("PlanetaryHopper-v1", render_mode="rgb_array").unwrapped)
    exist = "hopper.gym has hard, heterogeneous, sandy, large, treasures, wide, vast, hills, mars; hopper.pettingzoo has coverage, coverage-8"
    for arguments, text in [
        ({"window": 4}, "odd window"), ({"scenario": "nowhere"}, "nowhere"),
        *[({"scenario": name}, exist) for name in ["patrol", "coverage", "hopper-scout", "rover-helicopter", "expedition"]],
    ]:
        try:
            gymnasium.make("PlanetaryHopper-v1", **arguments)
        except hopper.HopperError as error:
            assert text in str(error), error
        else:
            raise AssertionError(f"{arguments} needs to be refused")


def named():
    """No environment has a name of gymnasium's own."""
    ours = {name for name, spec in gymnasium.registry.items() if str(spec.entry_point).startswith("hopper")}
    assert ours == {"PlanetaryHopper-v1"}, ours
    make_vec = gymnasium.make_vec
    for env in [
        gymnasium.make("hopper.gym:PlanetaryHopper-v1"), gymnasium.make("PlanetaryHopper-v1"),
        make_vec("hopper.gym:PlanetaryHopper-v1", num_envs=2), make_vec("PlanetaryHopper-v1", num_envs=2, vectorization_mode="sync"),
    ]:
        env.reset(seed=1)
        env.step(env.action_space.sample())
        env.close()


def rendered():
    env = gymnasium.make("PlanetaryHopper-v1", scenario="treasures", render_mode="rgb_array")
    env.reset(seed=1)
    first = env.render()
    assert first.dtype == np.uint8 and first.ndim == 3 and first.shape[2] == 3 and first.std() > 10
    env.step(2)
    assert env.render().shape == first.shape and (env.render() != first).any()
    assert gymnasium.make("PlanetaryHopper-v1").unwrapped.render() is None
    many = gymnasium.make_vec("PlanetaryHopper-v1", num_envs=3, render_mode="rgb_array")
    many.reset(seed=1)
    assert len(many.render()) == 3 and (many.render()[0] == many.render()[0]).all()
    single = gymnasium.make("PlanetaryHopper-v1", render_mode="rgb_array")
    single.reset(seed=2)
    assert (single.render() == many.render()[1]).all()
    import matplotlib

    matplotlib.use("Agg")
    for shown in (gymnasium.make("PlanetaryHopper-v1", render_mode="human"),
                  gymnasium.make_vec("PlanetaryHopper-v1", num_envs=3, render_mode="human")):
        shown.reset(seed=1)
        shown.step(2 if shown.action_space.shape == () else np.array([1, 2, 3]))
        assert shown.render() is None
        shown.close()


def elsewhere():
    """A scenario file and an elevation model of one's own."""
    with tempfile.TemporaryDirectory() as folder:
        dem = pathlib.Path(folder, "dem.asc")
        x, y = np.meshgrid(np.arange(30), np.arange(20))
        rows = 2 + 0.5 * np.sin(x / 3.0) + 0.4 * np.cos(y / 2.0)
        header = "ncols 30\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n"
        dem.write_text(header + "\n".join(" ".join(f"{height:.4f}" for height in row) for row in rows))
        actions, digest, info, _ = rolled(None, None, 1, 0, dem=dem)
        flight = hopper.run(dem=dem, planner=Replay(actions), seed=1)
        assert flight.digest == digest and flight.map["height_m"].shape == (20, 30), info
        assert hopper.run(dem=str(dem), planner="greedy").summary["scenario"] == flight.summary["scenario"]


checked()
named()
rendered()
elsewhere()
same_digests()
same_maps()
vector()
actions, digest, _, _ = rolled("hard", None, 3, 11)
print(json.dumps({"actions": actions, "digest": digest}))
