"""The API of ML-Agents' mlagents_envs, module by module: a program needs another first word in its imports only.

    from netmq_example.mlagents_envs.environment import UnityEnvironment
    from netmq_example.mlagents_envs.side_channel import IncomingMessage, OutgoingMessage, SideChannel

ML-Agents has no carrier, clocks, link and unity_channels: these are the kit's.
"""

# That of ML-Agents whose names these are.
__version__ = "1.1.0"
