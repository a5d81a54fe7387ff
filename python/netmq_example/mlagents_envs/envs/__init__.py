"""ML-Agents' wrappers of an environment, module by module, with the names of mlagents_envs.envs.

netmq_example.envs has others, for today's Gymnasium and PettingZoo.
"""
