"""An agent of a Unity scene for Gymnasium. Several agents at once are in unity_parallel_env.py.

    import gymnasium
    import netmq_example.envs                          registers it, where the package is not installed

    env = gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", observation_space=…, action_space=…)
    seen, info = env.reset(seed=1)
    seen, reward, terminated, truncated, info = env.step(action)

Without `launch=["Build/Coins.exe"]`, or `file_name="Build/Coins"`, it waits for Play. The spaces are declared here;
what is in them is declared in C#, at the fields that hold it.

`info` is {"env": [...], "agent": [...]}, what the scene and the agent have sent since the last answer. If the simulator
is lost, or the agent has left, the episode is truncated, and `info["lost"]` says why. MessageError is the simulator's
refusal, or says what is wrong with its answer. In C# the other side is SceneSimulator.cs. It needs gymnasium and numpy.
"""

import functools
import os
import weakref
from collections.abc import Iterable, Mapping
from typing import Any

import gymnasium
from gymnasium.spaces import Space

from netmq_example import check
from netmq_example.envs.connection import Lost, Simulators
from netmq_example.envs.merge import empty, fitted, merge, warn
from netmq_example.locator import LocatorError, parse, quoted
from netmq_example.messages import Message, MessageError, take
from netmq_example.spaces import read, request

Spaces = dict[str, Space[Any]]
ENDPOINT = "tcp://127.0.0.1:5561"
# Each is read once. A scene has few; one that sends ever new ones fills no memory.
known = functools.lru_cache(10_000)(parse)


class UnityGymEnv(gymnasium.Env[Any, Any]):
    """One agent. `where` is what Simulators takes: endpoint, launch, wait, timeout, socket."""

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012, Gymnasium's own way.

    def __init__(
        self,
        env_name: str,
        observation_space: Space[Any],
        action_space: Space[Any],
        agent_name: str = "agent",
        file_name: str | os.PathLike[str] | None = None,
        render_mode: str | None = None,
        **where: Any,
    ) -> None:
        refuse_render_mode(render_mode)
        self.observation_space = observation_space
        self.action_space = action_space
        self.render_mode = render_mode
        self.name = check.text("agent_name", agent_name)
        self.agents = Agents(env_name, {self.name: observation_space}, {self.name: action_space}, file_name, **where)
        # Also when nobody calls close: at garbage collection, and at the end of the program. And only once.
        self.close_once = weakref.finalize(self, self.agents.simulators.close)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        # The scene gets a seed each time, so that an episode never depends on the one before.
        seed = int(self.np_random.integers(2**53)) if seed is None else int(seed)
        seen, info = self.agents.reset([self.name], seed, options)[self.name]
        return seen, info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if not self.agents.seen:
            raise gymnasium.error.ResetNeeded("call reset before step")
        seen, reward, terminated, truncated, info = self.agents.step({self.name: action})[self.name]
        return seen, reward, terminated, truncated, info

    def send_info(self, info: Any, agent: str | None = None) -> None:
        """To this agent, to another one, or to the scene itself, which is ""."""
        self.agents.send_info(info, self.name if agent is None else agent)

    def close(self) -> None:
        self.close_once()


def refuse_render_mode(mode: Any) -> None:
    if mode is not None:
        raise ValueError(f"render_mode takes None, not {mode!r:.40}: lesson 12 makes films")


