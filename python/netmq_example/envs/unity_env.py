"""Lesson 11, the environment: an agent of a Unity scene for Gymnasium. Several agents are in unity_parallel.py.

    import gymnasium, observations
    env = gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", observation_space=…, action_space=…)

Without `launch=["Build/Coins.exe"]`, or `file_name="Build/Coins"`, it waits for Play. The spaces are declared here,
what is in them is declared in C#, at the fields that hold it.

Lesson 11, agents: what some agents of a Unity scene see and get, one message for all of them.

    agents = Agents("Coins", {"car": observation_space}, {"car": action_space})       waits for Play
    seen, info = agents.reset(["car"], seed=1)["car"]
    seen, reward, terminated, truncated, info = agents.step({"car": action})["car"]

An answer is complete: whoever is asked for several agents waits for all of them. What a message does not write stays as
it was; what it writes must fit the spaces. Observations are copies. `info` is {"env": [...], "agent": [...]}, what the
scene and the agent had to say since the last answer; if the simulator is lost, or the agent has left, `lost` says so.
The C# side is SceneSimulator.cs.
"""

import functools
import weakref
from typing import Any

import gymnasium
from gymnasium.spaces import Space

from netmq_example.envs.connection import Lost, Simulators
from netmq_example.envs.merge import empty, fitted, merge, warn
from netmq_example.locator import LocatorError, parse, quoted
from netmq_example.messages import Message, MessageError, take
from netmq_example.spaces import read, request

Spaces = dict[str, Space[Any]]
ENDPOINT = "tcp://127.0.0.1:5561"
# Each is read once; a scene has few, and one that sends ever new ones fills no memory.
known = functools.lru_cache(10_000)(parse)


class Agents:
    """`where` is what lesson 09's Simulators takes: endpoint, launch, wait, timeout, socket."""

    def __init__(self, env_name: str, observations: Spaces, actions: Spaces, **where: Any) -> None:
        self.env_name, self.observations, self.actions = env_name, observations, actions
        self.seen: dict[str, Any] = {}
        for name, space in observations.items():
            # What has no place in a message is named before anybody is waited for.
            empty(space, f"{quoted(name)}@")
            empty(actions[name], f"action of {name}")
        self.simulators = Simulators(default=ENDPOINT, **where)
        try:
            self.simulators.find(self.accept)
        except BaseException:
            self.simulators.close()
            raise

    def accept(self, hello: Message) -> None:
        if (name := take(hello.values, "name", str)) != self.env_name:
            raise MessageError("wrong-name", f"this environment is {self.env_name}, the simulator's is {name!a:.40}")

    def reset(self, names: list[str], seed: int, options: dict[str, Any] | None = None) -> dict[str, Any]:
        """Observation and info of each."""
        if not isinstance(options, dict | None):
            raise ValueError(f"options must be a dict: {options!r:.80}")
        asked = {"agents": names, "options": options or {}}
        state = self.simulators.begin(self.accept, lambda _: self.ask("reset", asked, seed=seed))
        self.seen = {name: empty(space, name) for name, space in self.observations.items()}
        said = self.taken(names, state)
        # What C# alone has, was an error. What Python alone has may come later, from a sensor that is disabled now.
        warn(self.observations, [known(text) for text, _ in state["observations"]])
        return {name: (parts[0], parts[-1]) for name, parts in said.items()}

    def step(self, actions: dict[str, Any]) -> dict[str, Any]:
        """Observation, reward, terminated, truncated and info of each."""
        fits = {name: fitted(self.actions[name], action, f"action of {name}") for name, action in actions.items()}
        try:
            return self.taken(list(actions), self.ask("step", {"actions": fits}))
        except Lost as lost:
            return {name: self.gone(name, str(lost)) for name in actions}

    def send_info(self, info: Any, to: str) -> None:
        """To an agent's OnInfo; to "", the scene's."""
        self.ask("info", {"to": to, "info": info})

    def ask(self, kind: str, said: dict[str, Any], **values: int) -> dict[str, Any]:
        answer = self.simulators.connection.ask(kind, *request(kind, said, values))
        return {} if answer.kind == "ok" else read(take(answer.values, "state", str), answer.arrays)

    def taken(self, names: list[str], state: dict[str, Any]) -> dict[str, Any]:
        there, infos, appended = take(state, "agents", dict), take(state, "infos", list), set[str]()
        try:
            for pair in take(state, "observations", list):
                if type(pair) is not list or len(pair) != 2 or type(pair[0]) is not str:
                    raise LocatorError(f"{pair!a:.60} is no locator with a value")
                merge(self.seen, known(pair[0]), pair[1], appended)
        except LocatorError as error:
            raise MessageError("bad-observation", str(error)) from None
        result = dict[str, Any]()
        for name in names:
            if name not in there:
                result[name] = self.gone(name, f"agent {name} has left the scene")
                continue
            ends = (take(there[name], end, bool) for end in ("terminated", "truncated"))
            info = {"env": infos, "agent": take(there[name], "infos", list)}
            result[name] = self.copy(name), take(there[name], "reward", float), *ends, info
        return result

    def gone(self, name: str, why: str) -> tuple[Any, ...]:
        """Nobody knows what came after the last observation."""
        return self.copy(name), 0.0, False, True, {"env": [], "agent": [], "lost": why}

    def copy(self, name: str) -> Any:
        return fitted(self.observations[name], self.seen[name], f"{quoted(name)}@")


class UnityEnv(gymnasium.Env[Any, Any]):
    """One agent. `where` is what lesson 09's Simulators takes: endpoint, launch, wait, timeout, socket."""

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012, Gymnasium's own way.

    def __init__(
        self,
        env_name: str,
        observation_space: Space[Any],
        action_space: Space[Any],
        agent_name: str = "agent",
        file_name: str | None = None,
        render_mode: str | None = None,
        **where: Any,
    ) -> None:
        if render_mode is not None:
            raise ValueError(f"render_mode takes None, not {render_mode!r:.40}: lesson 12 makes films")
        self.observation_space, self.action_space, self.name = observation_space, action_space, agent_name
        self.render_mode = render_mode
        where = {"launch": file_name or (), **where}
        self.agents = Agents(env_name, {agent_name: observation_space}, {agent_name: action_space}, **where)
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


gymnasium.register("NetMQExample/Unity-v0", f"{__name__}:UnityEnv")
