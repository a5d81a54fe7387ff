"""The API of ML-Agents' mlagents_envs, module by module: a program needs another first word in its imports only.

    from netmq_example.mlagents_envs.environment import UnityEnvironment
    from netmq_example.mlagents_envs.side_channel import IncomingMessage, OutgoingMessage, SideChannel

ML-Agents has no carrier and no unity_channels: these are the kit's.
"""
