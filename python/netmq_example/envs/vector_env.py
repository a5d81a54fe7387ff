"""Many agents of one kind as a vector environment: one scene, and each step of all of them is one message.

    import gymnasium
    import netmq_example.envs

    envs = gymnasium.make_vec("NetMQExample/CartPole-v0", num_envs=16)    waits for a scene with 16 agents

Arrays and infos are those of Gymnasium's SyncVectorEnv with as many environments; `envs.infos[3]` is what agent 3 has
said, as it was sent. An agent whose episode is over begins anew as `autoreset_mode` says: in the next step, which is
Gymnasium's default, in the same one, or when reset gets a mask. A simulator that is lost ends all episodes, and an
agent that leaves its own: they are truncated, and `infos["lost"]` says why. An agent that is not there has no rewards
and no ends until it comes back. The C# side is SceneSimulator.cs. Lesson 17's hub has as many scenes in place of one.
"""

import math
import os
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Space
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space, iterate

from netmq_example import arguments, check
from netmq_example.envs.actions import Actions
from netmq_example.envs.common import MadeAnew, checked_options
from netmq_example.envs.episodes import Episodes
from netmq_example.envs.gym_env import check_space
from netmq_example.envs.infos import Infos
from netmq_example.envs.kinds import SceneHello, agreed
from netmq_example.envs.observations import NOBODY, observations_of
from netmq_example.envs.remote import GONE, Remote, refused_reset, scene_infos
from netmq_example.envs.rendering import MODES, Rendered
from netmq_example.errors import Lost
from netmq_example.messages import LIMIT, MessageError
from netmq_example.wire import records
from netmq_example.wire.records import Record, Section
from netmq_example.wire.space_bytes import codec_of


def some(mask: Any) -> Any:
    """The mask, or None if it is nobody's."""
    return mask if mask is not None and mask.any() else None


def rewards_of(section: Section) -> Any:
    rewards = np.frombuffer(section.numbers, np.float64).copy()
    if not math.isfinite(rewards.sum()):
        raise MessageError("bad-reward", f"the rewards are {rewards!s:.80}")
    return rewards


