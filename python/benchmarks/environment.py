"""Environment steps a second in this process: Hopper-v0 as a vector environment, and gymnasium's CartPole-v1 beside it."""

import time
import warnings

import gymnasium
import numpy as np

import hopper.gym  # noqa: F401, registers the environment

ENVIRONMENTS, STEPS = 1024, 500

warnings.simplefilter("ignore")
for name, actions, arguments in [
    ("Hopper-v0", 5, {"scenario": "hard", "window": 11}),
    ("Hopper-v0", 5, {"scenario": "hard", "window": 11, "copy": False}),
    ("CartPole-v1", 2, {}),
]:
    env = gymnasium.make_vec(name, num_envs=ENVIRONMENTS, vectorization_mode="vector_entry_point", **arguments)
    env.reset(seed=1)
    chosen = np.random.default_rng(1).integers(actions, size=(STEPS, ENVIRONMENTS))
    rates = []
    for _ in range(5):
        since = time.perf_counter()
        for each in chosen:
            env.step(each)
        rates.append(ENVIRONMENTS * STEPS / (time.perf_counter() - since))
    print(f"{name:12} {arguments}: {np.median(rates) / 1e6:.2f} million steps a second")
