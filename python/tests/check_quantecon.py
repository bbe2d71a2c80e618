"""The solver beside policy iteration of quantecon, on random worlds with slopes, sand and lost ground. Run by tests/python.rs."""

import json

import numpy as np
from quantecon.markov import DiscreteDP
from scipy import sparse

import hopper

#: x and y of the four hops.
STEPS = [(0, 1), (1, 0), (0, -1), (-1, 0)]


def landings(world, cell, hop):
    """Where a hop lands, with its probabilities: the law of docs/model.md, written again."""
    x, y = cell
    intended, stuck, sideways, _ = world.soils[world.soil[y, x]]
    slope = np.array([world.slope_east[y, x], world.slope_north[y, x]])
    ahead, left, right = (np.array(STEPS[(hop + turn) % 4]) for turn in (0, 3, 1))
    forwards, to_right = np.clip(slope @ ahead, 0, 1), np.clip(slope @ right, -1, 1)
    yield cell + ahead, intended * (1 - forwards)
    yield cell, intended * forwards + stuck
    yield cell + left, sideways * (1 - to_right)
    yield cell + right, sideways * (1 + to_right)


def by_quantecon(world):
    """Values and hops of free cells; one more state than cells ends every mission."""
    height, width = world.payoff.shape
    end = height * width
    rewards, states, actions, rows, columns, chances = [], [], [], [], [], []
    for y, x in np.ndindex(height, width):
        if world.goal[y, x] or world.lost[y, x]:
            continue
        _, _, _, wait = world.soils[world.soil[y, x]]
        then = 1 - wait + wait * world.discount
        for hop in range(4):
            reward, pair = wait * world.payoff[y, x], len(rewards)
            ends = 1 - then
            for (to_x, to_y), chance in landings(world, np.array([x, y]), hop):
                if not (0 <= to_x < width and 0 <= to_y < height):
                    to_x, to_y = (x, y) if world.leaving == "stays" else (None, None)
                is_lost = to_x is None or world.lost[to_y, to_x]
                reward += then * chance * (world.loss if is_lost else world.payoff[to_y, to_x])
                if is_lost or world.goal[to_y, to_x]:
                    ends += then * chance
                else:
                    rows.append(pair), columns.append(to_y * width + to_x), chances.append(then * chance)
            rows.append(pair), columns.append(end), chances.append(ends)
            rewards.append(world.discount * reward), states.append(y * width + x), actions.append(hop)
    # Cells where the mission is over, and the end itself, lead to the end and pay nothing.
    for state in {*range(end + 1)} - {*states}:
        rows.append(len(rewards)), columns.append(end), chances.append(1.0)
        rewards.append(0.0), states.append(state), actions.append(0)
    matrix = sparse.csr_matrix((chances, (rows, columns)), shape=(len(rewards), end + 1))
    result = DiscreteDP(np.array(rewards), matrix, world.discount, states, actions).solve(method="policy_iteration")
    return result.v[:end].reshape(height, width), result.sigma[:end].reshape(height, width)


def random_world(seed):
    random = np.random.default_rng(seed)
    shape = tuple(random.integers(6, 15, size=2))
    goal = np.zeros(shape, bool)
    goal[tuple(random.integers(shape))] = True
    payoff = np.where(goal, 100.0, -random.random(shape))
    lost = (random.random(shape) < 0.1) & ~goal
    return hopper.World(
        payoff, goal, lost, *random.uniform(-1.2, 1.2, size=(2, *shape)), random.integers(2, size=shape),
        soils=((0.9, 0.0, 0.05, 0.0), (0.7, 0.1, 0.1, 0.5)), discount=0.97, loss=-20.0,
        leaving=["stays", "loses"][seed % 2],
    )


worlds, farthest, cells, equal = 20, 0.0, 0, 0
for seed in range(worlds):
    world = random_world(seed)
    values, policy, bound = hopper.solve(world, error_max=1e-9)
    expected, hops = by_quantecon(world)
    free = ~world.goal & ~world.lost
    distance = np.abs(values - expected)[free].max()
    # Policy iteration solves linear systems to about 1e-12 of values up to 100.
    assert distance <= bound + 1e-10, f"world {seed}: {distance} apart, the bound is {bound}"
    farthest, cells, equal = max(farthest, distance), cells + free.sum(), equal + (policy == hops + 1)[free].sum()
print(json.dumps({"worlds": worlds, "farthest": farthest, "cells": int(cells), "equal_hops": int(equal)}))
