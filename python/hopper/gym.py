"""Environments for learners: `gymnasium.make("hopper.gym:PlanetaryHopper-v1", scenario="hard", profile=None, window=11)`.

`gymnasium.make_vec(..., num_envs=N, vectorization_mode="vector_entry_point")` makes a native vector environment. The part
before the colon imports this module, which registers the environment; after `import hopper.gym` it may be left out.

A step is a decision. Actions are 0 hold, 1 north, 2 east, 3 south, 4 west, and, in scenarios with vertical hops, 5 to 8 for those
north, east, south, west; what the guard vetoes is a hold. Whatever else is given for an action is refused before any mission moves.

An observation is a dictionary of 32-bit floats:

- `planes`, shape (4, rows, columns): height above the datum in metres, sand, impassable, seen, each 0 where unseen. The
  rows go from south to north and the columns from west to east, around the hopper with an odd `window`, over the whole map with
  `window=0`. Beyond the grid all is seen and impassable.
- `numbers`, shape (5,): x and y of the hopper, cells to the goal along x and y, share of the steps left (0 to 1).

The reward is minus the steps that the action costs in the paper's count (1, 2 or 3), plus the brief's payoff of a treasure
for each that is collected, plus the payoff of the goal on reaching it, minus that payoff on leaving the map or on landing
on impassable ground. A mission that runs out of steps is truncated; any other end terminates it.

`reset(seed=S)` begins the mission that `hopper run --seed S` flies: the same actions lead to the same digest, which
`digest()` computes. `scenario` is a built-in name or a TOML file with one hopper and one goal, by default "hard", or with `dem`, the
file of an elevation model, one that fits it; `nodata` settles which of its stored values are nodata, as in `hopper.run`. Files are read
once: all missions of an environment, of its copies and of its pickles are over the ground that it was made with.

`reset` takes no options but, in the vector form, `reset_mask`, an array of bools: the missions that begin; the others go on.

Environments may be made in one thread and stepped in another. `copy.deepcopy` and `pickle` copy them with their missions;
`snapshot()` and `restore()` of the unwrapped environment go back to an earlier moment, which is cheaper. `render_mode` is "rgb_array"
or "human", which needs matplotlib.
"""

from __future__ import annotations

import copy
import dataclasses

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from . import _arguments, _native, _scene
from ._columns import columns
from ._native import HopperError

__all__ = ["HopperEnv", "HopperVectorEnv", "Snapshot", "register"]

#: No ground is higher or lower, metres.
_HEIGHT_MAX_M = 1e6

#: Random seeds of missions are below it.
_SEEDS = 2**63


def register():
    """Registers PlanetaryHopper-v1 with gymnasium; importing this module does so."""
    if "PlanetaryHopper-v1" not in gymnasium.registry:
        gymnasium.register(
            "PlanetaryHopper-v1", entry_point="hopper.gym:HopperEnv", vector_entry_point="hopper.gym:HopperVectorEnv"
        )


@dataclasses.dataclass(frozen=True)
class Snapshot:
    """A moment of an environment, from `snapshot()`. It can be pickled, and restored in any environment of its scenario.

    Attributes:
        scenario: Name, profile and hash of the scenario.
        missions: Seed and codes of the actions of each mission; None of one that was never begun.
        random: The state of the generator that draws seeds.
    """

    scenario: str
    missions: tuple
    random: dict


