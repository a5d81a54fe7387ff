"""ML-Agents' low-level API over a scene's only agent: mlagents_envs.environment, with its names.

    env = UnityEnvironment(side_channels=[log])          prints: waiting for a simulator on tcp://…: press Play
    env.reset()
    name = list(env.behavior_specs)[0]
    decision_steps, terminal_steps = env.get_steps(name)
    env.set_actions(name, ActionTuple(discrete=[[1]]))   for the next step; without it: zeros
    env.step()

As there, the step that ends an episode begins the next one, whose agent has another id. The simulator's action is a
Box, Discrete or MultiDiscrete, its observation one array, or a Dict of arrays. It needs gymnasium.
"""

import contextlib
import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from netmq_example.extras import without

try:
    import numpy as np
    from gymnasium import spaces
except ImportError as error:
    raise without(error) from None

from netmq_example import check
from netmq_example.envs.gym_env import UnityGymEnv
from netmq_example.envs.remote import Remote
from netmq_example.envs.side_channels import carry
from netmq_example.errors import Lost
from netmq_example.messages import Message, take
from netmq_example.mlagents_envs.base_env import (
    ActionSpec,
    ActionTuple,
    AgentId,
    BatchedStepResult,
    BehaviorName,
    BehaviorSpec,
    DecisionSteps,
    DimensionProperty,
    ObservationSpec,
    ObservationType,
    TerminalSteps,
)
from netmq_example.mlagents_envs.exception import (
    UnityActionException,
    UnityCommunicatorStoppedException,
    UnityEnvironmentException,
    UnityTimeOutException,
    UnityWorkerInUseException,
)
from netmq_example.mlagents_envs.side_channel.side_channel import Channel
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager

__all__ = ["UnityEnvironment"]


class OneAgent(UnityGymEnv):
    """An environment that takes any simulator's name."""

    def find(self, remote: Remote) -> None:
        def accept(hello: Message) -> None:
            remote.name = take(hello.values, "name", str)
            Remote.accept(remote, hello)

        # Also for the simulators that come after the first one.
        vars(remote)["accept"] = accept
        super().find(remote)


