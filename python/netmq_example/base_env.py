"""The types of mlagents_envs.base_env, with its names: what is seen and done by the agents whose turn it is.

    steps.obs[0]                    one array for each observation, [agents, …]
    steps[7].reward                 of the agent with the id 7; `7 in steps` says whether it is there
    ActionTuple(continuous=floats, discrete=whole_numbers)      each [agents, size]

environment.py uses them. It needs numpy and gymnasium.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from gymnasium.spaces import Space


class ActionTuple:
    """float32 and int32, [agents, size]; what is not given has size 0."""

    def __init__(self, continuous: Any = None, discrete: Any = None) -> None:
        given: Any = next((part for part in (continuous, discrete) if part is not None), [[]])
        nothing = np.zeros((len(given), 0))
        self.continuous = np.asarray(nothing if continuous is None else continuous, np.float32)
        self.discrete = np.asarray(nothing if discrete is None else discrete).astype(np.int32)
        if discrete is not None and not np.array_equal(self.discrete, discrete):
            raise ValueError(f"discrete actions are whole numbers, not {discrete!r:.60}")


class ActionSpec(NamedTuple):
    """How many floats, and for each whole number how many choices there are."""

    continuous_size: int
    discrete_branches: tuple[int, ...]

    def empty_action(self, n_agents: int) -> ActionTuple:
        return ActionTuple(
            np.zeros((n_agents, self.continuous_size)), np.zeros((n_agents, len(self.discrete_branches)))
        )

    def random_action(self, n_agents: int) -> ActionTuple:
        chance = np.random.default_rng()
        floats = chance.uniform(-1, 1, (n_agents, self.continuous_size))
        return ActionTuple(
            floats, chance.integers(self.discrete_branches, size=(n_agents, len(self.discrete_branches)))
        )


class BehaviorSpec(NamedTuple):
    """Each observation's space, in the order of `obs`, and what an action is made of."""

    observation_specs: list[Space[Any]]
    action_spec: ActionSpec


@dataclass
class DecisionSteps(Mapping[int, Any]):
    """Of the agents that want an action, by their ids."""

    obs: list[Any]
    reward: Any
    agent_id: Any

    def __len__(self) -> int:
        return len(self.agent_id)

    def __iter__(self) -> Iterator[int]:
        return iter(self.agent_id.tolist())

    def __getitem__(self, agent_id: int) -> Any:
        """The same of one agent, without the first dimension."""
        at = {found: at for at, found in enumerate(self)}[agent_id]
        _, *rest = vars(self).values()
        return type(self)([seen[at] for seen in self.obs], *(values[at] for values in rest))


@dataclass
class TerminalSteps(DecisionSteps):
    """Of the agents whose episode has ended; `interrupted` says that it was truncated."""

    interrupted: Any


class BatchedStepResult(NamedTuple):
    """Both together, as early in 2020."""

    obs: list[Any]
    reward: Any
    done: Any
    max_step: Any
    agent_id: Any

    def n_agents(self) -> int:
        return len(self.agent_id)
