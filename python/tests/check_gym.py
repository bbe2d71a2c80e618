"""The environments: gymnasium's checks, and digests of live missions. Prints what tests/python.rs compares."""

import inspect
import json
import pathlib
import tempfile
import warnings

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env

import hopper
import hopper.gym
import hopper.pettingzoo

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


def vertical():
    """Over the rocks with a seed whose outcomes are all as aimed: vertical hops are the actions 5 to 8."""
    env = gymnasium.make("PlanetaryHopper-v1", scenario="rocks", window=11)
    assert env.action_space.n == 9 and gymnasium.make("PlanetaryHopper-v1", scenario="hard").action_space.n == 5
    path = "NENNNNNNEEEEEENENNNE^EENEN"
    env.reset(seed=6905)
    for hop in path:
        _, _, terminated, _, info = env.step({"N": 1, "E": 2, "^": 6}[hop])
    assert terminated and info["status"] == "goal", info
    codes = [{"N": hopper.Action.NORTH, "E": hopper.Action.EAST, "^": hopper.Action.UP_EAST}[hop] for hop in path]
    flight = hopper.run("rocks", Replay(codes), 6905)
    assert flight.digest == env.unwrapped.digest() and flight.rows["action"].tolist() == codes
    assert hopper.run("rocks", "mdp", 6905).digest == flight.digest, "the planner's own way"
    # What is not offered is a hold.
    env.reset(seed=1)
    env.step(6)
    _, _, _, _, info = env.step(8)
    assert info["steps"] == 2, info


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
    exist = "hopper.gym has hard, heterogeneous, sandy, large, treasures, wide, vast, hills, mars, known-hard, known-heterogeneous, known-sandy, rocks; hopper.pettingzoo has coverage, coverage-8"
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
        header = "ncols 30\nnrows 20\nxllcorner 500000\nyllcorner 4000000\ncellsize 1\nNODATA_value -9999\n"
        dem.write_text(header + "\n".join(" ".join(f"{height:.4f}" for height in row) for row in rows))
        actions, digest, info, _ = rolled(None, None, 1, 0, dem=dem)
        flight = hopper.run(dem=dem, planner=Replay(actions), seed=1)
        assert flight.digest == digest and flight.map["height_m"].shape == (20, 30), info
        assert hopper.run(dem=str(dem), planner="greedy").summary["scenario"] == flight.summary["scenario"]


def masked():
    """`reset_mask` begins the missions that it names, as gymnasium's own vector environment does, and no other option is taken."""
    native, sync = (
        gymnasium.make_vec("PlanetaryHopper-v1", num_envs=3, vectorization_mode=mode, scenario="sandy")
        for mode in ("vector_entry_point", "sync")
    )
    random = np.random.default_rng(4)
    native.reset(seed=7), sync.reset(seed=7)
    over = np.zeros(3, bool)
    for turn in range(300):
        if turn % 10 == 9 or over.any():
            # Those that are over begin, so that no other seed is drawn.
            mask = over | (random.random(3) < 0.4)
            if not mask.any():
                mask[turn % 3] = True
            seed = int(random.integers(1000)) if turn % 2 else [int(one) for one in random.integers(1000, size=3)]
            before = [native.told(index) for index in range(3)]
            options = {"reset_mask": mask.copy()}
            ours, theirs = native.reset(seed=seed, options=options)[0], sync.reset(seed=seed, options={"reset_mask": mask.copy()})[0]
            assert list(options) == ["reset_mask"], "the caller's dictionary is the caller's"
            seeds = [seed + index for index in range(3)] if isinstance(seed, int) else seed
            for index in range(3):
                assert native.told(index) == ((seeds[index], 0, 0, "underway") if mask[index] else before[index]), (mask, index)
            over = np.zeros(3, bool)
        else:
            actions = random.integers(5, size=3)
            (ours, *ends), (theirs, *their_ends) = native.step(actions), sync.step(actions)
            assert all((one == other).all() for one, other in zip(ends[:3], their_ends[:3]))
            over = ends[1] | ends[2]
        for name in ("planes", "numbers"):
            assert (ours[name] == theirs[name]).all(), (turn, name)
    before = [native.told(index) for index in range(3)]
    native.reset(options={"reset_mask": np.array([False, True, False])})
    assert [native.told(index) == before[index] for index in range(3)] == [True, False, True], "a random seed for one"

    single, rovers = hopper.gym.HopperEnv(), hopper.pettingzoo.env()
    for env in (native, single, rovers, hopper.pettingzoo.parallel_env()):
        env.reset(seed=1, options=None), env.reset(seed=1, options={})
        env.step(np.array([1, 2, 3]) if env is native else {agent: 1 for agent in env.agents} if hasattr(env, "aec_env") else 1)
        before = env.snapshot() if hasattr(env, "snapshot") else env.unwrapped.snapshot()
        for options in [3, "x", [], ["reset_mask"], {"seed": 3}, {"foo": 1}, {3: 1}, {"reset_mask": None}, {"reset_mask": [True] * 3},
                        {"reset_mask": np.ones(3)}, {"reset_mask": np.ones(4, bool)}, {"reset_mask": np.zeros(3, bool)},
                        *([] if env is native else [{"reset_mask": np.ones(1, bool)}])]:
            try:
                env.reset(seed=1, options=options)
            except hopper.HopperError as error:
                assert any(text in str(error) for text in ("options need", "reset takes no option", "reset_mask needs")), error
            else:
                raise AssertionError(f"options {options} need to be refused")
            assert (env.snapshot() if hasattr(env, "snapshot") else env.unwrapped.snapshot()) == before, "nothing has moved"


