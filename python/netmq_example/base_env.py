"""Version 0.3 had it here, and this place ends with the next version."""

from netmq_example.former import moved
from netmq_example.mlagents_envs.base_env import *  # noqa: F403

moved(__name__, "netmq_example.mlagents_envs.base_env")
