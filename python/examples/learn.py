"""Learns to cross `hard` from nothing but rewards, in NumPy: `python learn.py [rounds] [seed]`.

The policy scores the four hops by a few features of the cell ahead, and takes the best. The cross-entropy method finds
the weights: many are drawn, each flies some missions, and the next are drawn around the best of them.
"""

import json
import sys

import numpy as np

from hopper.gym import HopperVectorEnv

WINDOW, CANDIDATES, MISSIONS, ELITE = 11, 48, 16, 8

#: Rows and columns of the cells to the north, east, south and west of the hopper in a window.
AHEAD = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)]) + WINDOW // 2

#: x and y of the four hops.
STEPS = np.array([(0, 1), (1, 0), (0, -1), (-1, 0)])


def features(observation):
    """What the cell ahead is like, for each mission and hop: shape (missions, 4, 5)."""
    planes, numbers = observation["planes"], observation["numbers"]
    ahead = planes[:, :, AHEAD[:, 0], AHEAD[:, 1]]
    here = planes[:, :1, WINDOW // 2, WINDOW // 2]
    to_goal = numbers[:, 2:4] / np.maximum(1.0, np.linalg.norm(numbers[:, 2:4], axis=1, keepdims=True))
    progress = to_goal @ STEPS.T
    climb = ahead[:, 0] - here
    return np.stack([progress, climb, np.abs(climb), ahead[:, 1], ahead[:, 2]], axis=2)


def fly(env, weights, seed):
    """Return and success of one mission for each of the weights."""
    observation, _ = env.reset(seed=seed)
    total, success = np.zeros(len(weights)), np.zeros(len(weights), bool)
    flying = np.ones(len(weights), bool)
    while flying.any():
        scores = np.einsum("mhf,mf->mh", features(observation), weights)
        observation, rewards, terminated, truncated, _ = env.step(1 + scores.argmax(axis=1))
        total += np.where(flying, rewards, 0.0)
        # Only the goal pays.
        success |= flying & terminated & (rewards > 0)
        flying &= ~(terminated | truncated)
    return total, success


def learn(rounds, seed):
    random = np.random.default_rng(seed)
    env = HopperVectorEnv(CANDIDATES * MISSIONS, scenario="hard", window=WINDOW, copy=False)
    count = features({"planes": np.zeros((1, 4, WINDOW, WINDOW)), "numbers": np.zeros((1, 5))}).shape[2]
    mean, spread, curve = np.zeros(count), np.ones(count), []
    for number in range(rounds):
        candidates = mean + spread * random.standard_normal((CANDIDATES, count))
        # All candidates fly missions of other seeds in each round.
        first = 1 + number * CANDIDATES * MISSIONS
        total, success = fly(env, np.repeat(candidates, MISSIONS, axis=0), first)
        returns = total.reshape(CANDIDATES, MISSIONS).mean(axis=1)
        best = candidates[np.argsort(returns)[-ELITE:]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.02
        curve.append(float(success.mean()))
        print(f"round {number}: mean return {returns.mean():.1f}, success {curve[-1]:.2f}", file=sys.stderr)
    _, success = fly(env, np.tile(mean, (CANDIDATES * MISSIONS, 1)), 10**6)
    return {"first": curve[0], "learned": float(success.mean()), "weights": mean.tolist()}


if __name__ == "__main__":
    arguments = [int(word) for word in sys.argv[1:]]
    print(json.dumps(learn(*arguments, *[12, 1][len(arguments):])))
