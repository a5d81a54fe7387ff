"""Lesson 11, agents: what some agents of a Unity scene see and get, one message for all of them.

    agents = Agents("Coins", {"car": observation_space}, {"car": action_space})       waits for Play
    seen, info = agents.reset(["car"], seed=1)["car"]
    seen, reward, terminated, truncated, info = agents.step({"car": action})["car"]

An answer is complete: whoever is asked for several agents waits for all of them. What a message does not write stays as
it was; what it writes must fit the spaces. Observations are copies. `info` is {"env": [...], "agent": [...]}, what the
scene and the agent had to say since the last answer; if the simulator is lost, or the agent has left, `lost` says so.
Take home: this file, fit.py, merge.py, tree.py, locator.py, mapping.py and reader.py, with connection.py,
simulators.py, launched.py and spaces.py of lesson 09 and messages.py of lesson 05. The C# side is SceneSimulator.cs.
"""

import functools
import sys
from pathlib import Path
from typing import Any

# In their own lessons' folders; at home they lie beside this file.
sys.path += [str(Path(__file__).resolve().parents[1] / folder) for folder in ("05_messages", "09_environment")]
from connection import Lost
from fit import empty, fitted
from gymnasium.spaces import Space
from locator import Locator, parse
from mapping import LocatorError, quoted
from merge import merge
from messages import Array, Message, MessageError, take
from simulators import Simulators
from tree import read, write

Spaces = dict[str, Space[Any]]
ENDPOINT = "tcp://127.0.0.1:5561"


@functools.cache
def known(locator: str) -> Locator:
    """Each is read once; a scene has few, and a peer that sends ever new ones is refused at their agents' names."""
    return parse(locator)


def program(file_name: str | None) -> list[str]:
    """The words that start a build of Unity's, with or without what its file is called on this system at the end."""
    path = Path(file_name or ".").resolve()
    names = [path, *(path.with_name(path.name + end) for end in (".exe", ".x86_64", ".app"))]
    found = [str(file) for name in names for file in (name, *name.glob("Contents/MacOS/*")) if file.is_file()]
    if file_name and not found:
        raise FileNotFoundError(f"there is no game {path}; without file_name, launch and Play it is waited for")
    return found[:1]


class Agents:
    """`where` is what lesson 09's Simulators takes: endpoint, launch, wait, patience, socket."""

    def __init__(self, env_name: str, observations: Spaces, actions: Spaces, **where: Any) -> None:
        self.env_name, self.observations, self.actions = env_name, observations, actions
        self.seen: dict[str, Any] = {}
        # Whoever launches gets a port of its own.
        self.simulators = Simulators(**({} if where.get("launch") else {"endpoint": ENDPOINT}) | where)
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
        asked = {"agents": names, "options": options or {}}
        try:
            state = self.ask("reset", asked, seed=seed)
        except Lost:
            self.simulators.find(self.accept)
            state = self.ask("reset", asked, seed=seed)
        self.seen = {name: empty(space) for name, space in self.observations.items()}
        return {name: (said[0], said[-1]) for name, said in self.taken(names, state).items()}

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
        arrays = list[Array]()
        answer = self.simulators.connection.ask(kind, {**values, "state": write(said, arrays)}, arrays)
        return {} if answer.kind == "ok" else read(take(answer.values, "state", str), answer.arrays)

    def taken(self, names: list[str], state: dict[str, Any]) -> dict[str, Any]:
        there, infos, appended = take(state, "agents", dict), take(state, "infos", list), set[str]()
        try:
            for locator, value in take(state, "observations", list):
                merge(self.seen, known(locator), value, appended)
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