class _Missions:
    """What the single and the vector environment have in common."""

    def _begin(self, count, scenario, profile, dem, nodata, window, render_mode):
        self._window = None
        self.render_mode = _scene.checked(render_mode)
        count = _arguments.integer("num_envs", count, 1, 2**31)
        window = _arguments.integer("a window", window, 0, 255)
        self._batch = _native.Batch(_arguments.mission(scenario, profile, dem, nodata), count, window)

    @property
    def _open(self):
        if self._batch is None:
            raise HopperError("the environment is closed: make another one")
        return self._batch

    def _spaces(self):
        rows, columns = self._batch.shape
        width, height, _ = self._batch.limits
        low, high = np.zeros((4, rows, columns), "f4"), np.ones((4, rows, columns), "f4")
        low[0], high[0] = -_HEIGHT_MAX_M, _HEIGHT_MAX_M
        # A hopper that has left the map stands at most its side beyond.
        farthest = np.float32(2 * max(width, height))
        numbers = np.array([farthest] * 4 + [1.0], "f4")
        least = np.array([-farthest] * 4 + [0.0], "f4")
        observation = gymnasium.spaces.Dict(
            planes=gymnasium.spaces.Box(low, high, dtype=np.float32),
            numbers=gymnasium.spaces.Box(least, numbers, dtype=np.float32),
        )
        return observation, gymnasium.spaces.Discrete(self._batch.actions)

    def snapshot(self):
        """This moment, to come back to with `restore`."""
        scenario, missions = self._open.snapshot()
        return Snapshot(scenario, tuple(missions), copy.deepcopy(self.np_random.bit_generator.state))

    def _restore(self, snapshot):
        if not isinstance(snapshot, Snapshot):
            raise HopperError(f"restore needs what snapshot() returned, got {_arguments.told(snapshot)}")
        try:
            generator = copy.deepcopy(self.np_random)
            generator.bit_generator.state = snapshot.random
            self._open.restore((snapshot.scenario, list(snapshot.missions)))
        except (TypeError, ValueError, KeyError, OverflowError) as error:
            raise HopperError(f"restore needs what snapshot() returned: {error}") from None
        self._np_random = generator

    def _frame(self, index):
        scene = columns(self._open.scene(index))
        width, height, _ = self._batch.limits
        frame = _scene.Frame(_scene.ground(*scene["planes"].reshape(4, height, width)))
        route, (start, goal) = scene["route"].reshape(-1, 2), scene["ends"].reshape(2, 2)
        frame.mark(start, _scene.START)
        frame.mark(goal, _scene.GOAL)
        for cell in scene["treasures"].reshape(-1, 2):
            frame.mark(cell, _scene.TREASURE, 0.5)
        for cell in route:
            frame.mark(cell, _scene.ROUTE, 0.25)
        if len(route):
            frame.mark(route[-1], _scene.ROBOTS[0])
        return frame.image()

    def _show(self, image):
        if self._window is None:
            self._window = _scene.Window(f"PlanetaryHopper {id(self):x}")
        self._window.show(image)

    def _close(self):
        if self._window is not None:
            self._window.close()
        self._window = self._batch = None

    def __copy__(self):
        # Two environments of one mission would move each other's hopper.
        return copy.deepcopy(self)


class HopperVectorEnv(_Missions, gymnasium.vector.VectorEnv):
    """Many missions side by side, stepped natively. A mission that is over begins anew at the next step (`NEXT_STEP`).

    With `copy=False` the arrays that are returned are overwritten by the next step.
    """

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": ["human", "rgb_array"], "render_fps": 5}

    def __init__(
        self, num_envs=1, *, scenario=None, profile=None, dem=None, nodata=None, window=11, copy=True, render_mode=None
    ):
        self._begin(num_envs, scenario, profile, dem, nodata, window, render_mode)
        self.num_envs = len(self._batch)
        self.single_observation_space, self.single_action_space = self._spaces()
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._copy = bool(copy)
        self._planes = np.zeros((self.num_envs, 4, *self._batch.shape), "f4")
        self._numbers = np.zeros((self.num_envs, 5), "f4")
        self._rewards, self._ends = np.zeros(self.num_envs), np.zeros(self.num_envs, "u1")

    def reset(self, *, seed=None, options=None):
        """Begins all missions, or those of `options["reset_mask"]`: environment i with seed + i, or with seed[i]; without a seed, or
        where it is None, with a random one."""
        batch, first = self._open, None
        begins = self._mask(_arguments.options(options, "reset_mask"))
        if seed is None or isinstance(seed, (list, tuple, np.ndarray)) and np.ndim(seed) > 0:
            seeds = [None] * self.num_envs if seed is None else list(seed)
            if len(seeds) != self.num_envs:
                raise HopperError(f"{self.num_envs} missions need a seed each, got {len(seeds)} seeds")
            seeds = [one if one is None else _arguments.seed(one) for one in seeds]
        else:
            first = _arguments.integer("a seed", seed, 0, _arguments.SEEDS - self.num_envs)
            seeds = range(first, first + self.num_envs)
        super().reset(seed=first)
        seeds = [int(self.np_random.integers(_SEEDS)) if one is None and begin else one for one, begin in zip(seeds, begins)]
        batch.reset([one if begin else None for one, begin in zip(seeds, begins)])
        self._ends[begins] = 0
        if self.render_mode == "human":
            self.render()
        return self._observation(), {}

    def _mask(self, options):
        """The missions that `reset` begins."""
        if "reset_mask" not in options:
            return np.ones(self.num_envs, bool)
        mask = options["reset_mask"]
        if not isinstance(mask, np.ndarray) or mask.dtype != bool or mask.shape != (self.num_envs,) or np.ma.is_masked(mask):
            raise HopperError(f"reset_mask needs to be an array of {self.num_envs} bools, got {_arguments.told(mask)}")
        if not mask.any():
            raise HopperError("reset_mask needs a mission that begins, got none")
        return np.array(mask)

    def step(self, actions):
        """Takes an action in each mission; where one is refused, in none."""
        self._open.step(_actions(actions, self.num_envs, self._open.actions), self._rewards, self._ends)
        if self.render_mode == "human":
            self.render()
        ends = self._ends
        return self._observation(), self._rewards.copy() if self._copy else self._rewards, ends == 1, ends == 2, {}

    def render(self):
        """With "rgb_array" a frame of each mission; with "human" all of them in a window."""
        if self.render_mode is None:
            return None
        frames = tuple(self._frame(index) for index in range(self.num_envs))
        if self.render_mode == "rgb_array":
            return frames
        return self._show(_scene.tiled(frames))

    def digest(self, index):
        """The digest of mission `index` so far."""
        return self._open.digest(_arguments.integer("a mission", index, 0, self.num_envs - 1))

    def told(self, index):
        """Seed, steps, treasures collected and status of mission `index`."""
        return self._open.told(_arguments.integer("a mission", index, 0, self.num_envs - 1))

    def restore(self, snapshot):
        """Goes back to the moment of `snapshot()`; returns its observation. What it does not fit changes nothing."""
        self._restore(snapshot)
        return self._observation()

    def close_extras(self, **arguments):
        """Drops the missions."""
        self._close()

    def _observation(self):
        self._open.observe(self._planes, self._numbers)
        if self._copy:
            return {"planes": self._planes.copy(), "numbers": self._numbers.copy()}
        return {"planes": self._planes, "numbers": self._numbers}


