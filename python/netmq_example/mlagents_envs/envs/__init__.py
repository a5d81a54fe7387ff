"""ML-Agents' wrappers of an environment, module by module, with the names of mlagents_envs.envs.

netmq_example.envs has others, for today's Gymnasium and PettingZoo.
"""

# It names numpy with its cure where that is missing.
from netmq_example.mlagents_envs import base_env as base_env