class Agents:
    """What some agents of a scene see and do, in one message for all of them.

    agents = Agents("Coins", {"car": observation_space}, {"car": action_space})       waits for Play
    seen, info = agents.reset(["car"], seed=1)["car"]
    seen, reward, terminated, truncated, info = agents.step({"car": action})["car"]

    An answer is complete: for several agents it waits until all of them have one. What a message does not write stays
    as it was; what it writes must fit the spaces. Observations are copies. `where` is what Simulators takes;
    `file_name` is gymize's name for its `launch`.
    """

    def __init__(
        self,
        env_name: str,
        observations: Spaces,
        actions: Spaces,
        file_name: str | os.PathLike[str] | None = None,
        **where: Any,
    ) -> None:
        self.env_name = check.text("env_name", env_name)
        self.observations = observations
        self.actions = actions
        self.seen: dict[str, Any] = {}
        check_spaces(observations, actions)
        if file_name is not None:
            if not isinstance(file_name, str | os.PathLike) or not os.fspath(file_name):
                raise ValueError(f"file_name takes the path of a game, not {file_name!r:.40}")
            where = {"launch": file_name, **where}
        self.simulators = Simulators(default=ENDPOINT, **where)
        try:
            self.simulators.find(self.accept)
        except BaseException:
            self.simulators.close()
            raise

    def accept(self, hello: Message) -> None:
        name = take(hello.values, "name", str)
        if name != self.env_name:
            raise MessageError("wrong-name", f"this environment is {self.env_name}, the simulator's is {name!a:.40}")

    def reset(self, names: list[str], seed: int, options: dict[str, Any] | None = None) -> dict[str, Any]:
        """Observation and info of each."""
        if not isinstance(options, dict | None):
            raise ValueError(f"options must be a dict: {options!r:.80}")
        asked = {"agents": names, "options": options or {}}
        state = self.simulators.begin(self.accept, lambda _: self.ask("reset", asked, seed=seed))
        self.seen = {name: empty(space, name) for name, space in self.observations.items()}
        results = self.results(names, state)
        # What C# alone has was an error. What Python alone has may come later, from a sensor that is disabled now.
        warn(self.observations, [known(text) for text, _ in state["observations"]])
        return {name: (result[0], result[-1]) for name, result in results.items()}

    def step(self, actions: dict[str, Any]) -> dict[str, Any]:
        """Observation, reward, terminated, truncated and info of each."""
        fits = {name: fitted(self.actions[name], action, f"action of {name}") for name, action in actions.items()}
        try:
            return self.results(actions, self.ask("step", {"actions": fits}))
        except Lost as lost:
            return {name: self.gone(name, str(lost)) for name in actions}

    def send_info(self, info: Any, to: str) -> None:
        """To an agent's OnInfo; to "", the scene's."""
        self.ask("info", {"to": to, "info": info})

    def ask(self, kind: str, content: dict[str, Any], **values: int) -> dict[str, Any]:
        answer = self.simulators.connection.ask(kind, *request(kind, content, values))
        if answer.kind == "ok":
            return {}
        state: dict[str, Any] = read(take(answer.values, "state", str), answer.arrays)
        return state

    def results(self, names: Iterable[str], state: dict[str, Any]) -> dict[str, Any]:
        """What a state says of these agents, after its observations are written."""
        present = take(state, "agents", dict)
        env_infos = take(state, "infos", list)
        appended: set[str] = set()
        try:
            for pair in take(state, "observations", list):
                if type(pair) is not list or len(pair) != 2 or type(pair[0]) is not str:
                    raise LocatorError(f"{pair!a:.60} is no locator with a value")
                merge(self.seen, known(pair[0]), pair[1], appended)
        except LocatorError as error:
            raise MessageError("bad-observation", str(error)) from None
        results = dict[str, Any]()
        for name in names:
            if name not in present:
                results[name] = self.gone(name, f"agent {name} has left the scene")
                continue
            agent = present[name]
            terminated = take(agent, "terminated", bool)
            truncated = take(agent, "truncated", bool)
            info = {"env": env_infos, "agent": take(agent, "infos", list)}
            results[name] = self.copy(name), take(agent, "reward", float), terminated, truncated, info
        return results

    def gone(self, name: str, why: str) -> tuple[Any, ...]:
        """What came after its last observation is not known."""
        return self.copy(name), 0.0, False, True, {"env": [], "agent": [], "lost": why}

    def copy(self, name: str) -> Any:
        return fitted(self.observations[name], self.seen[name], f"{quoted(name)}@")


def check_spaces(observations: Any, actions: Any) -> None:
    """What has no place in a message is named before anybody is waited for."""
    for which, spaces in (("observation", observations), ("action", actions)):
        if not isinstance(spaces, Mapping) or not spaces:
            raise ValueError(f"{which} spaces take a dict of agents and spaces, not {spaces!r:.40}")
    if observations.keys() != actions.keys():
        raise ValueError(f"the agents with observations are {[*observations]}, those with actions {[*actions]}")
    for name, space in observations.items():
        empty(space, f"{quoted(check.text('the name of an agent', name))}@")
        empty(actions[name], f"action of {name}")
