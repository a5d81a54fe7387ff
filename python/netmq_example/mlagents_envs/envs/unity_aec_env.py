"""UnityAECEnv over an environment of ML-Agents, as mlagents_envs.envs.unity_aec_env has it: one agent after the other.

    env = UnityAECEnv(UnityEnvironment("Build/Game"))
    env.reset()
    for agent in env.agent_iter():
        seen, reward, done, info = env.last()
        env.step(None if done else env.action_space(agent).sample())

The scene goes on when all have had their turn. It has the four values of PettingZoo 1.15, which ML-Agents wants;
UnityAECEnv of netmq_example.envs has today's. It needs PettingZoo when it is made.
"""

from typing import Any

from netmq_example.mlagents_envs.envs.unity_pettingzoo_base_env import UnityPettingzooBaseEnv
from netmq_example.mlagents_envs.exception import UnityException


class UnityAECEnv(UnityPettingzooBaseEnv):
    """An agent that has ended takes its last turn with the action None."""

    kind = "AECEnv"

    def step(self, action: Any) -> None:
        self._assert_loaded()
        if not self._live_agents:
            raise UnityException("nobody is there: call reset before the next step")
        self._process_action(self._agents[self._agent_index], action)
        self._agent_index += 1
        self.rewards = dict.fromkeys(self.rewards, 0.0)
        if self._agent_index >= len(self._agents) and self._live_agents:
            self._step()

    def observe(self, agent_id: str) -> tuple[Any, float, bool, dict[str, Any]]:
        reward, done = self._cumm_rewards[agent_id], self.dones[agent_id]
        return self._observations[agent_id], reward, done, self.infos[agent_id]

    def last(self, observe: bool = True) -> tuple[Any, float, bool, dict[str, Any]]:
        """Of the agent whose turn it is; the reward is that of its last step."""
        seen, reward, done, info = self.observe(self._agents[self._agent_index])
        return seen if observe else None, reward, done, info

    @property
    def agent_selection(self) -> str:
        return self._agents[self._agent_index if self._live_agents else 0]
