"""One agent of a scene for Gymnasium: Python decides when time passes in a world that a simulator has.

    import gymnasium
    import netmq_example.envs

    env = gymnasium.make("NetMQExample/CartPole-v0")      prints: waiting for a simulator on tcp://…: press Play
    env = gymnasium.make("NetMQExample/CartPole-v0", launch=["Build/CartPole.exe"])         starts it by itself
    gymnasium.register("My/Ball-v0", "netmq_example.envs:UnityGymEnv", kwargs={"env_name": "Ball"})
    env = UnityGymEnv("Coins", observation_space, action_space)             where C# has attributes alone

The spaces come with the simulator's hello, or are given here, and any of Gymnasium's will do. `options` go to the
scene as they are; `options["state"]`, numbers, is where an agent begins that has a StateSize.

`info` is {"env": [...], "agent": [...]}, what the scene and the agent have sent since the last answer, and what the
agent has said by name. A simulator that is lost, or an agent that leaves, ends the episode: `truncated` is true, and
`info["lost"]` says why; the next reset waits for another simulator, or launches it. An environment belongs to one
thread. A copy of it is a new environment.

ValueError says what cannot be sent, MessageError what a simulator refuses or answers wrongly, TimeoutError that none
came. In C# the other side is SceneSimulator.cs. It needs gymnasium and numpy.
"""

import math
import struct
from typing import Any

import gymnasium
from gymnasium.spaces import Space

from netmq_example import arguments
from netmq_example.envs.actions import Actions
from netmq_example.envs.common import MadeAnew
from netmq_example.envs.kinds import SceneHello, agreed
from netmq_example.envs.observations import observations_of
from netmq_example.envs.remote import GONE, checked_seed, info_in, refused_reset, scene_infos
from netmq_example.envs.rendering import MODES, Rendered
from netmq_example.errors import Lost
from netmq_example.messages import EXACT, MessageError
from netmq_example.wire.batches import empty
from netmq_example.wire.records import ABSENT, RESET, SEEN, STEP, TERMINATED, TRUNCATED, Record, Section

REWARD = struct.Struct("<d")


class UnityGymEnv(MadeAnew, Rendered, gymnasium.Env[Any, Any]):
    """`agent_name` is needed where the scene has several agents. The other words are those of rendering.py: where its
    simulator is, `real_time`, `render_mode` and what belongs to that.
    """

    metadata: dict[str, Any] = {"render_modes": MODES, "render_fps": 50}  # noqa: RUF012, Gymnasium's own way.

    def __init__(
        self,
        env_name: str,
        observation_space: Space[Any] | None = None,
        action_space: Space[Any] | None = None,
        agent_name: str | None = None,
        **words: Any,
    ) -> None:
        self.given = check_space(observation_space, "observation"), check_space(action_space, "action")
        self.agent_name = None if agent_name is None else arguments.text("agent_name", agent_name)
        self.kind: Any = None
        # Whether an episode is under way.
        self.begun = False
        self.find(env_name, **words)

    def use(self, scene: SceneHello) -> None:
        if self.kind:
            return
        if self.agent_name is None and len(scene.agents) > 1:
            raise ValueError(f"{scene.shown()}: say which with agent_name, or take UnityVectorEnv or UnityParallelEnv")
        name = scene.agents[0] if self.agent_name is None else self.agent_name
        kind = scene.kind_of(name)
        self.observation_space = agreed(kind, "observation", self.given[0])
        self.action_space = agreed(kind, "action", self.given[1])
        self.seen = observations_of(self.observation_space, kind)
        self.actions = Actions(self.action_space, kind, checks=self.simulators.fleet)
        self.agent_name = name
        self.row = kind.agents.index(name)
        # Nothing, which a step says of the others.
        self.zeros = bytes(8 * len(kind.agents))
        self.marks = {order: kind.marks(order, [self.row]) for order in (STEP, RESET)}
        self.metadata = {**self.metadata, "render_fps": self.render_fps or scene.frames_per_second(kind)}
        self.kind = kind

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        seed = checked_seed(seed)
        super().reset(seed=seed)
        # The scene gets a seed each time, so that an episode never depends on the one before.
        first = int(self.np_random.integers(EXACT)) if seed is None else seed
        with refused_reset(self):
            answer = self.remote.begin(lambda _: [self.kind.section(first, self.marks[RESET])], options)
            section = answer.sections[0]
            if section.marks[self.row] & ABSENT:
                raise MessageError("unknown-agent", f"agent {self.agent_name} is not in the scene now")
            self.seen.take(section, begins={self.row})
            seen = self.seen.one(self.row)
        self.seen.warn([self.row])
        self.begun = True
        info = self.info(answer)
        self.filmed(begins=True)
        return seen, info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if not self.begun or self.remote.interrupted:
            raise gymnasium.error.ResetNeeded("no episode is under way: call reset before step")
        try:
            answer: Record = self.actions.asked(self.ask_step, self.action_space, action)
        except Lost as lost:
            self.begun = False
            # The last observation stands for an unknown one.
            return self.seen.one(self.row), 0.0, False, True, {"env": [], "agent": [], "lost": str(lost)}
        section = answer.sections[0]
        mark = section.marks[self.row]
        (reward,) = REWARD.unpack_from(section.numbers, 8 * self.row)
        if not math.isfinite(reward):
            raise MessageError("bad-reward", f"the reward is {reward}")
        if mark & SEEN:
            self.seen.take(section)
        info = self.info(answer)
        ends = mark & (TERMINATED | TRUNCATED)
        if mark & ABSENT and not ends:
            # An agent that was over by then has ended as it said; the episode of another one is cut.
            ends = TRUNCATED
            info["lost"] = f"agent {self.agent_name}: {GONE}"
        if ends:
            # Steps beyond the end would be of no episode.
            self.begun = False
        seen = self.seen.one(self.row)
        self.filmed(begins=False)
        return seen, reward, bool(ends & TERMINATED), bool(ends & TRUNCATED), info

    def ask_step(self, action: Any) -> Record:
        section = Section(self.kind.at, self.zeros, self.marks[STEP])
        if self.actions.checks:
            action = self.actions.checked(self.action_space, action)
        self.actions.put(section, [action])
        self.remote.wait_for_tick()
        return self.remote.ask([section])

    def info(self, answer: Record) -> dict[str, Any]:
        info: dict[str, Any] = {"env": scene_infos(answer.said) if answer.said else [], "agent": []}
        section = answer.sections[0]
        if section.table:
            for row, data in section.each_info():
                if row == self.row:
                    info |= info_in(data)
        return info

    def own_picture(self, pictures: list[Any]) -> Any:
        return pictures[0] if len(pictures) == 1 else pictures[self.kind.first + self.row]


def check_space(space: Any, which: str) -> Any:
    """Refuse a space that has no place in a message, before the wait for a simulator."""
    if space is not None:
        if not isinstance(space, Space):
            raise ValueError(f"{which}_space takes a space of Gymnasium, not {space!r:.40}")
        empty(space, which)
    return space
