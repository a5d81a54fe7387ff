"""Where an exchange of side channels stands in the messages of an environment's resets and steps.

    add(state, exchange)              the value side_channel, true, and the exchange as one more array, the last, uint8
    if deliver(state, manager): ...   takes it out again and hands it to the channels

envs/side_channels.py is the training's end of it, and simulation/side_channels.py the simulator's.
"""

from netmq_example.exception import UnitySideChannelException
from netmq_example.messages import Array, Message
from netmq_example.side_channel.side_channel_manager import SideChannelManager


def add(message: Message, exchange: bytes) -> None:
    message.values["side_channel"] = True
    message.arrays.append(Array("uint8", (len(exchange),), exchange))


def deliver(message: Message, manager: SideChannelManager) -> bool:
    """False if there is no exchange in it. What is wrong with one is a line of the manager's `report`."""
    if message.values.pop("side_channel", False) is not True or not message.arrays:
        return False
    try:
        manager.process_side_channel_message(bytes(message.arrays.pop().data))
    except UnitySideChannelException as error:
        manager.report(str(error))
    return True
