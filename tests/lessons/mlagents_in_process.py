"""mlagents-learn with ML-Agents' own package and poles in process, without the kit's: what it learns there.

    python tests/lessons/mlagents_in_process.py config.yaml --run-id=first --seed=1

The same poles are a scene for the kit's: mlagents_poles.py.
"""

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "python")]
# ML-Agents 1.1.0 uses names that numpy 1.24 dropped.
vars(np).setdefault("float", float)
vars(np).setdefault("long", int)

from mlagents.trainers import learn  # noqa: E402
from mlagents_envs.base_env import (  # noqa: E402
    ActionSpec,
    BaseEnv,
    BehaviorMapping,
    BehaviorSpec,
    DecisionSteps,
    DimensionProperty,
    ObservationSpec,
    ObservationType,
    TerminalSteps,
)

from netmq_example.scene.agent import over  # noqa: E402
from tests.lessons.mlagents_poles import DT, poles  # noqa: E402

NAME = "Pole?team=0"
SEEN = ObservationSpec((4,), (DimensionProperty.NONE,), ObservationType.DEFAULT, "observation")


class Poles(BaseEnv):
    academy_capabilities = None
    behavior_specs = BehaviorMapping({NAME: BehaviorSpec([SEEN], ActionSpec.create_discrete((2,)))})

    def __init__(self):
        self.poles = poles()

    def reset(self):
        for pole in self.poles:
            self.begin(pole)
        self.ended = TerminalSteps.empty(self.behavior_specs[NAME])
        self.now = self.rows([0.0] * len(self.poles))

    def begin(self, pole):
        pole.state = []
        pole.terminated = pole.truncated = False
        pole.on_reset()

    def step(self):
        rewards = []
        for pole, choice in zip(self.poles, self.chosen, strict=True):
            pole.reward = 0.0
            pole.on_action(choice)
            pole.on_tick(DT)
            pole.on_stepped()
            rewards.append(pole.reward)
        seen = [[pole.observe()] for pole in self.poles if over(pole)]
        ids = [number for number, pole in enumerate(self.poles) if over(pole)]
        cut = np.array([self.poles[number].truncated for number in ids], bool)
        earned = np.array([rewards[number] for number in ids], np.float32)
        none = np.zeros(len(ids), np.int32)
        last = np.array(seen, np.float32).reshape(-1, 4)
        self.ended = TerminalSteps([last], earned, cut, np.array(ids, np.int32), none, none * 0.0)
        for number in ids:
            self.begin(self.poles[number])
            rewards[number] = 0.0
        self.now = self.rows(rewards)

    def rows(self, rewards):
        seen = np.array([pole.observe() for pole in self.poles], np.float32)
        none = np.zeros(len(self.poles), np.int32)
        masks = [np.zeros((len(self.poles), 2), bool)]
        ids = np.arange(len(self.poles))
        return DecisionSteps([seen], np.array(rewards, np.float32), ids, masks, none, none * 0.0)

    def get_steps(self, behavior_name):
        return self.now, self.ended

    def set_actions(self, behavior_name, action):
        self.chosen = action.discrete[:, 0].tolist()

    def set_action_for_agent(self, behavior_name, agent_id, action):
        raise NotImplementedError

    def close(self):
        pass


if __name__ == "__main__":
    learn.create_environment_factory = lambda *_: lambda worker_id, side_channels: Poles()
    learn.main()