def settled():
    """Warnings are about the line that asked, in Python's words, and `nodata` settles them."""
    with tempfile.TemporaryDirectory() as folder:
        dem = pathlib.Path(folder, "dem.asc")
        rows = 2 + 0.3 * np.sin(np.arange(30) / 3.0) + np.zeros((20, 1))
        rows[10, 14:16] = -9999
        header = "ncols 30\nnrows 20\nxllcorner 500000\nyllcorner 4000000\ncellsize 1\n"
        dem.write_text(header + "\n".join(" ".join(f"{height:.4f}" for height in row) for row in rows))
        makers = [
            lambda **named: hopper.run(planner="greedy", **named),
            lambda **named: gymnasium.make("PlanetaryHopper-v1", **named),
            lambda **named: gymnasium.make_vec("PlanetaryHopper-v1", num_envs=2, **named),
            hopper.gym.HopperEnv,
        ]
        for make in makers:
            with warnings.catch_warnings(record=True) as given:
                warnings.simplefilter("always")
                line = inspect.currentframe().f_lineno + 1
                make(dem=dem)
            text = str(given[0].message)
            lines = {line, make.__code__.co_firstlineno} if inspect.isfunction(make) else {line}
            assert len(given) == 1 and given[0].filename == __file__ and given[0].lineno in lines, given[0]
            assert "settle it with nodata=-9999 or" in text and "or with nodata=[] if they are heights" in text and "--" not in text, text
            for nodata in (-9999, [-9999.0], np.array([-9999])):
                make(dem=dem, nodata=nodata)
            for nodata in ("none", np.nan, [None], True, {}, object()):
                refused("nodata needs to be", make, dem=dem, nodata=nodata)
        flight = hopper.run(dem=dem, nodata=-9999, planner="greedy")
        assert np.isnan(flight.map["height_m"][~flight.map["passable"]]).any() or not flight.map["seen"][9, 14]
        refused("dem= needs a scenario with truth.terrain.elevation_file", hopper.run, "hard", dem=dem)
        refused("nodata= needs a scenario with truth.terrain.elevation_file", hopper.run, "hard", nodata=[])
        refused("nodata= needs a scenario", hopper.pettingzoo.env, nodata=-9999)
        refused("dem= needs the file", hopper.run, dem=pathlib.Path(folder, "no.tif"))
        scenario = pathlib.Path(folder, "mine.toml")
        scenario.write_text('[truth.terrain.elevation_file]\nfile = "no.tif"\n[brief]\nstart = [2, 2]\ngoal = [9, 9]\n')
        refused("point to it with dem=FILE", hopper.run, scenario)


def refused(text, call, *arguments, **named):
    try:
        call(*arguments, **named)
    except hopper.HopperError as error:
        assert text in str(error) and "--dem" not in str(error) and "--nodata" not in str(error), f"need {text!r} in {str(error)!r}"
        return
    raise AssertionError(f"need a HopperError with {text!r}")


checked()
named()
masked()
settled()
rendered()
elsewhere()
same_digests()
vertical()
same_maps()
vector()
actions, digest, _, _ = rolled("hard", None, 3, 11)
print(json.dumps({"actions": actions, "digest": digest}))
