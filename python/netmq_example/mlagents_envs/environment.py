"""ML-Agents' low-level API: mlagents_envs.environment, with its names.

    env = UnityEnvironment(side_channels=[log])          prints: waiting for a simulator on tcp://…: press Play
    env.reset()
    name = list(env.behavior_specs)[0]
    decision_steps, terminal_steps = env.get_steps(name)
    env.set_actions(name, ActionTuple(discrete=[[1]]))   for the next step; without it: zeros
    env.step()

A scene of ML-Agents' shape has its own clock: a step goes on until an agent wants an action, or has ended. All other
scenes, those of lessons 09 to 11 in C# or Python, go by Python's: all agents act in each step, and whoever ends begins
anew within it; this needs gymnasium. In both an agent keeps its id over its episodes. It needs pyzmq and numpy.
"""

import contextlib
import importlib
import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from netmq_example import check
from netmq_example.errors import Lost
from netmq_example.messages import Message, MessageError
from netmq_example.mlagents_envs import base_env, env_utils, exception, scene_clock

# A program finds here what it finds in ML-Agents' module.
from netmq_example.mlagents_envs.base_env import *  # noqa: F403
from netmq_example.mlagents_envs.exception import *  # noqa: F403
from netmq_example.mlagents_envs.side_channel import *  # noqa: F403
from netmq_example.mlagents_envs.side_channel.side_channel_manager import SideChannelManager


