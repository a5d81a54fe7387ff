"""UnityParallelEnv over an environment of ML-Agents, as mlagents_envs.envs.unity_parallel_env has it.

    env = UnityParallelEnv(UnityEnvironment("Build/Game"))
    seen = env.reset()
    seen, rewards, dones, infos = env.step({agent: env.action_space(agent).sample() for agent in env.agents})

It has the four values of PettingZoo 1.15, which ML-Agents wants. Libraries of today want five: UnityParallelEnv of
netmq_example.envs has them. It needs PettingZoo when it is made.
"""

from typing import Any

from netmq_example.mlagents_envs.envs.unity_pettingzoo_base_env import UnityPettingzooBaseEnv
from netmq_example.mlagents_envs.exception import UnityException


class UnityParallelEnv(UnityPettingzooBaseEnv):
    """A step has an action for each of `agents`; who is left out gets zeros."""

    kind = "ParallelEnv"

    def step(self, actions: dict[str, Any]) -> tuple[dict[str, Any], ...]:
        self._assert_loaded()
        if actions and not self._live_agents:
            raise UnityException("nobody is there: call reset before the next step")
        for agent, action in actions.items():
            self._process_action(agent, action)
        self._step()
        self._live_agents = [agent for agent in self._live_agents if not self.dones[agent]]
        return self._observations, self.rewards, self.dones, self.infos
