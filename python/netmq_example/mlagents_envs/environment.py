"""ML-Agents' low-level API: mlagents_envs.environment, with its names.

    env = UnityEnvironment(side_channels=[log])          prints: waiting for a simulator on tcp://…: press Play
    env.reset()
    name = list(env.behavior_specs)[0]
    decision_steps, terminal_steps = env.get_steps(name)
    env.set_actions(name, ActionTuple(discrete=[[1]]))   for the next step; without it: zeros
    env.step()

A scene of ML-Agents' shape has its own clock: a step goes on until an agent wants an action, or has ended. All other
scenes, those of lessons 09 to 11 in C# or Python, go by Python's: all agents act in each step, and whoever ends begins
anew within it; this needs gymnasium. In both an agent keeps its id over its episodes.
"""

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from netmq_example import check
from netmq_example.mlagents_envs.base_env import (
    ActionTuple,
    AgentId,
    BaseEnv,
    BatchedStepResult,
    BehaviorMapping,
    BehaviorName,
    BehaviorSpec,
    DecisionSteps,
    TerminalSteps,
)
from netmq_example.mlagents_envs.clock import Turn
from netmq_example.mlagents_envs.env_utils import is_player, launch_words
from netmq_example.mlagents_envs.exception import (
    NoRequest,
    NoSteps,
    UnityActionException,
    UnityCommunicatorStoppedException,
    UnityEnvironmentException,
    UnityException,
    UnityTimeOutException,
)
from netmq_example.mlagents_envs.side_channel import DefaultTrainingAnalyticsSideChannel
from netmq_example.mlagents_envs.side_channel.side_channel import SideChannel
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager
from netmq_example.mlagents_envs.specs import as_tuple
from netmq_example.mlagents_envs.steps import batched

__all__ = [
    "ActionTuple",
    "AgentId",
    "BaseEnv",
    "BehaviorMapping",
    "BehaviorName",
    "BehaviorSpec",
    "DecisionSteps",
    "DefaultTrainingAnalyticsSideChannel",
    "SideChannel",
    "SideChannelManager",
    "TerminalSteps",
    "UnityActionException",
    "UnityCommunicatorStoppedException",
    "UnityEnvironment",
    "UnityEnvironmentException",
    "UnityTimeOutException",
]


ANALYTICS = DefaultTrainingAnalyticsSideChannel.CHANNEL_ID


