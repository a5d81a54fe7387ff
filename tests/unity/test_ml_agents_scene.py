"""Sensors, masks, actions and habits of public agents, by the scene's clock; test_ml_agents_sensors.py has more.

Expectations are derived from ML-Agents 3.0.0's source: VectorSensor, StackingSensor, SensorUtils, the action mask; what
is of 2020 from Agent.deprecated.cs of 2.0.
"""

import pytest

np = pytest.importorskip("numpy", reason="ML-Agents' shape needs numpy: pip install numpy")
from tests.unity.scene_worlds import BALL  # noqa: E402


def seen(run, at=0):
    """Of those that have ended, then of those that want an action."""
    decisions, ended = run.env.get_steps(BALL)
    return [*ended.obs[at].tolist(), *decisions.obs[at].tolist()]


def test_without_numbers_there_is_no_vector_sensor_and_collectobservations_gets_null(world):
    run = world("A period=1 size=0 numbers=1")
    run.reset()
    assert run.env.behavior_specs[BALL].observation_specs == []
    run.step(3)
    lines = run.told()
    assert lines[lines.index("step 0") + 1] == "A see nothing" and "A act 3" in lines


def test_stacked_vectors_are_one_sensor_with_the_oldest_first_and_zeros_after_an_end(world):
    run = world("A period=1 stack=3", "A act 3: end")
    run.reset()
    (spec,) = run.env.behavior_specs[BALL].observation_specs
    assert (spec.name, spec.shape) == ("StackingSensor_size3_VectorSensor_size1", (3,))
    rows = [*seen(run)]
    for _ in range(3):
        run.step()
        rows += seen(run)
    assert rows == [[0, 0, 1], [0, 1, 2], [1, 2, 3], [2, 3, 4], [0, 0, 5]]
    run.told()


@pytest.mark.parametrize(
    ("mistake", "why"),
    [
        ("broken", "CreateSensors of Broken on A has failed: no eye"),
        ("numbers=-1", "in its Behavior Parameters Continuous Actions is -1: write 0 or more"),
        ("branches=2x0", "in its Behavior Parameters Branch Sizes has 0 at branch 1: give each branch a choice"),
    ],
)
def test_an_agent_that_cannot_begin_says_why_and_the_others_go_on(mistake, why, world):
    run = world(f"A period=1 max=1 {mistake}", "B period=1")
    run.reset()
    assert [row.what for row in run.step()] == ["wants"]
    assert not [line for line in run.told() if line.startswith(("A act", "A see"))]
    assert f"A stands still: {why}" in run.output


def test_actions_reach_the_agent_as_python_sent_them(world):
    """There are no limits."""
    run = world("A period=1 numbers=2 branches=3x2")
    run.reset()
    run.step(1000000, -7.25, choices=(2, 1))
    assert "A act 1000000 -7.25 #2 #1" in run.told()


def test_a_mask_is_of_the_next_decision_alone_and_not_applied_to_what_python_sends(world):
    run = world("A period=1 branches=3x2", "B period=1 branches=3x2", "A mask 1: forbid 0 1, forbid-all 1 0")
    run.reset()

    def masks():
        return [one.tolist() for one in run.env.get_steps(BALL)[0].action_mask]

    nothing = [False, False, False]
    assert run.env.get_steps(BALL)[0].action_mask[0].dtype == bool
    assert masks() == [[[False, True, False], nothing], [[True, False], [False, False]]]
    run.step(choices=(1, 0))
    assert masks() == [[nothing, nothing], [[False, False], [False, False]]]
    assert "A act #1 #0" in run.told()


def test_what_one_agent_throws_is_its_own_alone(world):
    """Others are not observed twice, and Python hears of them in the same step. In the next one A is asked again."""
    words = [f"{name} period={period} branches=2x2" for name, period in (("B", 1), ("A", 5), ("C", 1))]
    run = world(*words, "A mask 1: forbid 1 0, forbid 1 1")
    assert run.reset() == [("wants", 0, 0, 1), ("wants", 2, 0, 1)]
    assert run.step() == [("wants", 0, 0, 2), ("wants", 1, 0, 2), ("wants", 2, 0, 2)]
    run.told()


def test_an_agent_that_leaves_while_it_is_observed_wants_nothing_more(world):
    run = world("A period=1", "B period=1", "A see 2: off")
    run.reset()
    assert [row[:2] for row in run.step()] == [("ended", 0), ("wants", 1)]
    run.told()


def test_teams_are_behaviors_of_their_own(world):
    run = world("A period=1 team=1", "B period=1", "C period=1 behavior=Cube size=2")
    run.reset()
    assert [*run.env.behavior_specs] == ["Ball?team=1", "Ball?team=0", "Cube?team=0"]
    assert [run.rows(name)[0].id for name in run.env.behavior_specs] == [0, 1, 2]
    run.told()


def test_a_behavior_that_comes_later_is_told_with_its_first_row(world):
    run = world("A period=1", "B period=1 behavior=Cube late", "A physics 2: make B")
    run.reset()
    run.step()
    assert [*run.env.behavior_specs] == [BALL]
    run.step()
    assert [*run.env.behavior_specs] == [BALL, "Cube?team=0"]
    assert run.rows("Cube?team=0") == [("wants", 1, 0, 1)]
    run.told()


@pytest.mark.parametrize(
    ("spec", "action", "act"),
    [("numbers=2", {"numbers": (7.5, -8)}, "7.5 -8"), ("branches=3x2", {"choices": (2, 1)}, "2 1")],
)
def test_methods_of_2020_get_floats(spec, action, act, world):
    run = world(f"A class=Old period=1 {spec}")
    run.reset()
    run.step(*action.get("numbers", ()), choices=action.get("choices", ()))
    assert f"A act {act}" in run.told()


@pytest.mark.parametrize(("spec", "act"), [("numbers=2", "A act 1 2"), ("branches=3x3", "A act 1 2")])
def test_a_heuristic_of_2020_gives_floats(spec, act, alone):
    lines, _ = alone(f"A class=Old period=2 {spec}", "steps=2")
    assert [line for line in lines if "decide" in line or "act" in line] == ["A decide 0 0", act, act]


def test_a_heuristic_that_is_not_written_warns(alone):
    lines, output = alone("A class=Bare period=1 numbers=1", "steps=2")
    assert "A act" in lines and "Heuristic" in output


def test_messages_of_an_agents_own_hide_nothing(world):
    """Agent has none but virtual Awake, OnEnable and OnDisable, and nothing depends on Awake."""
    run = world("A class=Messages period=1 solid=yes", "B period=1 solid=yes")
    run.reset()
    run.step()
    lines = run.told()
    own = [line for line in lines if line.startswith("A ")]
    assert own[:3] == ["A Awake", "A init", "A Start"]
    assert {"A FixedUpdate", "A Update", "A OnTriggerEnter", "A act", "A OnDestroy"} <= {*own}
    assert lines.index("A Start") < lines.index("reset")


def test_an_onenable_that_hides_the_bases_is_named(world):
    run = world("A class=Hides period=1", "B period=1 behavior=Other")
    run.env.reset()
    run.told()
    assert "Hides.OnEnable" in run.output


def test_names_of_types_stay_unitys_in_an_agent(alone):
    lines, _ = alone("A class=Names period=1 numbers=1", "steps=1")
    assert "A World False 0 True 1 0 A state group" in lines