class HopperEnv(_Missions, gymnasium.Env):
    """One mission; see the module."""

    metadata = {"render_modes": ["human", "rgb_array"], "render_fps": 5}

    def __init__(self, *, scenario=None, profile=None, dem=None, nodata=None, window=11, render_mode=None):
        self._begin(1, scenario, profile, dem, nodata, window, render_mode)
        self.observation_space, self.action_space = self._spaces()
        self._rewards, self._ends, self._begun = np.zeros(1), np.zeros(1, "u1"), False

    def reset(self, *, seed=None, options=None):
        """Begins a mission: that of `seed`, or a random one."""
        batch, seed = self._open, None if seed is None else _arguments.seed(seed)
        _arguments.options(options)
        super().reset(seed=seed)
        batch.reset([int(self.np_random.integers(_SEEDS)) if seed is None else seed])
        self._begun = True
        if self.render_mode == "human":
            self.render()
        return self._observation(), self._info()

    def step(self, action):
        """Takes an action."""
        actions = _actions([action], 1, self._open.actions)
        info = self._info()
        if not self._begun or info["status"] != "underway":
            raise gymnasium.error.ResetNeeded(f"the mission is {info['status'] if self._begun else 'not begun'}: call reset()")
        self._open.step(actions, self._rewards, self._ends)
        end = int(self._ends[0])
        if self.render_mode == "human":
            self.render()
        return self._observation(), float(self._rewards[0]), end == 1, end == 2, self._info()

    def render(self):
        """With "rgb_array" an image of the mission so far; with "human" it is shown in a window."""
        if self.render_mode is None:
            return None
        image = self._frame(0)
        return image if self.render_mode == "rgb_array" else self._show(image)

    def digest(self):
        """The digest of the mission so far."""
        return self._open.digest(0)

    def restore(self, snapshot):
        """Goes back to the moment of `snapshot()`; returns its observation. What it does not fit changes nothing."""
        self._restore(snapshot)
        self._begun = snapshot.missions[0] is not None
        return self._observation()

    def close(self):
        """Drops the mission."""
        self._close()

    def _observation(self):
        planes, numbers = np.zeros((1, 4, *self._open.shape), "f4"), np.zeros((1, 5), "f4")
        self._batch.observe(planes, numbers)
        return {"planes": planes[0], "numbers": numbers[0]}

    def _info(self):
        seed, steps, treasures, status = self._open.told(0)
        return {"seed": seed, "steps": steps, "treasures": treasures, "status": status}


def _actions(actions, count, most):
    """Numbers of an action each, below `most`; what is no whole number, or not in the action space, is refused."""
    try:
        values = np.asarray(actions)
    except Exception as error:
        raise HopperError(f"actions need to be whole numbers from 0 to {most - 1}: {error}") from None
    # In a list NumPy makes numbers of bools.
    mixed = isinstance(actions, (list, tuple)) and any(isinstance(one, (bool, np.bool_)) for one in actions)
    if mixed or np.ma.is_masked(actions) or values.dtype.kind not in "iu":
        raise HopperError(f"actions need to be whole numbers from 0 to {most - 1}, got {_arguments.told(actions)}")
    if values.shape != (count,):
        raise HopperError(f"{count} missions need an action each, got an array of shape {values.shape}")
    wrong = (values < 0) | (values >= most)
    if wrong.any():
        raise HopperError(f"an action needs to be 0 to {most - 1}, got {values[wrong][0]}")
    return np.ascontiguousarray(values, dtype=np.int64)


register()
