"""Lesson 11, the environment: an agent of a Unity scene for Gymnasium. Several agents are in unity_parallel.py.

    import gymnasium, observations
    env = gymnasium.make("NetMQExample/Unity-v0", env_name="Coins", observation_space=…, action_space=…)

Without `launch=["Build/Coins.exe"]`, or `file_name="Build/Coins"`, it waits for Play. The spaces are declared here,
what is in them is declared in C#, at the fields that hold it.
"""

import weakref
from typing import Any

import gymnasium
from gymnasium.spaces import Space
from unity_agents import Agents


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