class UnityEnvironment(base_env.BaseEnv):
    """`file_name` is a build to launch, on a free port; without it Play is waited for, on `base_port` + `worker_id`.

    `timeout_wait` seconds may pass until a simulator is there, and in each step. A step whose simulator is lost raises
    UnityCommunicatorStoppedException, and the next reset waits for another one, or launches it. After a step that
    Ctrl-C has interrupted the next one is a reset.

    `channels_first=False` gives pictures as [height, width, channels], as ML-Agents had them before 2024. By Python's
    clock `max_episode_steps` is the agents' Max Step: the step with that number ends an episode, interrupted; and the
    two spaces are those of agents by attributes whose scene says none.
    """

    # Of ML-Agents' two halves, which trainers show.
    API_VERSION = "1.5.0"
    DEFAULT_EDITOR_PORT = 5004
    BASE_ENVIRONMENT_PORT = 5005
    academy_capabilities = env_utils.Capabilities()

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
            raise exception.UnityEnvironmentException("num_areas: nothing copies areas here, put them into the scene")
        self._worker_id = check.count("worker_id", worker_id, least=0)
        self._no_graphics = no_graphics or (no_graphics_monitor and worker_id != 0)
        self._log_folder = log_folder
        if isinstance(additional_args, str):
            raise TypeError(f"additional_args takes a list of words, not {additional_args!r:.40}")
        self._additional_args = [*(additional_args or ())]
        self._side_channel_manager = SideChannelManager([*(side_channels or ())])
        # 0 is no limit, as for Max Step.
        limit = check.count("max_episode_steps", max_episode_steps or 0, least=0)
        spaces = observation_space, action_space
        self._clock_words = check.count("seed", seed, least=-(2**31)), channels_first, limit, spaces
        self._clock: Any = None
        # Not before they are needed: their package registers environments with Gymnasium.
        from netmq_example.envs.side_channels import StepCarrier
        from netmq_example.envs.simulators import Simulators

        words: dict[str, Any] = {"wait": timeout_wait, "timeout": timeout_wait}
        if file_name is None:
            port = self.DEFAULT_EDITOR_PORT if base_port is None else check.count("base_port", base_port)
            words["endpoint"] = f"tcp://127.0.0.1:{port + worker_id}"
        else:
            check.instance("file_name", file_name, str, os.PathLike)
            program = env_utils.launch_words(os.fspath(file_name))
            if not env_utils.is_player(program[-1]):
                # Another program would not know the word for it.
                self._log_folder = None
            words["launch"] = [*program, *self._executable_args()]
        self._launches = "launch" in words
        with self._by_their_names(exception.UnityEnvironmentException):
            self._simulators = Simulators(**words)
            if self._side_channel_manager.channels:
                self._simulators.ask = StepCarrier(self._simulators.ask, self._side_channel_manager).ask
            self._end = self._simulators.start(self, self._accept)
        self._begun = False

    def _executable_args(self) -> list[str]:
        """The words of a build; --endpoint follows them."""
        words = ["-nographics", "-batchmode"] if self._no_graphics else []
        if self._log_folder and "-logfile" not in [str(word).lower() for word in self._additional_args]:
            words += ["-logFile", os.path.join(self._log_folder, f"Player-{self._worker_id}.log")]
        return words + self._additional_args

    def _accept(self, hello: Message) -> None:
        """Take a simulator, the first one or another; MessageError says why it is refused."""
        if self._clock is None:
            kind: Any = scene_clock.SceneClock
            if hello.values.get("clock") != "scene":
                # By name: it needs gymnasium.
                kind = importlib.import_module("netmq_example.mlagents_envs.python_clock").PythonClock
            self._clock = kind(*self._clock_words)
        self._clock.connected(hello)

    @contextlib.contextmanager
    def _by_their_names(self, other: Any = exception.UnityCommunicationException) -> Iterator[None]:
        """Errors have ML-Agents' names; after one of the other side the next step is a reset."""
        self._begun = False
        self._actions: dict[str, base_env.ActionTuple] = {}
        try:
            yield
        except exception.UnityException:
            raise
        except Lost as error:
            why = f"the simulator is lost: {error}; reset waits for another one"
            raise exception.UnityCommunicatorStoppedException(why) from None
        except TimeoutError as error:
            raise exception.UnityTimeOutException(str(error)) from None
        except OSError as error:
            if self._launches:
                raise exception.UnityEnvironmentException(str(error)) from None
            raise exception.UnityWorkerInUseException(self._worker_id, str(error)) from None
        except MessageError as error:
            raise other(str(error)) from None
        self._begun = True

    # Programs read these, though they are private.
    _loaded = property(lambda self: not self._simulators.connection.closed)
    _port = property(lambda self: int(self._simulators.connection.endpoint.rpartition(":")[2]))
    _process = property(lambda self: self._simulators.process)
    _env_specs = property(lambda self: self._clock.specs)

    @property
    def behavior_specs(self) -> Mapping[str, base_env.BehaviorSpec]:
        return self._env_specs  # type: ignore[no-any-return]

    def reset(self) -> None:
        self._check_loaded()
        with self._by_their_names():
            self._simulators.begin(self._accept, lambda lost: self._clock.reset(self._simulators.ask))

    def step(self) -> None:
        if not self._begun:
            self.reset()
            return
        actions = self._actions
        try:
            with self._by_their_names():
                self._clock.step(self._simulators.ask, actions)
        except ValueError as error:
            # Nothing has moved.
            self._begun = True
            raise exception.UnityActionException(str(error)) from None

    def close(self) -> None:
        self._check_loaded()
        self._begun = False
        self._end()

    def _check_loaded(self) -> None:
        if not self._loaded:
            raise exception.UnityEnvironmentException("this environment is closed: make a new one")

    def get_behavior_spec(self, behavior_name: str) -> base_env.BehaviorSpec:
        """It has this name since 2020."""
        specs = self.behavior_specs
        if behavior_name not in specs:
            known = ", ".join(specs) or "none before reset"
            raise exception.UnityActionException(f"there is no behavior {behavior_name!a:.40}; there is: {known}")
        return specs[behavior_name]

    def get_steps(self, behavior_name: str) -> tuple[base_env.DecisionSteps, base_env.TerminalSteps]:
        self.get_behavior_spec(behavior_name)
        if not self._begun:
            raise exception.NoSteps("call reset before get_steps")
        now, ended = self._clock.turns[behavior_name]
        return now, ended

    def set_actions(self, behavior_name: str, action: Any) -> None:
        """An ActionTuple, or as early in 2020 an array. Before the first reset, and for nobody, nothing is set."""
        spec = self.get_behavior_spec(behavior_name)
        if self._begun and (count := len(self._clock.turns[behavior_name][0])):
            self._actions[behavior_name] = as_tuple(action, spec, count, behavior_name)

    def set_action_for_agent(self, behavior_name: str, agent_id: int, action: Any) -> None:
        spec = self.get_behavior_spec(behavior_name)
        if not self._begun:
            return
        now, _ = self._clock.turns[behavior_name]
        if agent_id not in now:
            raise exception.NoRequest(f"agent {agent_id!r:.40} of {behavior_name} wants no action in this step")
        given = as_tuple(action, spec, 1, behavior_name)
        row = now.agent_id_to_index[agent_id]
        every = spec.action_spec.empty_action(len(now))
        # A copy: its arrays may be the caller's.
        if old := self._actions.get(behavior_name):
            every.continuous[:], every.discrete[:] = old.continuous, old.discrete
        every.continuous[row], every.discrete[row] = given.continuous, given.discrete
        self._actions[behavior_name] = every

    # The second one is of 2020.
    def get_behavior_names(self) -> list[str]:
        return list(self.behavior_specs)

    get_agent_groups = get_behavior_names


def as_tuple(action: Any, spec: base_env.BehaviorSpec, count: int, name: str) -> Any:
    """UnityActionException, if it is not of so many agents."""
    size, branches = spec.action_spec.continuous_size, spec.action_spec.discrete_size
    if not hasattr(action, "discrete"):
        try:
            action = base_env.ActionTuple(action) if size else base_env.ActionTuple(discrete=action)
        except (TypeError, ValueError):
            raise exception.UnityActionException(f"{name} takes an ActionTuple, not {action!r:.60}") from None
    got = getattr(action.continuous, "shape", ()), getattr(action.discrete, "shape", ())
    if got != ((count, size), (count, branches)):
        takes = f"{(count, size)} floats and {(count, branches)} whole numbers, [agents, size]"
        raise exception.UnityActionException(f"{name} takes {takes}, and not {got[0]} and {got[1]}")
    return action
