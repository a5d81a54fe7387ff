"""Vectors of environments that are the same to the last bit, wherever their agents are."""

import copy
from typing import Any

import numpy as np
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv


def quiet(infos: dict[str, Any]) -> dict[str, Any]:
    """Without the empty lists that a single environment has in each info, so that its user needs no `in`."""
    found = {key: quiet(part) if key == "final_info" else part for key, part in infos.items()}
    for key in {"env", "agent"} & found.keys():
        mask = np.array([bool(said) for said in found.pop(key)])
        found.pop(f"_{key}")
        if mask.any():
            found |= {key: np.where(mask, infos[key], None), f"_{key}": mask}
    return found


def alike(envs, do, *words, **more):
    """All of them answer the same to alike(envs, "reset", seed=7), in the same types."""
    said = []
    for env in envs:
        *most, infos = getattr(env, do)(*copy.deepcopy(words), **copy.deepcopy(more))
        said.append((*most, quiet(infos) if isinstance(env, SyncVectorEnv) else infos))
    for other in said[1:]:
        assert data_equivalence(said[0], other, exact=True), (said[0], other)
    return said[0]


def play(envs, act, steps, *resets):
    """Ends and cuts of each agent, in whatever mode they begin anew."""
    first, *others = envs
    mode = first.metadata["autoreset_mode"]
    for other in others:
        assert other.metadata["autoreset_mode"] == mode
        assert (other.observation_space, other.action_space) == (first.observation_space, first.action_space)
    begin, *resets = resets
    seen, _ = alike(envs, "reset", **begin)
    ends = np.zeros((2, first.num_envs), int)
    for step in range(steps):
        seen, _, *over, _ = alike(envs, "step", act(seen, step))
        ends += over
        if mode == AutoresetMode.DISABLED and np.any(over):
            seen, _ = alike(envs, "reset", options={"reset_mask": over[0] | over[1]})
    for again in resets:
        alike(envs, "reset", **again)
    return ends
