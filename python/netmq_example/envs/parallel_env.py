"""Several agents of a scene for PettingZoo: all at once, or one after the other.

    env = UnityParallelEnv("Pursuit")                                   waits for Play
    env = UnityParallelEnv("Coins", observation_spaces={"car": …}, action_spaces={"car": …})
    seen, infos = env.reset(seed=1)
    seen, rewards, terminations, truncations, infos = env.step({"car": …})

    env = UnityAECEnv("Pursuit")                                        one after the other, as env.agent_iter() says

`possible_agents` are all that the scene has room for, or those whose spaces are given. Who ends or leaves is in
`agents` no more; who comes is there from that step on, and was seen in it. What the scene says is in each one's
`infos[agent]["env"]`. With `real_time=True` the world goes on while Python thinks, and a step waits for the next tick.
Errors, and where the simulator comes from, are those of gym_env.py. It needs pettingzoo, gymnasium and numpy.
"""

import copy
import os
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
from gymnasium.spaces import Space
from gymnasium.utils import seeding
from pettingzoo import ParallelEnv
from pettingzoo.utils import BaseWrapper, parallel_to_aec

from netmq_example import arguments
from netmq_example.envs.actions import Actions
from netmq_example.envs.common import MadeAnew
from netmq_example.envs.gym_env import check_space
from netmq_example.envs.kinds import Kind, SceneHello, agreed
from netmq_example.envs.merge import fitted
from netmq_example.envs.observations import observations_of
from netmq_example.envs.remote import GONE, Remote, info_in, is_seed, refused_reset, scene_infos
from netmq_example.envs.rendering import MODES, Rendered, check_words
from netmq_example.errors import Lost
from netmq_example.messages import EXACT, MessageError
from netmq_example.wire import trees
from netmq_example.wire.records import (
    ABSENT,
    NEW,
    NOTHING,
    RESET,
    SEEN,
    STEP,
    TERMINATED,
    TRUNCATED,
    Record,
    Section,
    rewards_in,
    seeds,
    with_sizes,
)

Spaces = Mapping[str, Space[Any]]
Outcome = tuple[Any, float, bool, bool, dict[str, Any]]


class Team:
    """The agents of one kind that are asked for, by row."""

    def __init__(self, kind: Kind, agents: dict[int, str], seen: Any, actions: Actions, mixed: bool) -> None:
        self.kind = kind
        self.agents = agents
        self.seen = seen
        self.actions = actions
        # Python says what each of them does, and not the same of all.
        self.mixed = mixed


