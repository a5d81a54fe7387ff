"""Version 0.3 had it here, and this place ends with the next version."""

from netmq_example.former import moved
from netmq_example.mlagents_envs.carrier import *  # noqa: F403
from netmq_example.mlagents_envs.side_channel import *  # noqa: F403
from netmq_example.mlagents_envs.unity_channels import *  # noqa: F403

moved(__name__, "netmq_example.mlagents_envs.side_channel")
