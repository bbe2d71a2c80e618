"""Several rovers as agents, turn by turn as their missions are: `hopper.pettingzoo.env(scenario="coverage")`.

An agent is a rover, `robot_0` and so on. It is the turn of the rover whose simulated clock is least. Actions are 0 hold, 1 north,
2 east, 3 south, 4 west; what the guard vetoes, or would lead into an occupied cell, is a hold.

An observation is an array of 32-bit floats of shape (6, height, width), the same for all rovers but for the last plane, rows
from south to north: seen, passable, impassable (0 where unseen), visits, all robots, this robot. The map is that of the last
decision.

The reward is the number of cells that a step has covered first, 0 or 1, for the rover that took it. The mission ends for all
rovers at once: terminated when enough is covered, truncated when they run out of actions.

`reset(seed=S)` begins the mission that `hopper run --seed S` flies: the same actions lead to the same digest, which `flight()`
has once the mission is over. `parallel_env` is the same mission with one action for each rover at a time.
"""

from __future__ import annotations

import gymnasium
import numpy as np
from pettingzoo import AECEnv
from pettingzoo.utils.conversions import turn_based_aec_to_parallel

import hopper

from . import _native

__all__ = ["HopperAECEnv", "env", "parallel_env"]

#: Seeds of missions are below it.
_SEEDS = 2**63


def env(**arguments):
    """The environment of `HopperAECEnv`."""
    return HopperAECEnv(**arguments)


def parallel_env(**arguments):
    """The parallel form: each step gives the rover whose turn it is its action."""
    return turn_based_aec_to_parallel(HopperAECEnv(**arguments))


class HopperAECEnv(AECEnv):
    """A mission of several rovers; see the module."""

    metadata = {"name": "hopper_v0", "render_modes": [], "is_parallelizable": True}

    def __init__(self, *, scenario="coverage", profile=None, render_mode=None):
        super().__init__()
        if render_mode is not None:
            raise hopper.HopperError(f"environments are not rendered, got render_mode {render_mode!r}")
        self.render_mode = None
        self._arguments = str(scenario), profile
        self._random = np.random.default_rng()
        brief, *_ = self._begin(0)
        if brief.task != "cover":
            raise hopper.HopperError(f"rovers need a mission that covers ground, got scenario {brief.scenario}")
        self.possible_agents = [f"robot_{number}" for number in range(brief.robots)]
        high = np.ones((6, brief.height, brief.width), "f4")
        high[3] = np.iinfo("u2").max
        self._observation_space = gymnasium.spaces.Box(np.zeros_like(high), high, dtype=np.float32)
        self._action_space = gymnasium.spaces.Discrete(5)
        self.observation_spaces = {agent: self._observation_space for agent in self.possible_agents}
        self.action_spaces = {
            agent: gymnasium.spaces.Discrete(5) for agent in self.possible_agents
        }

    def observation_space(self, agent):
        return self.observation_spaces[agent]

    def action_space(self, agent):
        return self.action_spaces[agent]

    def reset(self, seed=None, options=None):
        """Begins a mission: that of `seed`, or a random one."""
        if seed is not None:
            self._random = np.random.default_rng(seed)
        self._flight = None
        self.agents = self.possible_agents[:]
        self._due = self._begin(seed if seed is not None else int(self._random.integers(_SEEDS)))
        self._look()
        self.rewards = dict.fromkeys(self.agents, 0.0)
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self.terminations = dict.fromkeys(self.agents, False)
        self.truncations = dict.fromkeys(self.agents, False)
        self.infos = {agent: {} for agent in self.agents}
        self.agent_selection = self.agents[self._due[2].robot]

    def step(self, action):
        """Takes the action of `agent_selection`; None once the mission is over."""
        agent = self.agent_selection
        if self.terminations[agent] or self.truncations[agent]:
            self._was_dead_step(action)
            return
        if not self.action_spaces[agent].contains(action):
            raise hopper.HopperError(f"an action needs to be 0 to 4, got {action!r}")
        self._cumulative_rewards[agent] = 0.0
        self.rewards = dict.fromkeys(self.agents, 0.0)
        state = self._due[2]
        covered, decision = state.visits, state.decision
        self._session.act(int(action) + 4 if action else 0)
        self._due = self._session.next()
        while self._due is not None and self._due[2].decision == decision:
            # The guard has vetoed it.
            self._session.act(0)
            self._due = self._session.next()
        if self._due is None:
            self._flight = hopper._flight(*self._session.ended())
            covered_now = int(self._flight.rows["visits"][-1])
            reached = self._flight.summary["outcome"] == "goal"
            ends = self.terminations if reached else self.truncations
            ends.update(dict.fromkeys(self.agents, True))
        else:
            covered_now = self._due[2].visits
            self._look()
            self.agent_selection = self.possible_agents[self._due[2].robot]
        self.rewards[agent] = float(covered_now - covered)
        self._accumulate_rewards()
        if self._due is None:
            self._deads_step_first()

    def observe(self, agent):
        planes = self._planes.copy()
        x, y = self._robots[self.possible_agents.index(agent)]
        planes[5, y, x] = 1.0
        return planes

    def flight(self):
        """The mission as `hopper.run` returns it, once it is over; None before."""
        return self._flight

    def close(self):
        """Drops the mission."""
        self._session = None

    def _begin(self, seed):
        self._session = _native.Session(*self._arguments, seed)
        due = self._session.next()
        if due is None:
            raise hopper.HopperError("the mission is over before its first decision")
        return due

    def _look(self):
        brief, map, state = self._due
        planes = np.zeros((6, brief.height, brief.width), "f4")
        planes[0], planes[1] = map.seen, map.seen & map.passable
        planes[2], planes[3] = map.seen & ~map.passable, map.visits
        for x, y in state.robots:
            planes[4, y, x] = 1.0
        self._planes, self._robots = planes, state.robots
