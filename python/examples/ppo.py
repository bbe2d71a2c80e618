"""Trains PPO of stable-baselines3 on `hard`, and flies it beside `mdp` and `greedy`: `python ppo.py --help`.

Needs `pip install ./python[gym] stable-baselines3`. One thread. Prints the learning curve and the comparison as JSON.
"""

import argparse
import json
import sys
import time

import gymnasium
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import VecNormalize

import hopper
from hopper.gym import HopperEnv, HopperVectorEnv

SCENARIO, WINDOW, GAMMA = "hard", 11, 0.99

#: First seeds of missions that nothing is learned from: of the learning curve, and of the comparison.
CURVE, COMPARISON = 10**6, 2 * 10**6


class Approach(gymnasium.Wrapper):
    """Pays `weight` for each cell nearer to the goal, and takes it for each cell farther. For training alone."""

    def __init__(self, env, weight):
        super().__init__(env)
        self.weight, self.cells = weight, 0.0

    def reset(self, **arguments):
        observation, info = self.env.reset(**arguments)
        self.cells = np.abs(observation["numbers"][2:4]).sum()
        return observation, info

    def step(self, action):
        observation, reward, terminated, truncated, info = self.env.step(action)
        before, self.cells = self.cells, np.abs(observation["numbers"][2:4]).sum()
        return observation, reward + self.weight * float(before - self.cells), terminated, truncated, info


def fly(model, normalize, seed, missions):
    """Flies a mission for each seed from `seed` on; success and steps of each."""
    env = HopperVectorEnv(missions, scenario=SCENARIO, window=WINDOW)
    observation, _ = env.reset(seed=seed)
    flying, success = np.ones(missions, bool), np.zeros(missions, bool)
    steps = np.zeros(missions, int)
    while flying.any():
        actions, _ = model.predict(normalize(observation), deterministic=True)
        observation, _, terminated, truncated, _ = env.step(actions)
        for index in np.flatnonzero(flying & (terminated | truncated)):
            _, steps[index], _, status = env.told(index)
            success[index] = status == "goal"
        flying &= ~(terminated | truncated)
    return success, steps


def fly_built_in(planner, seed, missions):
    """The same missions, flown by a planner that plans."""
    flights = [hopper.run(SCENARIO, planner, seed=seed + index).summary for index in range(missions)]
    return np.array([each["outcome"] == "goal" for each in flights]), np.array([each["steps"] for each in flights])


class Curve(BaseCallback):
    """Success on missions that are not trained on, after every `every` steps."""

    def __init__(self, every):
        super().__init__()
        self.every, self.points = every, []

    def _on_step(self):
        if self.num_timesteps >= len(self.points) * self.every:
            success, steps = fly(self.model, self.training_env.normalize_obs, CURVE, 200)
            point = {"steps": self.num_timesteps, "cpu_s": round(time.process_time()), "success": success.mean()}
            self.points.append(point)
            print(json.dumps(point), file=sys.stderr, flush=True)
        return True


def told(success, steps):
    """What a planner came to; missions that failed count the step limit in the restricted mean."""
    return {
        "missions": len(success),
        "success": success.mean(),
        "steps_of_successes": steps[success].mean() if success.any() else None,
        "restricted_mean_steps": np.where(success, steps, 150).mean(),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=2_000_000, help="environment steps to train on")
    parser.add_argument("--approach", type=float, default=0.0, help="paid for each cell nearer to the goal, in training")
    parser.add_argument("--missions", type=int, default=1000, help="missions of the comparison")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    torch.set_num_threads(1)

    env = make_vec_env(
        lambda: Approach(HopperEnv(scenario=SCENARIO, window=WINDOW), arguments.approach), n_envs=32, seed=arguments.seed
    )
    env = VecNormalize(env, gamma=GAMMA)
    model = PPO(
        "MultiInputPolicy", env, gamma=GAMMA, n_steps=128, batch_size=512, n_epochs=4, ent_coef=0.01,
        seed=arguments.seed, device="cpu",
    )
    curve = Curve(max(1, arguments.steps // 20))
    model.learn(arguments.steps, callback=curve)
    env.training = False
    results = {"ppo": told(*fly(model, env.normalize_obs, COMPARISON, arguments.missions))}
    for planner in ["mdp", "greedy"]:
        results[planner] = told(*fly_built_in(planner, COMPARISON, arguments.missions))
    print(json.dumps({"arguments": vars(arguments), "curve": curve.points, "comparison": results}, indent=1))


if __name__ == "__main__":
    main()
