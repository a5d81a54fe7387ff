"""UnityToGymWrapper, as mlagents_envs.envs.unity_gym_env has it: one agent, with the four values of gym's step.

    env = UnityToGymWrapper(UnityEnvironment("Build/Game"), allow_multiple_obs=True)
    seen = env.reset()
    seen, reward, done, info = env.step(env.action_space.sample())

It needs gym or Gymnasium for its spaces, and no more of them. Libraries of today want five values: UnityGymEnv of
netmq_example.envs has them.
"""

import itertools
import sys
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from netmq_example.mlagents_envs import logging_util
from netmq_example.mlagents_envs.base_env import ActionTuple, BaseEnv, DecisionSteps, TerminalSteps
from netmq_example.mlagents_envs.envs.env_helpers import action_space, find_spaces
from netmq_example.mlagents_envs.exception import UnityException

logger = logging_util.get_logger(__name__)

# A program that knows gym may ask whether this is one of its environments.
Env: Any = getattr(sys.modules.get("gym"), "Env", object)
GymStepResult = tuple[Any, float, bool, dict[str, Any]]


class UnityGymException(UnityException):
    """The scene does not fit into gym, or a step after the end of an episode."""


class UnityToGymWrapper(Env):  # type: ignore[misc]
    """Its constructor resets the environment, and its close closes it.

    Of several observations the first picture is seen, or without one all vectors as one; with `allow_multiple_obs` a
    list of all pictures and, last, the vectors. With `uint8_visual` pictures are whole numbers up to 255.
    `flatten_branched` makes one choice of several.
    """

    reward_range = (-float("inf"), float("inf"))
    metadata: ClassVar[dict[str, list[str]]] = {"render.modes": ["rgb_array"]}

    def __init__(
        self,
        unity_env: BaseEnv,
        uint8_visual: bool = False,
        flatten_branched: bool = False,
        allow_multiple_obs: bool = False,
        action_space_seed: int | None = None,
    ) -> None:
        self._env = unity_env
        self._allow_multiple_obs = allow_multiple_obs
        self._flattener: ActionFlattener | None = None
        self.game_over = False
        self.visual_obs: Any = None
        unity_env.reset()
        if len(unity_env.behavior_specs) != 1:
            raise UnityGymException(f"gym has one behavior, and the scene {len(unity_env.behavior_specs)}")
        self.name, self.group_spec = next(iter(unity_env.behavior_specs.items()))
        shapes = [spec.shape for spec in self.group_spec.observation_specs]
        self.pictures = [shape for shape in shapes if len(shape) == 3]
        self.vector_size = sum(shape[0] for shape in shapes if len(shape) == 1)
        if not self.pictures and not self.vector_size:
            raise UnityGymException("the agent observes neither a picture nor a vector")
        self.uint8_visual = uint8_visual and bool(self.pictures)
        if uint8_visual and not self.pictures:
            logger.warning("uint8_visual does nothing: the agent observes no picture")
        if len(self.pictures) + bool(self.vector_size) > 1 and not allow_multiple_obs:
            logger.warning("only the first picture is seen: allow_multiple_obs=True shows all observations")
        spec = self.group_spec.action_spec
        if spec.is_continuous() == spec.is_discrete():
            raise UnityGymException("gym's actions are continuous or discrete, and this agent's are both, or nothing")
        if flatten_branched and spec.is_continuous():
            logger.warning("flatten_branched does nothing: the action is continuous")
        self.action_size = spec.continuous_size or spec.discrete_size
        spaces = find_spaces()
        self.action_space = action_space(spaces, spec)
        if flatten_branched and spec.discrete_size > 1:
            self._flattener = ActionFlattener(spec.discrete_branches)
            self.action_space = self._flattener.action_space
        if action_space_seed is not None:
            self.action_space.seed(action_space_seed)
        high, dtype = (255, np.uint8) if self.uint8_visual else (1, np.float32)
        each = [spaces.Box(0, high, shape, dtype) for shape in self.pictures]
        if self.vector_size:
            each.append(spaces.Box(-np.inf, np.inf, (self.vector_size,), np.float32))
        self.observation_space = spaces.Tuple(each) if allow_multiple_obs else each[0]
        self._single_step(unity_env.get_steps(self.name)[0])

    def reset(self) -> Any:
        self._env.reset()
        self.game_over = False
        return self._single_step(self._env.get_steps(self.name)[0])[0]

    def step(self, action: Any) -> GymStepResult:
        """The info has ML-Agents' own rows, `info["step"]`, with the action mask."""
        if self.game_over:
            raise UnityGymException("the episode is over: call reset before the next step")
        if self._flattener is not None:
            action = self._flattener.lookup_action(action)
        action = np.array(action).reshape(1, self.action_size)
        continuous = self.group_spec.action_spec.is_continuous()
        self._env.set_actions(self.name, ActionTuple(action) if continuous else ActionTuple(discrete=action))
        self._env.step()
        decisions, ends = self._env.get_steps(self.name)
        self.game_over = len(ends) > 0
        return self._single_step(ends if self.game_over else decisions)

    def _single_step(self, info: DecisionSteps | TerminalSteps) -> GymStepResult:
        if len(info) != 1:
            raise UnityGymException(f"gym has one agent, and the scene {len(info)} whose turn it is")
        seen = [obs[0] for obs in info.obs if obs.ndim == 4]
        if self.uint8_visual:
            seen = [(255.0 * picture).astype(np.uint8) for picture in seen]
        if seen:
            self.visual_obs = seen[0]
        if self.vector_size:
            seen.append(np.concatenate([obs[0] for obs in info.obs if obs.ndim == 2]))
        done = isinstance(info, TerminalSteps)
        return seen if self._allow_multiple_obs else seen[0], float(info.reward[0]), done, {"step": info}

    def render(self, mode: str = "rgb_array") -> Any:
        """The picture that was seen last; nothing is rendered anew."""
        return self.visual_obs

    def seed(self, seed: Any = None) -> None:
        logger.warning("a seed is given to UnityEnvironment(seed=…), when it is made")

    def close(self) -> None:
        self._env.close()


class ActionFlattener:
    """One choice, in place of several: each combination of them has a number."""

    def __init__(self, branched_action_space: Sequence[int]) -> None:
        combinations = itertools.product(*map(range, branched_action_space))
        self.action_lookup = {number: [*each] for number, each in enumerate(combinations)}
        self.action_space = find_spaces().Discrete(len(self.action_lookup))

    def lookup_action(self, action: Any) -> list[int]:
        return self.action_lookup[int(action)]