class UnityParallelEnv(MadeAnew, Rendered, ParallelEnv):  # type: ignore[misc, unused-ignore]
    """Agents may end one after the other. `where` is what Simulators takes; films are in rendering.py."""

    def __init__(
        self,
        env_name: str,
        observation_spaces: Spaces | None = None,
        action_spaces: Spaces | None = None,
        file_name: str | os.PathLike[str] | None = None,
        render_mode: str | None = None,
        views: Sequence[str] = ("",),
        render_fps: float | None = None,
        view_endpoint: str = "",
        real_time: bool = False,
        **where: Any,
    ) -> None:
        check_words(render_mode, views, render_fps)
        self.given = given_spaces(observation_spaces, "observation"), given_spaces(action_spaces, "action")
        self.observation_spaces: dict[str, Space[Any]] = {}
        self.action_spaces: dict[str, Space[Any]] = {}
        self.render_fps = render_fps
        self.teams: list[Team] = []
        self.agents: list[str] = []
        # Whether an episode is under way: all may be over in it, and one may come yet.
        self.begun = False
        self.random, _ = seeding.np_random()
        self.remote = Remote(env_name, self.use, file_name, real_time, **where)
        self.simulators = self.remote.simulators
        self.show(self.remote, render_mode, views, view_endpoint)
        # Also when nobody calls close: at garbage collection, and at the end of the program. And only once.
        self.close_once = self.started(self.remote)
        self.possible_agents = [agent for team in self.teams for agent in team.agents.values()]

    def use(self, scene: SceneHello) -> None:
        if self.teams:
            return
        observations, actions = self.given
        asked = list(dict.fromkeys([*(observations or {}), *(actions or {})])) or scene.agents
        for agent in asked:
            scene.kind_of(agent)
        teams = []
        for kind in scene.kinds:
            agents = {row: agent for row, agent in enumerate(kind.agents) if agent in asked}
            if not agents:
                continue
            for agent in agents.values():
                # A sample from the space of one agent must not change the samples of another one.
                for which, given, spaces in (
                    ("observation", observations, self.observation_spaces),
                    ("action", actions, self.action_spaces),
                ):
                    spaces[agent] = copy.deepcopy(agreed(kind, which, (given or {}).get(agent)))
            first = next(iter(agents.values()))
            seen = observations_of(self.observation_spaces[first], kind)
            seen.use(agents, self.observation_spaces)
            team_actions = Actions(self.action_spaces[first], kind, checks=self.simulators.fleet)
            mixed = any(self.action_spaces[agent] != team_actions.space for agent in agents.values())
            teams.append(Team(kind, agents, seen, team_actions, mixed))
        self.metadata = {
            "name": f"NetMQExample/{scene.name}-v0",
            "render_modes": MODES,
            "render_fps": self.render_fps or scene.frames_per_second(teams[0].kind),
            "is_parallelizable": True,
        }
        self.teams = teams

    # The same object each time: a caller that samples has seeded it.
    def observation_space(self, agent: str) -> Space[Any]:
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space[Any]:
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], ...]:
        """Observations and infos."""
        if seed is not None:
            if not is_seed(seed):
                raise ValueError(f"a seed is a whole number from 0 to 2**53 - 1, not {seed!r:.40}")
            self.random, _ = seeding.np_random(int(seed))
        # The scene gets a seed each time, so that an episode never depends on the one before.
        seed = int(self.random.integers(EXACT)) if seed is None else int(seed)
        with refused_reset(self):
            answer = self.remote.begin(lambda _: [reset_section(team, seed) for team in self.teams], options)
            outcomes = self.outcomes(answer, begins=True)
        self.begun = True
        self.agents = list(outcomes)
        for team in self.teams:
            team.seen.warn(row for row, agent in team.agents.items() if agent in outcomes)
        self.filmed(begins=True)
        return by_agent(outcomes, 0), by_agent(outcomes, 4)

    def step(self, actions: dict[str, Any]) -> tuple[dict[str, Any], ...]:
        """Observations, rewards, terminations, truncations and infos, also of those that end with this step."""
        if not isinstance(actions, dict) or not {*self.agents} <= actions.keys() <= {*self.possible_agents}:
            raise ValueError(f"actions {actions!r:.200}, but those that live are {self.agents}")
        if not self.begun:
            raise gymnasium.error.ResetNeeded("no episode is under way: call reset before step")
        if not self.agents:
            # Wrappers step once more when all are over; PettingZoo's own environments have nothing to say then.
            return {}, {}, {}, {}, {}
        self.remote.wait_for_tick()
        try:
            # One message for all of them.
            outcomes = self.outcomes(self.ask_step(actions), begins=False)
        except Lost as lost:
            outcomes = self.lost(str(lost))
        ended = {agent for agent, outcome in outcomes.items() if outcome[2] or outcome[3]}
        self.agents = [agent for agent in self.possible_agents if agent in outcomes and agent not in ended]
        self.filmed(begins=False)
        return tuple(by_agent(outcomes, part) for part in range(5))

    def ask_step(self, actions: dict[str, Any]) -> Record:
        living = {*self.agents}
        sections = []
        for team in self.teams:
            count = len(team.kind.agents)
            stepping = {row: agent for row, agent in team.agents.items() if agent in living}
            marks = bytes(STEP if row in stepping else NOTHING for row in range(count))
            section = Section(team.kind.at, bytes(8 * count), marks)
            done = {agent: self.checked(team, agent, actions[agent]) for agent in stepping.values()}
            if team.mixed:
                with_sizes(section, [trees.write(fitted(self.action_spaces[agent], done[agent], "")) for agent in done])
            else:
                team.actions.put(section, list(done.values()))
            sections.append(section)
        return self.remote.ask(sections)

    def checked(self, team: Team, agent: str, action: Any) -> Any:
        """With several agents each action is looked at here: the error has to say whose it is."""
        try:
            return team.actions.checked(self.action_spaces[agent], action)
        except ValueError as error:
            raise ValueError(f"{error}, agent {agent}") from None

    def outcomes(self, answer: Record, begins: bool) -> dict[str, Outcome]:
        """Of those that were asked, and of those that have come."""
        everyone = {"env": scene_infos(answer.said)} if answer.said else {}
        living = {*self.agents}
        found: dict[str, Outcome] = {}
        for team, section in zip(self.teams, answer.sections, strict=True):
            rewards = rewards_in(section)
            infos = {row: info_in(data) for row, data in section.each_info()} if section.table else {}
            new = {row for row, mark in enumerate(section.marks) if begins or mark & NEW}
            team.seen.take(section, new)
            for row, agent in team.agents.items():
                mark = section.marks[row]
                if not mark & SEEN and not (mark & ABSENT and agent in living and not begins):
                    continue
                info = {**everyone, **infos.get(row, {})}
                ends = mark & (TERMINATED | TRUNCATED)
                if mark & ABSENT and not ends:
                    ends = TRUNCATED
                    info["lost"] = GONE
                seen = team.seen.one(row)
                found[agent] = seen, rewards[row], bool(ends & TERMINATED), bool(ends & TRUNCATED), info
        if begins and not found:
            raise MessageError("no-agents", "none of the agents is in the scene now")
        return found

    def lost(self, why: str) -> dict[str, Outcome]:
        """The last observations stand for unknown ones."""
        rows = [(team, row, agent) for team in self.teams for row, agent in team.agents.items()]
        return {
            agent: (team.seen.one(row), 0.0, False, True, {"lost": why})
            for team, row, agent in rows
            if agent in self.agents
        }

    def own_picture(self, pictures: list[Any]) -> Any:
        return pictures[0]

    def send_info(self, info: Any, agent: str = "") -> None:
        """To an agent, or to the scene itself, which is ""."""
        self.remote.send_info(info, agent)

    def close(self) -> None:
        self.end_films()
        self.close_once()


