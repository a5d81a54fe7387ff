"""The other end of an environment, in Python: agents of a scene, and what connects them to whoever trains.

    from netmq_example.scene import Agent, Scene, run

    run(Scene("Ball", [Ball("ball")], dt=0.02), "tcp://127.0.0.1:5559", timeout=30)

A name is loaded when it is first used. In C# they are Agent, GymManager and SceneSimulator.
"""

from typing import TYPE_CHECKING, Any

from netmq_example.doors import door

if TYPE_CHECKING:
    from netmq_example.scene.agent import Agent, Obs
    from netmq_example.scene.client import EnvironmentClient, run
    from netmq_example.scene.scene import Scene
    from netmq_example.scene.side_channels import SideChannelSimulator
    from netmq_example.scene.simulator import SceneSimulator, SimulatorBase, SimulatorDecorator

__all__ = [
    "Agent",
    "EnvironmentClient",
    "Obs",
    "Scene",
    "SceneSimulator",
    "SideChannelSimulator",
    "SimulatorBase",
    "SimulatorDecorator",
    "run",
]

# Hidden from a type checker, to which any name would exist.
if not TYPE_CHECKING:
    ROOMS = {
        "agent": "Agent Obs",
        "client": "EnvironmentClient run",
        "scene": "Scene",
        "side_channels": "SideChannelSimulator",
        "simulator": "SceneSimulator SimulatorBase SimulatorDecorator",
    }
    load, __dir__ = door(__name__, ROOMS)
    # Classes of 0.3 in their place, from which nobody can derive any more.
    GONE = dict.fromkeys(("Simulation", "AgentSimulation"), "derive from Agent, and put your agents into a Scene")
    GONE |= dict.fromkeys(("Simulator", "AreaSimulator", "AgentSimulator"), "write SceneSimulator(Scene(name, agents))")

    def __getattr__(name: str) -> Any:
        if name in GONE:
            raise AttributeError(f"{name} is gone: {GONE[name]}, of netmq_example.scene")
        return load(name)
