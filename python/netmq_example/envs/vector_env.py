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

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Space
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import iterate

from netmq_example import arguments, check
from netmq_example.envs.common import checked_options
from netmq_example.envs.gym_env import check_space
from netmq_example.envs.infos import Infos
from netmq_example.envs.remote import refused_reset
from netmq_example.envs.rendering import MODES
from netmq_example.envs.vector_rows import VectorRows
from netmq_example.errors import Lost


class UnityVectorEnv(VectorRows, VectorEnv[Any, Any, Any]):
    """The agents of one kind. `agent_name` is its name, which is needed where the scene has several kinds. The words
    besides are those of rendering.py: where its simulator is, `real_time`, `render_mode` and what belongs to that.
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
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        **words: Any,
    ) -> None:
        self.given = check_space(observation_space, "observation"), check_space(action_space, "action")
        self.agent_name = None if agent_name is None else arguments.text("agent_name", agent_name)
        if autoreset_mode not in [*AutoresetMode, *(mode.value for mode in AutoresetMode)]:
            modes = ", ".join(mode.value for mode in AutoresetMode)
            raise ValueError(f"autoreset_mode takes one of {modes}, not {autoreset_mode!r:.40}")
        self.observation_mode = "same"
        unlimited = max_episode_steps is None or max_episode_steps == -1
        limit = 0 if unlimited else check.count("max_episode_steps", max_episode_steps)
        super().__init__(check.count("num_envs", num_envs), AutoresetMode(autoreset_mode), limit)
        self.find(env_name, **words)
        self.closed = False

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
