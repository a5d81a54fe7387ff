"""CartPole's agent alone, without a simulator: what is learned with it, and how long it stays up."""

import re

import gymnasium

from netmq_example.scene.agent import begin
from netmq_example.wire.split_mix import draws
from netmq_example.worlds import cross_entropy
from netmq_example.worlds.cart_pole import DT, CartPole


class Bare(gymnasium.Env):  # type: ignore[name-defined]
    """As trainers use an environment of it."""

    observation_space, action_space = CartPole.observation, CartPole.action

    def reset(self, *, seed=None, options=None):
        self.pole = CartPole()
        begin(self.pole, draws(seed), {}, [])
        self.pole.on_reset()
        return self.pole.observe(), {}

    def step(self, action):
        self.pole.on_action(action)
        self.pole.on_tick(DT)
        self.pole.on_stepped()
        return self.pole.observe(), 1.0, self.pole.terminated, False, {}


def trained(caplog, seed, generations):
    """The lines of a training, without how fast it was; and how many episodes there were."""
    env, steps = gymnasium.wrappers.TimeLimit(Bare(), cross_entropy.STEPS), []
    caplog.set_level("INFO", "netmq_example")
    caplog.clear()

    def play(policy, seed):
        steps.append(cross_entropy.play(env, policy, seed))
        return steps[-1]

    means = cross_entropy.train(lambda episodes: [play(*each) for each in episodes], seed, generations)
    lines = timeless(caplog.messages)
    assert lines[-2] == (f"generation {len(means)}: mean {means[-1]:.1f} of 200, {sum(steps):,} steps")
    return lines, len(steps)


def timeless(lines):
    """The lines that must be equal: without the steps a second, and without what others say of a process that died."""
    return [re.sub(", [0-9,]+ a second", "", line) for line in lines if re.match("generation|policy", line)]


def returns(episodes):
    """The returns that lesson 17's train.py reaches with each seed."""
    env, found = Bare(), []
    for seed in range(episodes):
        (seen, _), over = env.reset(seed=seed), False
        found.append(0)
        while not over:
            seen, _, over, *_ = env.step(int(seen[2] > 0))
            found[-1] += 1
    return found