class UnityEnvironment:
    """`file_name` is a build to launch, on a free port; without it Play is waited for, `timeout_wait` seconds.

    `max_episode_steps` is the agent's Max Step: the step with that number ends its episode, interrupted. A step whose
    simulator is lost raises UnityCommunicatorStoppedException, and the next reset waits for another one, or launches
    it. UnityTimeOutException says that none came, MessageError what one refuses.
    """

    # Lesson 09's. Another base_port is one that the component in Unity has to have, too.
    DEFAULT_EDITOR_PORT = 5559

    def __init__(
        self,
        file_name: str | None = None,
        worker_id: int = 0,
        base_port: int | None = None,
        seed: int = 0,
        no_graphics: bool = False,
        timeout_wait: float = 60,
        additional_args: Sequence[str] | None = None,
        side_channels: Sequence[Channel] | None = None,
        max_episode_steps: int | None = None,
    ) -> None:
        port = (self.DEFAULT_EDITOR_PORT if base_port is None else base_port) + worker_id
        where: dict[str, Any] = {"endpoint": f"tcp://127.0.0.1:{port}"}
        self.launched = file_name is not None
        if file_name is not None:
            check.instance("file_name", file_name, str, os.PathLike)
            where = {"launch": [file_name, *["-batchmode", "-nographics"] * no_graphics, *(additional_args or ())]}
        # 0 is no limit, as for Max Step.
        self.max_episode_steps = check.count("max_episode_steps", max_episode_steps or 0, least=0)
        with self.naming():
            self.env = OneAgent("Agent", wait=timeout_wait, **where)
        if side_channels:
            carry(self.env, SideChannelManager([*side_channels]))
        self.seed: int | None = seed
        self.name = f"{self.env.remote.name}?team=0"
        self.actions = action_spec(self.env.action_space)
        self.behavior_specs = {self.name: BehaviorSpec(seen_specs(self.env.observation_space), self.actions)}
        self.action = self.actions.empty_action(1)
        self.agent_id = -1
        self.steps = 0
        self.now: DecisionSteps | None = None
        self.over: TerminalSteps | None = None

    def reset(self) -> None:
        with self.naming():
            seen, _ = self.env.reset(seed=self.seed)
        self.seed, self.over, self.steps = None, None, 0
        self.agent_id += 1
        self.now = self.decisions(seen, 0.0)

    def step(self) -> None:
        if self.now is None:
            # As there: the first step is a reset.
            self.reset()
            return
        seen, reward, terminated, truncated, info = self.env.step(written(self.env.action_space, self.action))
        self.action, self.over = self.actions.empty_action(1), None
        if not self.env.simulators.connection.peer:
            self.now = None
            raise UnityCommunicatorStoppedException(
                f"the simulator is lost: {info['lost']}; reset waits for another one"
            )
        self.steps += 1
        self.now = self.decisions(seen, reward)
        interrupted = not terminated and (truncated or self.steps == self.max_episode_steps)
        if terminated or interrupted:
            seen, rewards, ids = self.one(seen, reward)
            over = TerminalSteps(seen, rewards, np.array([interrupted]), ids, np.zeros(1, int), np.zeros(1))
            self.reset()
            self.over = over

    @contextlib.contextmanager
    def naming(self) -> Iterator[None]:
        """The errors while a simulator is found have ML-Agents' names."""
        try:
            yield
        except TimeoutError as error:
            raise UnityTimeOutException(str(error)) from None
        except Lost as error:
            raise UnityCommunicatorStoppedException(f"the simulator is lost: {error}") from None
        except OSError as error:
            if self.launched:
                raise UnityEnvironmentException(str(error)) from None
            raise UnityWorkerInUseException(0, str(error)) from None

    def decisions(self, seen: Any, reward: float) -> DecisionSteps:
        masks = [np.zeros((1, choices), bool) for choices in self.actions.discrete_branches] or None
        return DecisionSteps(*self.one(seen, reward), masks, np.zeros(1, int), np.zeros(1))

    def one(self, seen: Any, reward: float) -> tuple[list[Any], Any, Any]:
        return (
            [np.asarray(part)[None] for part in parts(seen)],
            np.array([reward], np.float32),
            np.array([self.agent_id]),
        )

    def get_steps(self, behavior_name: BehaviorName) -> tuple[DecisionSteps, TerminalSteps]:
        self.check_name(behavior_name)
        if self.now is None:
            raise ValueError("call reset before get_steps")
        nobody = TerminalSteps.empty(self.behavior_specs[behavior_name])
        return self.now, self.over or nobody

    def set_actions(self, behavior_name: BehaviorName, action: Any) -> None:
        self.check_name(behavior_name)
        if not isinstance(action, ActionTuple):
            # An array, as early in 2020.
            action = ActionTuple(action) if self.actions.continuous_size else ActionTuple(discrete=action)
        wanted = self.actions.empty_action(1)
        if (action.continuous.shape, action.discrete.shape) != (wanted.continuous.shape, wanted.discrete.shape):
            got = f"{action.continuous.shape} and {action.discrete.shape}"
            raise UnityActionException(
                f"an action is {wanted.continuous.shape} floats, {wanted.discrete.shape} integers, not {got}"
            )
        self.action = action

    def set_action_for_agent(self, behavior_name: BehaviorName, agent_id: AgentId, action: Any) -> None:
        if self.now is None or agent_id not in self.now:
            raise UnityActionException(f"no agent {agent_id} wants an action; there is: {self.agent_id}")
        self.set_actions(behavior_name, action)

    def check_name(self, behavior_name: BehaviorName) -> None:
        if behavior_name not in self.behavior_specs:
            raise UnityActionException(f"there is no behavior {behavior_name!a:.40}; there is: {self.name}")

    def get_behavior_names(self) -> list[str]:
        return [self.name]

    # Early in 2020.
    get_agent_groups = get_behavior_names

    def get_step_result(self, agent_group_name: str) -> BatchedStepResult:
        now, over = self.get_steps(agent_group_name)
        obs = [np.concatenate(both) for both in zip(over.obs, now.obs, strict=True)]
        done = np.arange(len(over) + 1) < len(over)
        max_step = np.append(over.interrupted, False)
        ids = np.append(over.agent_id, now.agent_id)
        return BatchedStepResult(obs, np.append(over.reward, now.reward), done, max_step, ids, None)

    def close(self) -> None:
        self.env.close()


def seen_specs(space: Any) -> list[ObservationSpec]:
    names = space if isinstance(space, Mapping) else ["observation"]
    return [
        ObservationSpec(part.shape, (DimensionProperty.NONE,) * len(part.shape), ObservationType.DEFAULT, name)
        for name, part in zip(names, parts(space), strict=True)
    ]


def parts(whole: Any) -> list[Any]:
    """The parts of a space or of an observation that have an array each in `obs`."""
    return list(whole.values()) if isinstance(whole, Mapping) else [whole]


def action_spec(space: Any) -> ActionSpec:
    if isinstance(space, spaces.Box):
        return ActionSpec(int(np.prod(space.shape)), ())
    if isinstance(space, spaces.Discrete | spaces.MultiDiscrete):
        return ActionSpec(0, tuple(np.ravel(space.n if isinstance(space, spaces.Discrete) else space.nvec).tolist()))
    raise ValueError(f"ML-Agents has no action {space!s:.80}: take gymnasium.make")


def written(space: Any, action: ActionTuple) -> Any:
    """As the space has it, in which whole numbers may begin elsewhere than at 0."""
    if isinstance(space, spaces.Box):
        return action.continuous.reshape(space.shape).astype(space.dtype)
    return (action.discrete.ravel() + np.ravel(space.start)).reshape(space.shape).astype(space.dtype)[()]
