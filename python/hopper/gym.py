"""Environments for learners: `gymnasium.make("hopper.gym:Hopper-v0", scenario="hard", profile=None, window=11)`.

`gymnasium.make_vec(..., num_envs=N, vectorization_mode="vector_entry_point")` makes a native vector environment. The part
before the colon imports this module, which registers the environment; after `import hopper.gym` it may be left out.

A step is a decision. Actions are 0 hold, 1 north, 2 east, 3 south, 4 west; what the guard vetoes is a hold.

An observation is a dictionary of 32-bit floats:

- `planes`, shape (4, rows, columns): height above the datum in metres, sand, impassable, seen, each 0 where unseen. The
  rows go from south to north and the columns from west to east, around the hopper with an odd `window`, over the whole map with
  `window=0`. Beyond the grid all is seen and impassable.
- `numbers`, shape (5,): x and y of the hopper, cells to the goal along x and y, share of the steps left (0 to 1).

The reward is minus the steps that the action costs in the paper's count (1, 2 or 3), plus the brief's payoff of a treasure
for each that is collected, plus the payoff of the goal on reaching it, minus that payoff on leaving the map or on landing
on impassable ground. A mission that runs out of steps is truncated; any other end terminates it.

`reset(seed=S)` begins the mission that `hopper run --seed S` flies: the same actions lead to the same digest, which
`digest()` computes.
"""

from __future__ import annotations

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from . import _native

__all__ = ["HopperEnv", "HopperVectorEnv", "register"]

#: No ground is higher or lower, metres.
_HEIGHT_MAX_M = 1e6

#: Seeds of missions are below it.
_SEEDS = 2**63


def register():
    """Registers Hopper-v0 with gymnasium; importing this module does so."""
    if "Hopper-v0" not in gymnasium.registry:
        gymnasium.register(
            "Hopper-v0", entry_point="hopper.gym:HopperEnv", vector_entry_point="hopper.gym:HopperVectorEnv"
        )


def _spaces(batch):
    rows, columns = batch.shape
    width, height, _ = batch.limits
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
    return observation, gymnasium.spaces.Discrete(5)


class HopperVectorEnv(gymnasium.vector.VectorEnv):
    """Many missions side by side, stepped natively. A mission that is over begins anew at the next step (`NEXT_STEP`).

    With `copy=False` the arrays that are returned are overwritten by the next step.
    """

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}

    def __init__(self, num_envs=1, *, scenario="hard", profile=None, window=11, copy=True, render_mode=None):
        if render_mode is not None:
            raise _native.HopperError(f"environments are not rendered, got render_mode {render_mode!r}")
        self._batch = _native.Batch(str(scenario), profile, num_envs, window)
        self.num_envs = num_envs
        self.render_mode = None
        self.single_observation_space, self.single_action_space = _spaces(self._batch)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._copy = copy
        self._planes = np.zeros((num_envs, 4, *self._batch.shape), "f4")
        self._numbers = np.zeros((num_envs, 5), "f4")
        self._rewards, self._ends = np.zeros(num_envs), np.zeros(num_envs, "u1")

    def reset(self, *, seed=None, options=None):
        """Begins all missions: environment i with seed + i, or with seed[i]; without a seed, with random ones."""
        super().reset(seed=seed if isinstance(seed, int) else None)
        if seed is None:
            seeds = self.np_random.integers(_SEEDS, size=self.num_envs)
        elif isinstance(seed, int):
            seeds = range(seed, seed + self.num_envs)
        else:
            seeds = [int(one) if one is not None else int(self.np_random.integers(_SEEDS)) for one in seed]
        for index, one in enumerate(seeds):
            self._batch.reset(index, int(one))
        return self._observation(), {}

    def step(self, actions):
        """Takes an action in each mission."""
        actions = np.ascontiguousarray(actions, dtype=np.int64)
        self._batch.step(actions, self._rewards, self._ends)
        ends = self._ends
        return self._observation(), self._rewards.copy() if self._copy else self._rewards, ends == 1, ends == 2, {}

    def digest(self, index):
        """The digest of mission `index` so far."""
        return self._batch.digest(index)

    def told(self, index):
        """Seed, steps, treasures collected and status of mission `index`."""
        return self._batch.told(index)

    def _observation(self):
        self._batch.observe(self._planes, self._numbers)
        if self._copy:
            return {"planes": self._planes.copy(), "numbers": self._numbers.copy()}
        return {"planes": self._planes, "numbers": self._numbers}


class HopperEnv(gymnasium.Env):
    """One mission; see the module."""

    metadata = {"render_modes": []}

    def __init__(self, *, scenario="hard", profile=None, window=11, render_mode=None):
        if render_mode is not None:
            raise _native.HopperError(f"environments are not rendered, got render_mode {render_mode!r}")
        self.render_mode = None
        self._batch = _native.Batch(str(scenario), profile, 1, window)
        self.observation_space, self.action_space = _spaces(self._batch)
        self._rewards, self._ends = np.zeros(1), np.zeros(1, "u1")

    def reset(self, *, seed=None, options=None):
        """Begins a mission: that of `seed`, or a random one."""
        super().reset(seed=seed)
        self._batch.reset(0, int(self.np_random.integers(_SEEDS)) if seed is None else seed)
        return self._observation(), self._info()

    def step(self, action):
        """Takes an action."""
        if self._ends[0] != 0 and self._info()["status"] != "underway":
            raise gymnasium.error.ResetNeeded("the mission is over: call reset()")
        self._batch.step(np.array([action], dtype=np.int64), self._rewards, self._ends)
        end = int(self._ends[0])
        return self._observation(), float(self._rewards[0]), end == 1, end == 2, self._info()

    def digest(self):
        """The digest of the mission so far."""
        return self._batch.digest(0)

    def _observation(self):
        planes, numbers = np.zeros((1, 4, *self._batch.shape), "f4"), np.zeros((1, 5), "f4")
        self._batch.observe(planes, numbers)
        return {"planes": planes[0], "numbers": numbers[0]}

    def _info(self):
        seed, steps, treasures, status = self._batch.told(0)
        return {"seed": seed, "steps": steps, "treasures": treasures, "status": status}


register()
