"""The rows of a vector environment: what its agents are asked for, and what becomes of the answers.

vector_env.py has the methods of Gymnasium's vector environments.
"""

import math
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space, iterate

from netmq_example.envs.actions import Actions
from netmq_example.envs.common import MadeAnew
from netmq_example.envs.episodes import Episodes
from netmq_example.envs.infos import Infos
from netmq_example.envs.kinds import SceneHello, agreed
from netmq_example.envs.observations import NOBODY, observations_of
from netmq_example.envs.remote import GONE, scene_infos
from netmq_example.envs.rendering import Rendered
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


class VectorRows(MadeAnew, Rendered):
    """Of UnityVectorEnv. An episode has `limit` steps at most, or with 0 as many as it likes."""

    given: tuple[Any, Any]
    agent_name: str | None

    def __init__(self, num_envs: int, autoreset_mode: AutoresetMode, limit: int) -> None:
        self.num_envs = num_envs
        self.autoreset_mode = autoreset_mode
        self.episodes = Episodes(num_envs, limit)
        self.kind: Any = None
        self.begun = False
        # The agents whose episode is over, and those that are away; None, if there are none.
        self.over: Any = None
        self.gone: Any = None
        # Those that are away, and of whom that was said; and those that have stepped last, None for all.
        self.away: Any = None
        self.stepping: Any = None
        self.infos = Infos(num_envs)
        # Infos of episodes that have ended, while others have begun in the same step.
        self.final_infos: dict[int, dict[str, Any]] = {}

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

    def begin(self, mask: Any, options: dict[str, Any]) -> Any:
        """Observations. In another simulator all begin anew: those not asked to are lost."""
        new, why = mask, ""

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
        told = new if self.away is None else new | self.away
        self.away = None if self.gone is None else self.gone & told
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
        up = self.episodes.up()
        quiet = answer.sections[0].marks == self.all_seen and len(answer.sections) == 1 and up is None
        before = self.seen.batch() if self.autoreset_mode == AutoresetMode.SAME_STEP and not quiet else None
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
            away = np.zeros(self.num_envs, bool) if self.away is None else self.away
            rewards[away & self.gone] = 0
            terminated &= ~away
            truncated = (truncated | (self.gone & ~terminated)) & ~away
        self.away = self.gone
        seen = self.seen.batch()
        if up is not None:
            truncated |= up & (True if self.gone is None else ~self.gone)
        if ended is not None:
            self.end(ended, rewards, terminated, truncated, up)
        self.over = None if quiet else some(terminated | truncated)
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
        cut = (marks & records.TERMINATED == 0) | (marks & records.TRUNCATED > 0)
        truncated[who] = cut if up is None else cut | up[who]
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