class UnityEnvironment(BaseEnv):
    """`file_name` is a build to launch, on a free port; without it Play is waited for, on `base_port` + `worker_id`.

    `timeout_wait` seconds may pass until a simulator is there, and in each step. A step whose simulator is lost raises
    UnityCommunicatorStoppedException, and the next reset waits for another one, or launches it. A step that Ctrl-C
    has interrupted is done to its end by the next one.

    `channels_first=False` gives pictures as [height, width, channels], as ML-Agents had them before 2024. By Python's
    clock `max_episode_steps` is the agents' Max Step: the step with that number ends an episode, interrupted; and the
    two spaces are those of agents by attributes whose scene says none.
    """

    # Of ML-Agents' two halves, which trainers show.
    API_VERSION = "1.5.0"
    DEFAULT_EDITOR_PORT = 5004
    BASE_ENVIRONMENT_PORT = 5005

    def __init__(
        self,
        file_name: str | os.PathLike[str] | None = None,
        worker_id: int = 0,
        base_port: int | None = None,
        seed: int = 0,
        no_graphics: bool = False,
        no_graphics_monitor: bool = False,
        timeout_wait: float = 60,
        additional_args: Sequence[str] | None = None,
        side_channels: Sequence[Any] | None = None,
        log_folder: str | os.PathLike[str] | None = None,
        num_areas: int = 1,
        *,
        max_episode_steps: int | None = None,
        channels_first: bool = True,
        observation_space: Any = None,
        action_space: Any = None,
    ) -> None:
        if check.count("num_areas", num_areas) > 1:
            raise UnityEnvironmentException(
                f"num_areas={num_areas}: nothing copies areas here, put them into the scene"
            )
        self._worker_id = check.count("worker_id", worker_id, least=0)
        self._no_graphics = no_graphics or (no_graphics_monitor and worker_id != 0)
        self._log_folder = log_folder
        self._additional_args = [*(additional_args or ())]
        self._side_channel_manager = SideChannelManager(
            # Nothing is told to Unity's analytics.
            [one for one in side_channels or () if getattr(one, "channel_id", None) != ANALYTICS]
        )
        where: dict[str, Any] = {"wait": timeout_wait, "timeout": timeout_wait}
        if file_name is None:
            port = self.DEFAULT_EDITOR_PORT if base_port is None else base_port
            where["endpoint"] = f"tcp://127.0.0.1:{port + worker_id}"
        else:
            check.instance("file_name", file_name, str, os.PathLike)
            program = launch_words(os.fspath(file_name))
            if not is_player(program[-1]):
                # Another program would not know the word for it.
                self._log_folder = None
            where["launch"] = [*program, *self._executable_args()]
        words = {
            "seed": check.count("seed", seed, least=-(2**31)),
            # 0 is no limit, as for Max Step.
            "limit": check.count("max_episode_steps", max_episode_steps or 0, least=0),
            "channels_first": channels_first,
            "given": (observation_space, action_space),
        }
        # Not before it is needed: its modules register environments with Gymnasium.
        from netmq_example.mlagents_envs.link import Capabilities, Link

        self._link = Link(self._side_channel_manager, where, self._worker_id, words)
        self._clock = self._link.start(self)
        self.academy_capabilities = Capabilities()
        self._actions: dict[BehaviorName, ActionTuple] = {}
        # Those whose arrays are not the caller's.
        self._own: set[BehaviorName] = set()
        self._begun = False

    def _executable_args(self) -> list[str]:
        """The words of a build; --endpoint follows them."""
        words = ["-nographics", "-batchmode"] if self._no_graphics else []
        if self._log_folder and "-logfile" not in [str(word).lower() for word in self._additional_args]:
            words += ["-logFile", os.path.join(self._log_folder, f"Player-{self._worker_id}.log")]
        return words + self._additional_args

    @property
    def _loaded(self) -> bool:
        return not self._link.simulators.connection.closed

    @property
    def _port(self) -> int:
        return int(self._link.simulators.connection.endpoint.rpartition(":")[2])

    @property
    def _process(self) -> Any:
        return self._link.simulators.process

    @property
    def _env_specs(self) -> dict[BehaviorName, BehaviorSpec]:
        return self._clock.specs

    @property
    def behavior_specs(self) -> Mapping[BehaviorName, BehaviorSpec]:
        return BehaviorMapping(self._clock.specs)

    def reset(self) -> None:
        self._check_loaded()
        self._forget_actions()
        self._begun = False
        self._link.reset(self._clock)
        self._begun = True

    def step(self) -> None:
        if not self._begun:
            return self.reset()
        self._check_loaded()
        try:
            self._link.step(self._clock, self._actions)
        except UnityException as error:
            # A wrong action has moved nothing.
            self._begun = isinstance(error, UnityActionException)
            raise
        finally:
            self._forget_actions()

    def _forget_actions(self) -> None:
        self._actions = {}
        self._own.clear()

    def _check_loaded(self) -> None:
        if not self._loaded:
            raise UnityEnvironmentException("this environment is closed: make a new one")

    def _turn(self, behavior_name: BehaviorName) -> Turn:
        """UnityActionException, if there is no such behavior."""
        if behavior_name not in self._clock.specs:
            known = ", ".join(self._clock.specs) or "none before reset"
            raise UnityActionException(f"there is no behavior {behavior_name!a:.40}; there is: {known}")
        return self._clock.turns.get(behavior_name) or Turn()

    def get_steps(self, behavior_name: BehaviorName) -> tuple[DecisionSteps, TerminalSteps]:
        turn = self._turn(behavior_name)
        if not self._begun:
            raise NoSteps("call reset before get_steps")
        return turn.steps(self._clock.specs[behavior_name])

    def set_actions(self, behavior_name: BehaviorName, action: Any) -> None:
        turn = self._turn(behavior_name)
        if not self._begun:
            return
        spec = self._clock.specs[behavior_name].action_spec
        count = 0 if turn.decisions is None else len(turn.decisions)
        action = as_tuple(action, spec.continuous_size)
        if count or np.size(action.continuous) or np.size(action.discrete):
            self._actions[behavior_name] = spec._validate_action(action, count, behavior_name)
            self._own.discard(behavior_name)

    def set_action_for_agent(self, behavior_name: BehaviorName, agent_id: AgentId, action: Any) -> None:
        turn = self._turn(behavior_name)
        if not self._begun:
            return
        spec = self._clock.specs[behavior_name].action_spec
        action = spec._validate_action(as_tuple(action, spec.continuous_size), 1, behavior_name)
        if turn.decisions is None or agent_id not in turn.decisions:
            raise NoRequest(f"agent {agent_id!r:.40} of {behavior_name} wants no action in this step")
        all_of_them = self._actions.get(behavior_name) or spec.empty_action(len(turn.decisions))
        if behavior_name not in self._own:
            all_of_them = ActionTuple(all_of_them.continuous.copy(), all_of_them.discrete.copy())
            self._own.add(behavior_name)
        at = turn.decisions.agent_id_to_index[agent_id]
        all_of_them.continuous[at] = action.continuous[0]
        all_of_them.discrete[at] = action.discrete[0]
        self._actions[behavior_name] = all_of_them

    def close(self) -> None:
        self._check_loaded()
        self._link.close()

    # Of 2020.

    def get_behavior_names(self) -> list[BehaviorName]:
        return list(self._clock.specs)

    get_agent_groups = get_behavior_names

    def get_behavior_spec(self, behavior_name: BehaviorName) -> BehaviorSpec:
        self._turn(behavior_name)
        return self._clock.specs[behavior_name]

    get_agent_group_spec = get_behavior_spec

    def get_step_result(self, agent_group_name: BehaviorName) -> BatchedStepResult:
        return batched(*self.get_steps(agent_group_name))