class UnityAECEnv(MadeAnew, BaseWrapper):  # type: ignore[misc, unused-ignore]
    """One after the other: it takes what UnityParallelEnv takes. Nothing moves until the last agent has chosen."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(parallel_to_aec(UnityParallelEnv(*args, **kwargs)))

    def send_info(self, info: Any, agent: str = "") -> None:
        """To an agent, or to the scene itself, which is ""."""
        self.unwrapped.send_info(info, agent)

    def begin_render(self, screen_width: int = -1, screen_height: int = -1, fullscreen: bool = False) -> None:
        """As in rendering.py."""
        self.unwrapped.begin_render(screen_width, screen_height, fullscreen)

    def end_render(self) -> None:
        """As in rendering.py."""
        self.unwrapped.end_render()

    def render_all(self, video_paths: Any = None) -> dict[str, Any]:
        """As in rendering.py."""
        films: dict[str, Any] = self.unwrapped.render_all(video_paths)
        return films


def given_spaces(spaces: Any, which: str) -> dict[str, Space[Any]] | None:
    if spaces is None:
        return None
    if not isinstance(spaces, Mapping) or not spaces:
        raise ValueError(f"{which}_spaces take a dict of agents and spaces, not {spaces!r:.40}")
    for name, space in spaces.items():
        arguments.text("the name of an agent", name)
        check_space(space, which)
    return dict(spaces)


def reset_section(team: Team, seed: int) -> Section:
    count = len(team.kind.agents)
    marks = bytes(RESET if row in team.agents else NOTHING for row in range(count))
    return Section(team.kind.at, seeds([seed + team.kind.first + row for row in range(count)]), marks)


def by_agent(outcomes: dict[str, Outcome], part: int) -> dict[str, Any]:
    return {agent: outcome[part] for agent, outcome in outcomes.items()}
