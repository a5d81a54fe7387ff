"""The types of mlagents_envs.base_env, with its names: what is seen and done by the agents whose turn it is.

    steps.obs[0]                    one array for each observation, [agents, …], float32
    steps[7].reward                 of the agent with the id 7; `7 in steps` says whether it is there
    ActionTuple(continuous=floats, discrete=whole_numbers)      each [agents, size]

BaseEnv is what a wrapper or a trainer needs of an environment; environment.py has one. It needs numpy.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping

from netmq_example.mlagents_envs.specs import (
    ActionSpec,
    ActionTuple,
    BehaviorMapping,
    BehaviorName,
    BehaviorSpec,
    DimensionProperty,
    ObservationSpec,
    ObservationType,
)
from netmq_example.mlagents_envs.specs import _ActionTupleBase as _ActionTupleBase
from netmq_example.mlagents_envs.steps import (
    AgentId,
    BatchedStepResult,
    DecisionStep,
    DecisionSteps,
    GroupId,
    TerminalStep,
    TerminalSteps,
)

__all__ = [
    "ActionSpec",
    "ActionTuple",
    "AgentId",
    "BaseEnv",
    "BatchedStepResult",
    "BehaviorMapping",
    "BehaviorName",
    "BehaviorSpec",
    "DecisionStep",
    "DecisionSteps",
    "DimensionProperty",
    "GroupId",
    "ObservationSpec",
    "ObservationType",
    "TerminalStep",
    "TerminalSteps",
]


class BaseEnv(ABC):
    """An environment of several behaviors, each of many agents. A step goes on until one of them wants an action."""

    @abstractmethod
    def step(self) -> None:
        """Go on with the actions that were set; of whom none was set, it is zeros."""

    @abstractmethod
    def reset(self) -> None:
        """Begin all episodes anew."""

    @abstractmethod
    def close(self) -> None:
        """End the simulator, and the connection."""

    @property
    @abstractmethod
    def behavior_specs(self) -> Mapping[str, BehaviorSpec]:
        """What is seen and done, by behavior; later ones are added."""

    @abstractmethod
    def set_actions(self, behavior_name: BehaviorName, action: ActionTuple) -> None:
        """Of all agents of the DecisionSteps, in their order, for the next step."""

    @abstractmethod
    def set_action_for_agent(self, behavior_name: BehaviorName, agent_id: AgentId, action: ActionTuple) -> None:
        """Of one agent; its arrays have one row."""

    @abstractmethod
    def get_steps(self, behavior_name: BehaviorName) -> tuple[DecisionSteps, TerminalSteps]:
        """Of the agents that want an action, and of those that have ended in the last step."""
