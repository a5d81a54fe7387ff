"""Version 0.3 had it here, and this place ends with the next version."""

import sys

from netmq_example.former import moved
from netmq_example.mlagents_envs import carrier, unity_channels
from netmq_example.mlagents_envs.carrier import *  # noqa: F403
from netmq_example.mlagents_envs.side_channel import *  # noqa: F403
from netmq_example.mlagents_envs.unity_channels import *  # noqa: F403

moved(__name__, "netmq_example.mlagents_envs.side_channel")
sys.modules[f"{__name__}.carrier"] = carrier
sys.modules[f"{__name__}.unity_channels"] = unity_channels
