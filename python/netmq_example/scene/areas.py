"""Areas: many copies of one simulation, and one message steps them all.

    EnvironmentClient("tcp://127.0.0.1:5560", timeout=30).run(AreaSimulator([CartPole() for _ in range(16)]))

A record (records.py) has a row for each area, and says of each whether it steps or resets, so the environment
alone decides that. In C# it is AreaSimulator.cs.
"""

from collections.abc import Sequence

from netmq_example.messages import Message
from netmq_example.scene.simulation import Simulation
from netmq_example.scene.simulator import Simulator


class AreaSimulator(Simulator):
    """Answers reset, step and render for all areas at once."""

    def __init__(self, areas: Sequence[Simulation]) -> None:
        known = isinstance(areas, Sequence) and all(isinstance(area, Simulation) for area in areas)
        if not known or not areas:
            raise ValueError(f"areas takes a list of simulations, at least one, not {areas!r:.40}")
        super().__init__(*areas)

    def describe(self) -> Message:
        hello = super().describe()
        hello.values["areas"] = len(self.areas)
        return hello