class UnityVectorEnv(MadeAnew, Rendered, VectorEnv[Any, Any, Any]):
    """The agents of one kind. `where` is what Simulators takes: endpoint, launch, wait, timeout, context, fleet.

    `agent_name` is the name of the kind, which is needed where the scene has several. With `real_time` the world goes
    on while Python thinks, and a step waits for its tick.
    """

    metadata: dict[str, Any] = {"render_modes": MODES}  # noqa: RUF012, Gymnasium's own way.
    # Until it is made: Gymnasium closes what is forgotten, also when there is nothing yet to be closed.
    closed = True

    def __init__(
        self,
        num_envs: int = 1,
        env_name: str = "",
        observation_space: Space[Any] | None = None,
        action_space: Space[Any] | None = None,
        agent_name: str | None = None,
        file_name: str | os.PathLike[str] | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        views: Sequence[str] = ("",),
        render_fps: float | None = None,
        view_endpoint: str = "",
        real_time: bool = False,
        **where: Any,
    ) -> None:
        self.show(render_mode, views, render_fps, view_endpoint)
        check_space(observation_space, "observation")
        check_space(action_space, "action")
        self.num_envs = check.count("num_envs", num_envs)
        self.given = observation_space, action_space
        self.agent_name = None if agent_name is None else arguments.text("agent_name", agent_name)
        if autoreset_mode not in [*AutoresetMode, *(mode.value for mode in AutoresetMode)]:
            modes = ", ".join(mode.value for mode in AutoresetMode)
            raise ValueError(f"autoreset_mode takes one of {modes}, not {autoreset_mode!r:.40}")
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.observation_mode = "same"
        unlimited = max_episode_steps is None or max_episode_steps == -1
        limit = 0 if unlimited else check.count("max_episode_steps", max_episode_steps)
        self.episodes = Episodes(self.num_envs, limit)
        self.kind: Any = None
        self.begun = False
        # The agents whose episode is over, and those that are away; None, if there are none.
        self.over: Any = None
        self.gone: Any = None
        # Those that are away, and of whom that was said; and those that have stepped last, None for all.
        self.away = np.zeros(self.num_envs, bool)
        self.stepping: Any = None
        self.infos = Infos(self.num_envs)
        # Infos of episodes that have ended, while others have begun in the same step.
        self.final_infos: dict[int, dict[str, Any]] = {}
        self.find(Remote(env_name, self.use, file_name, real_time, **where))
        self.closed = False

    def use(self, scene: SceneHello) -> None:
        if self.kind:
            return
        kinds = [kind for kind in scene.kinds if self.agent_name in (None, kind.name)]
        if len(kinds) != 1:
            names = ", ".join(kind.name for kind in scene.kinds)
            raise ValueError(f"the scene has agents of the kinds {names}: say one of them with agent_name")
        (kind,) = kinds
        if len(kind.agents) != self.num_envs:
            few = f"{kind.agents[0]} … {kind.agents[-1]}" if len(kind.agents) > 1 else kind.agents[0]
            raise ValueError(
                f"num_envs is {self.num_envs}, and the scene has {len(kind.agents)} agents named {few}: "
                f"write num_envs={len(kind.agents)}, or change their number in the scene"
            )
        self.single_observation_space = agreed(kind, "observation", self.given[0])
        self.single_action_space = agreed(kind, "action", self.given[1])
        most = self.num_envs * (codec_of(self.single_observation_space).size or 0)
        if most > LIMIT:
            raise ValueError(f"{most} bytes of {self.num_envs} agents are more than a message has, {LIMIT}")
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.seen = observations_of(self.single_observation_space, kind)
        self.actions = Actions(self.single_action_space, kind, checks=self.simulators.fleet)
        fps = self.render_fps or scene.frames_per_second(kind)
        self.metadata = {**self.metadata, "autoreset_mode": self.autoreset_mode, "render_fps": fps}
        self.everybody = bytes([records.STEP]) * self.num_envs
        self.all_seen = bytes([records.SEEN]) * self.num_envs
        self.zeros = bytes(8 * self.num_envs)
        self.kind = kind

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        options = checked_options(options)
        mask = np.asarray(options.pop("reset_mask", np.ones(self.num_envs, bool)))
        if mask.shape != (self.num_envs,) or mask.dtype != bool or not mask.any():
            raise ValueError(f"reset_mask must be {self.num_envs} times true or false, one of them true: {mask!r:.80}")
        if (not self.begun or self.remote.interrupted) and not mask.all():
            raise gymnasium.error.ResetNeeded("no episode is under way: leave reset_mask out, and all begin")
        self.episodes.plant(seed, mask)
        with refused_reset(self):
            seen = self.begin(mask, options)
        # Of all the first one: they are of one kind.
        self.seen.warn([0])
        self.filmed(begins=True)
        return seen, self.infos.gathered()

    def begin(self, mask: Any, options: dict[str, Any]) -> Any:
        """Observations. In another simulator all begin anew: those not asked to are lost."""
        new = mask
        why = ""

        def sections(lost: Lost | None) -> list[Section]:
            nonlocal new, why
            if lost:
                new = np.ones(self.num_envs, bool)
                why = str(lost)
            marks = np.where(new, records.RESET, records.NOTHING).astype(np.uint8).tobytes()
            return [Section(self.kind.at, (self.episodes.next + self.kind.first).tobytes(), marks)]

        answer = self.remote.begin(sections, options)
        self.episodes.begun(np.flatnonzero(new))
        self.read(answer, new)
        for agent in np.flatnonzero(new & ~mask):
            self.infos.add(int(agent), {"lost": why})
        self.away = np.zeros(self.num_envs, bool) if self.gone is None else self.gone & (new | self.away)
        seen = self.seen.batch()
        self.over = some(None if self.over is None else self.over & ~new)
        self.begun = True
        return seen

    def read(self, answer: Record, again: Any) -> tuple[Section, Any]:
        """The section of what is now, and one of those that have ended, or None."""
        now = answer.sections[0]
        ended = next((one for one in answer.sections[1:] if one.columns & records.ENDED), None)
        begins: Any = NOBODY if again is None else set(np.flatnonzero(again).tolist())
        if ended:
            begins = {*begins, *ended.whose()}
        everyone = {"env": scene_infos(answer.said)} if answer.said else None
        self.infos = Infos(self.num_envs, now, everyone)
        self.gone = (
            None if now.marks == self.all_seen else some(np.frombuffer(now.marks, np.uint8) & records.ABSENT > 0)
        )
        if self.gone is not None:
            for agent in np.flatnonzero(self.gone):
                self.infos.add(int(agent), {"lost": GONE})
        self.seen.take(now, begins)
        return now, ended

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        if not self.begun or self.remote.interrupted:
            raise gymnasium.error.ResetNeeded("no episode is under way: call reset before step")
        self.final_infos = {}
        again = self.over
        if again is not None and self.autoreset_mode == AutoresetMode.DISABLED:
            raise ValueError(f"agents {np.flatnonzero(again)} are over: reset(options={{'reset_mask': …}}) first")
        if again is not None and again.all():
            # All were lost, perhaps: then it is another simulator that they begin in.
            if actions not in self.action_space:
                raise self.actions.refused(self.action_space, actions)
            seen = self.begin(again, {})
            self.filmed(begins=True)
            nothing = np.zeros(self.num_envs)
            return seen, nothing, nothing > 0, nothing > 0, self.infos.gathered()
        try:
            answer = self.actions.asked(lambda batch: self.ask_step(batch, again), self.action_space, actions)
        except Lost as lost:
            return self.lost(str(lost))
        self.episodes.stepped(self.stepping)
        results = self.results(answer, again)
        self.filmed(begins=False)
        return results

    def ask_step(self, actions: Any, again: Any) -> Record:
        """One step of all agents. Those of `again` are reset in place of it."""
        kind = self.kind
        marks, steps = self.episodes.orders(again, self.gone)
        self.stepping = steps
        bits = records.AUTORESET if self.autoreset_mode == AutoresetMode.SAME_STEP else 0
        numbers = self.zeros
        if bits or steps is not None:
            numbers = (self.episodes.next + kind.first).tobytes()
        section = Section(kind.at, numbers, marks or self.everybody)
        self.actions.put_batch(section, actions, steps)
        self.remote.wait_for_tick()
        try:
            answer = self.remote.ask([section], bits=bits)
        except MessageError as error:
            # Nobody knows who has begun anew, and who has not.
            self.begun = self.begun and (error.code != "error-in-simulation" or (not bits and steps is None))
            raise
        if steps is not None:
            self.episodes.draw(np.flatnonzero(~steps))
        return answer

    def results(self, answer: Record, again: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        quiet = answer.sections[0].marks == self.all_seen and len(answer.sections) == 1
        up = self.episodes.up()
        may_end = not quiet or up is not None
        before = self.seen.batch() if self.autoreset_mode == AutoresetMode.SAME_STEP and may_end else None
        now, ended = self.read(answer, again)
        rewards = rewards_of(now)
        if quiet:
            terminated, truncated = np.zeros(self.num_envs, bool), np.zeros(self.num_envs, bool)
        else:
            marks = np.frombuffer(now.marks, np.uint8)
            terminated = marks & records.TERMINATED > 0
            truncated = marks & records.TRUNCATED > 0
        if self.gone is not None:
            # An agent that leaves is cut, once; one that is away has no rewards, and no episode that could end.
            rewards[self.away & self.gone] = 0
            terminated &= ~self.away
            truncated = (truncated | (self.gone & ~terminated)) & ~self.away
        self.away = np.zeros(self.num_envs, bool) if self.gone is None else self.gone
        seen = self.seen.batch()
        if up is not None:
            truncated |= up & (True if self.gone is None else ~self.gone)
        if ended is not None:
            self.end(ended, rewards, terminated, truncated, up)
        self.over = None if quiet and up is None else some(terminated | truncated)
        infos = self.infos.gathered()
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self.over is not None:
            infos = self.with_finals(infos, before)
            self.over = None
        return seen, rewards, terminated, truncated, infos

    def end(self, ended: Section, rewards: Any, terminated: Any, truncated: Any, up: Any) -> None:
        """Those that have ended, and begun anew."""
        who = np.asarray(ended.whose())
        if len(who) and int(who.max()) >= self.num_envs:
            raise MessageError("bad-record", f"agent {who.max()} of {self.num_envs} cannot have ended")
        rewards[who] = rewards_of(ended)
        marks = np.frombuffer(ended.marks, np.uint8)
        terminated[who] = marks & records.TERMINATED > 0
        truncated[who] = (
            (marks & records.TERMINATED == 0) | (marks & records.TRUNCATED > 0) | (up is not None and up[who])
        )
        self.episodes.begun(who)
        self.last = observations_of(self.single_observation_space, self.kind)
        self.last.take(ended)
        infos = Infos(self.num_envs, ended)
        self.final_infos = {agent: infos[agent] for agent in who.tolist()}

    def with_finals(self, infos: dict[str, Any], before: Any) -> dict[str, Any]:
        """The last observation and info of each episode that is over."""
        each = None
        last: dict[int, Any] = {}
        for agent in np.flatnonzero(self.over).tolist():
            if agent in self.final_infos:
                last[agent] = self.last.one(agent)
            else:
                # An agent that has left was seen last before.
                each = list(iterate(self.observation_space, before)) if each is None else each
                last[agent] = each[agent]
                self.final_infos[agent] = self.infos[agent]
        return self.with_last(infos, last)

    def with_last(self, infos: dict[str, Any], last: dict[int, Any]) -> dict[str, Any]:
        seen = np.full(self.num_envs, None, object)
        mask = np.zeros(self.num_envs, bool)
        said = Infos(self.num_envs)
        for agent, one in last.items():
            seen[agent] = one
            mask[agent] = True
            said.add(agent, self.final_infos[agent])
        finals = {"final_obs": seen, "_final_obs": mask, "final_info": said.mixed(), "_final_info": mask.copy()}
        return {**infos, **finals}

    def lost(self, why: str) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """The simulator is gone, and so are all episodes. The last observations stand for unknown ones."""
        self.infos = Infos(self.num_envs, None, {"lost": why})
        nothing = np.zeros(self.num_envs)
        seen = self.seen.batch()
        self.over = np.ones(self.num_envs, bool)
        infos = self.infos.gathered()
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            finals = list(iterate(self.observation_space, seen))
            seen = self.begin(self.over, {})
            self.final_infos = {agent: {"lost": why} for agent in range(self.num_envs)}
            infos = self.with_last(self.infos.gathered(), dict(enumerate(finals)))
        self.filmed(begins=False)
        return seen, nothing, nothing > 0, nothing == 0, infos

    def own_picture(self, pictures: list[Any]) -> Any:
        first = self.kind.first
        return tuple(pictures[first : first + self.num_envs] if len(pictures) > 1 else pictures * self.num_envs)

    def render(self) -> Any:
        """A tuple with a picture of each agent, where they draw themselves; else what rendering.py says."""
        seen = super().render()
        return (seen,) * self.num_envs if self.render_mode == "rgb_array" and type(seen) is not tuple else seen

    # As Gymnasium's own vector environments have them: one for each agent.
    np_random = property(lambda self: tuple(random for random, _ in self.episodes.randoms))
    np_random_seed = property(lambda self: tuple(seed for _, seed in self.episodes.randoms))

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """The attribute that an environment of one agent would have, once for each: only pictures differ."""
        if name in ("reset", "step", "close"):
            raise ValueError(f"call {name} of the vector environment itself, not by call")
        if name == "render":
            return self.render() or (None,) * self.num_envs
        if name in ("np_random", "np_random_seed"):
            return tuple(getattr(self, name))
        single = {"observation_space": "single_observation_space", "action_space": "single_action_space"}
        value = getattr(self, single.get(name, name))
        return (value(*args, **kwargs) if callable(value) else value,) * self.num_envs

    def get_attr(self, name: str) -> tuple[Any, ...]:
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """One value for all agents, or a list of equal ones: they are one simulator."""
        each = list(values) if isinstance(values, list | tuple) else [values]
        if any(value != each[0] for value in each[1:]):
            raise ValueError(f"{name} is the same for all agents, not {values!r:.80}")
        setattr(self, name, each[0])

    # Gymnasium's own, which calls close_extras.
    close = VectorEnv.close

    def close_extras(self, **kwargs: Any) -> None:
        super().close()
