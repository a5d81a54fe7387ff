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
import functools
from collections.abc import Mapping
from dataclasses import dataclass
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
from netmq_example.envs.remote import GONE, checked_seed, info_in, refused_reset, scene_infos
from netmq_example.envs.rendering import MODES, Rendered
from netmq_example.errors import Lost
from netmq_example.messages import EXACT, MessageError
from netmq_example.wire import records, trees
from netmq_example.wire.records import Record, Section
from netmq_example.wire.sections import rewards_in, with_sizes

Spaces = Mapping[str, Space[Any]]
Outcome = tuple[Any, float, bool, bool, dict[str, Any]]


@dataclass
class Team:
    """The agents of one kind that are asked for, by row."""

    kind: Kind
    agents: dict[int, str]
    seen: Any
    actions: Actions
    # Python says what each of them does, and not the same of all.
    mixed: bool


class UnityParallelEnv(MadeAnew, Rendered, ParallelEnv):  # type: ignore[misc, unused-ignore]
    """Agents may end one after the other. The words besides are those of rendering.py."""

    def __init__(
        self,
        env_name: str,
        observation_spaces: Spaces | None = None,
        action_spaces: Spaces | None = None,
        **words: Any,
    ) -> None:
        self.given = given_spaces(observation_spaces, "observation"), given_spaces(action_spaces, "action")
        self.observation_spaces: dict[str, Space[Any]] = {}
        self.action_spaces: dict[str, Space[Any]] = {}
        self.teams: list[Team] = []
        self.agents: list[str] = []
        # Whether an episode is under way: all may be over in it, and one may come yet.
        self.begun = False
        self.random, _ = seeding.np_random()
        self.find(env_name, **words)
        self.possible_agents = [agent for team in self.teams for agent in team.agents.values()]

    def use(self, scene: SceneHello) -> None:
        if self.teams:
            return
        observations, actions = self.given
        asked = list(dict.fromkeys([*observations, *actions])) or scene.agents
        for agent in asked:
            scene.kind_of(agent)
        teams = []
        for kind in scene.kinds:
            agents = {row: agent for row, agent in enumerate(kind.agents) if agent in asked}
            if not agents:
                continue
            for agent in agents.values():
                # A sample from the space of one agent must not change the samples of another one.
                self.observation_spaces[agent] = copy.deepcopy(agreed(kind, "observation", observations.get(agent)))
                self.action_spaces[agent] = copy.deepcopy(agreed(kind, "action", actions.get(agent)))
            first = next(iter(agents.values()))
            seen = observations_of(self.observation_spaces[first], kind, self.observation_spaces)
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
        seed = checked_seed(seed)
        if seed is not None:
            self.random, _ = seeding.np_random(seed)
        # The scene gets a seed each time, so that an episode never depends on the one before.
        first = int(self.random.integers(EXACT)) if seed is None else seed
        with refused_reset(self):
            sections = [team.kind.section(first, team.kind.marks(records.RESET, team.agents)) for team in self.teams]
            answer = self.remote.begin(lambda _: sections, options)
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
        if not self.begun or self.remote.interrupted:
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
            stepping = {row: agent for row, agent in team.agents.items() if agent in living}
            section = Section(team.kind.at, bytes(8 * len(team.kind.agents)), team.kind.marks(records.STEP, stepping))
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
            new = {row for row, mark in enumerate(section.marks) if begins or mark & records.NEW}
            team.seen.take(section, new)
            for row, agent in team.agents.items():
                mark = section.marks[row]
                if not mark & records.SEEN and not (mark & records.ABSENT and agent in living and not begins):
                    continue
                info = {**everyone, **infos.get(row, {})}
                ends = mark & (records.TERMINATED | records.TRUNCATED)
                if mark & records.ABSENT and not ends:
                    ends = records.TRUNCATED
                    info["lost"] = GONE
                seen = team.seen.one(row)
                found[agent] = seen, rewards[row], bool(ends & records.TERMINATED), bool(ends & records.TRUNCATED), info
        if begins and not found:
            raise MessageError("no-agents", "none of the agents is in the scene now")
        return found

    def lost(self, why: str) -> dict[str, Outcome]:
        """The last observations stand for unknown ones."""
        return {
            agent: (team.seen.one(row), 0.0, False, True, {"lost": why})
            for team in self.teams
            for row, agent in team.agents.items()
            if agent in self.agents
        }


def of_world(method: Any) -> Any:
    @functools.wraps(method)
    def call(self: Any, *args: Any, **kwargs: Any) -> Any:
        return method(self.unwrapped, *args, **kwargs)

    return call


class UnityAECEnv(MadeAnew, BaseWrapper):  # type: ignore[misc, unused-ignore]
    """One after the other: it takes what UnityParallelEnv takes. Nothing moves until the last agent has chosen."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(parallel_to_aec(UnityParallelEnv(*args, **kwargs)))

    send_info = of_world(Rendered.send_info)
    begin_render = of_world(Rendered.begin_render)
    end_render = of_world(Rendered.end_render)
    render_all = of_world(Rendered.render_all)


def given_spaces(spaces: Any, which: str) -> dict[str, Space[Any]]:
    if spaces is None:
        return {}
    if not isinstance(spaces, Mapping) or not spaces:
        raise ValueError(f"{which}_spaces take a dict of agents and spaces, not {spaces!r:.40}")
    for name, space in spaces.items():
        arguments.text("the name of an agent", name)
        check_space(space, which)
    return dict(spaces)


def by_agent(outcomes: dict[str, Outcome], part: int) -> dict[str, Any]:
    return {agent: outcome[part] for agent, outcome in outcomes.items()}
