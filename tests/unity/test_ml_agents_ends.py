"""Ends of episodes, rewards and groups by the scene's clock; each expectation is derived from ML-Agents 3.0.0's source.

NotifyAgentDone keeps a terminal row at once, and no second one before the next decision; _AgentReset begins at once.
"""

import pytest

np = pytest.importorskip("numpy", reason="ML-Agents' shape needs numpy: pip install numpy")
AGAIN = "A begin steps=0 sum=0 episodes=1"


def since(lines, first, *expected):
    begin = lines.index(first)
    assert lines[begin : begin + len(expected)] == [*expected]


def test_an_end_is_observed_at_once_and_its_row_goes_alone_with_the_next_step(world):
    """Zeros until the next decision, which the Academy's step says."""
    run = world("A period=5 numbers=1 branches=3", "A act 2: add 1, end")
    assert run.reset() == [("wants", 0, 0, 1)]
    assert run.step(7, choices=(2,)) == [("ended", 0, 1, 2)]
    assert run.step() == [("wants", 0, 0, 3)]
    since(
        run.told(), "step 0", "step 0", "A see 1", "A act 7 #2", "step 1", "A act 7 #2", "A see 2", AGAIN, "step 2",
        "A act 0 #0", "step 3", "A act 0 #0", "step 4", "A act 0 #0", "step 5", "A see 4"
    )  # fmt: skip


def test_a_second_end_before_the_next_decision_sends_no_row_and_counts_no_episode(world):
    """But OnEpisodeBegin comes again, and rewards stay."""
    run = world("A period=5", "A act 2: add 1, end", "A act 3: add 5, end")
    run.reset()
    assert run.step() == [("ended", 0, 1, 2)]
    assert run.step() == [("wants", 0, 5, 3)]
    since(run.told(), "step 2", "step 2", "A act 0", "A begin steps=0 sum=5 episodes=1", "step 3")


def test_a_reward_after_an_end_belongs_to_the_new_episode(world):
    run = world("A period=5", "A act 2: add 1, end, add 3", "A begin 2: add 4, sum")
    run.reset()
    assert run.step() == [("ended", 0, 1, 2)]
    assert run.step() == [("wants", 0, 7, 3)]
    assert "A sum 4" in run.told()


def test_a_reward_in_collectobservations_counts_in_a_decisions_row_and_is_lost_in_a_terminal_one(world):
    run = world("A period=2", "A see *: add 10", "A act 3: add 1, end, sum")
    assert run.reset() == [("wants", 0, 10, 1)]
    assert run.step() == [("wants", 0, 10, 2)]
    assert run.step() == [("ended", 0, 1, 3)]
    assert run.step() == [("wants", 0, 10, 4)]
    assert "A sum 0" in run.told()


@pytest.mark.parametrize(
    ("call", "before"), [("A physics 2", ["A physics"]), ("A update 1", ["A update"]), ("A fixed 2", ["A fixed"])]
)
def test_an_end_between_steps_goes_with_the_next_one_beside_the_new_episodes_first_row(call, before, world):
    """As in OnTriggerEnter: the row and OnEpisodeBegin at once; both rows of the agent in one message."""
    run = world("A period=2", f"{call}: add 2, end")
    run.reset()
    assert run.step() == [("ended", 0, 2, 2), ("wants", 0, 0, 3)]
    since(run.told(), before[0], *before, "A see 2", AGAIN, "step 2", "A see 1")


def test_an_end_in_ontriggerenter(world):
    run = world("A period=2 solid=yes", "B solid=yes", "A trigger 1: add 2, end")
    run.reset()
    assert run.step() == [("ended", 0, 2, 2)]
    assert run.step() == [("wants", 0, 0, 3)]
    since(run.told(), "A trigger", "A trigger", "A see 1", AGAIN, "step 1", "A act 0", "step 2", "A see 2")


def test_another_model_is_an_end_without_a_new_episode(world):
    run = world("A period=2", "A act 2: add 1, model")
    run.reset()
    assert run.step() == [("ended", 0, 1, 2), ("wants", 0, 0, 3)]
    lines = run.told()
    since(lines, "step 1", "step 1", "A act 0", "A see 2", "step 2", "A see 3")
    assert AGAIN not in lines


def test_a_model_without_python_is_told_in_a_line(alone):
    lines, output = alone("A period=1", "A act 1: model", "steps=2")
    assert "A act 2" in lines and output.count("model does not run") == 1


def test_a_model_for_one_that_was_never_enabled(alone):
    lines, _ = alone("A period=1", "B period=1 active=no behavior=Cube", "A act 1: B>model, B>on", "steps=3")
    assert "B init" in lines and not any("threw" in line for line in lines), lines


def test_an_end_takes_back_what_was_asked_for(world):
    """Between steps A asks and then ends: it is not observed in the next step, and does not act."""
    run = world("A", "B period=2", "A physics 1: ask", "A physics 3: ask, end, add 1")
    assert run.reset() == [("wants", 1, 0, 1)]
    assert run.step() == [("wants", 0, 0, 1)]
    assert run.step() == [("wants", 1, 0, 2)]
    assert run.step() == [("ended", 0, 0, 2)]
    assert run.step() == [("wants", 1, 0, 3)]
    since(run.told(), "step 3", "step 3", "B act 0", "step 4", "B see 5")


@pytest.mark.parametrize(("deed", "what"), [("end", "ended"), ("interrupt", "interrupted")])
def test_what_python_is_told_of_an_end(deed, what, world):
    run = world("A period=1", f"A act 1: {deed}")
    run.reset()
    assert run.step() == [(what, 0, 0, 2), ("wants", 0, 0, 3)]
    run.told()


def test_max_step_interrupts_after_so_many_actions(world):
    """StepCount >= MaxStep is asked after OnActionReceived."""
    run = world("A period=2 max=3")
    run.reset()
    run.step(4)
    assert run.step(5) == [("interrupted", 0, 0, 3)]
    assert run.step() == [("wants", 0, 0, 4)]
    since(
        run.told(), "step 2", "step 2", "A see 3", "A act 5", "A see 3", AGAIN, "step 3", "A act 0", "step 4", "A see 2"
    )  # fmt: skip


def test_max_step_also_of_one_that_does_nothing(world):
    run = world("A max=2", "B period=3")
    assert run.reset() == [("wants", 1, 0, 1)]
    assert run.step() == [("interrupted", 0, 0, 1)]
    # It ended once more before it asked for anything: no row.
    assert run.step() == [("wants", 1, 0, 2)]
    lines = run.told()
    assert lines.count(AGAIN) >= 1 and "A begin steps=0 sum=0 episodes=2" not in lines


def test_an_end_and_max_step_in_one_step_are_one_end(world):
    run = world("A period=1 max=2", "A act 2: end")
    run.reset()
    run.step()
    assert run.step() == [("ended", 0, 0, 3), ("wants", 0, 0, 4)]
    assert run.told().count(AGAIN) == 1


@pytest.mark.parametrize(
    ("deeds", "name"),
    [(["A act 1: end", "A begin 2: end"], "OnEpisodeBegin"), (["A see 2: end"], "CollectObservations")],
)
def test_an_end_within_onepisodebegin_or_collectobservations_throws(deeds, name, world):
    run = world("A period=1", *deeds)
    run.reset()
    run.step()
    (thrown,) = [line for line in run.told() if "threw" in line]
    assert thrown.startswith("A threw UnityAgentsException: ") and name in thrown


@pytest.mark.parametrize("again", [False, True])
def test_disabled_is_an_end_that_is_not_interrupted_and_one_row_at_most(again, world):
    """None if it has ended since its last decision."""
    run = world("A period=4", "B period=2", "B physics 3: A>off", *["A act 2: end"] * again)
    run.reset()
    first = [("ended", 0, 0, 2)] * again
    assert run.step() == [*first, ("wants", 1, 0, 2)]
    assert run.step() == [*[("ended", 0, 0, 2)] * (not again), *[("wants", 1, 0, 3)] * again]
    run.told()


def test_a_groups_reward_is_each_agents_since_its_last_row(world):
    run = world("A period=2", "B period=3", "C period=2", "A start 1: join g, B>join g", "A physics *: group-add g 1")
    run.reset()
    found, groups = [], set()
    for _ in range(3):
        run.step()
        steps = run.env.get_steps("Ball?team=0")[0]
        groups |= {*steps.group_id}
        rows = zip(steps.agent_id, steps.group_id != 0, steps.group_reward, steps.reward, strict=True)
        found.append([tuple(map(float, row)) for row in rows])
    assert found == [[(0, True, 2, 0), (2, False, 0, 0)], [(1, True, 3, 0)], [(0, True, 2, 0), (2, False, 0, 0)]]
    assert len(groups) == 2
    run.told()


@pytest.mark.parametrize("deed", ["group-end", "group-interrupt"])
def test_the_end_of_a_group_is_that_of_all_its_agents(deed, world):
    """B, which comes after A, does not act any more in this step: its end takes back what was asked for."""
    run = world(
        "A period=2", "B period=2", "C period=2", "A start 1: join g, B>join g", f"A act 2: group-set g 5, {deed} g"
    )
    run.reset()
    assert run.step()[:2] == [(("interrupted" if "inter" in deed else "ended"), one, 0, 2) for one in (0, 1)]
    ended = run.env.get_steps("Ball?team=0")[1]
    (group,) = {*ended.group_id}
    assert group != 0 and [*ended.group_reward] == [5, 5]
    begin = "begin steps=0 sum=0 episodes=1"
    since(
        run.told(), "step 1", "step 1", "A act 0", "A see 2", f"A {begin}", "B see 2", f"B {begin}", "C act 0", "step 2"
    )


def test_a_disabled_ones_last_row_has_its_group_and_then_it_is_no_member(world):
    run = world(
        "A period=2", "B period=2", "A start 1: join g, B>join g", "A physics 2: group-add g 2, B>off, group-size g"
    )
    run.reset()
    run.step()
    ended = run.env.get_steps("Ball?team=0")[1]
    assert (*ended.agent_id, *ended.group_reward, *ended.interrupted) == (1, 2, False) and ended.group_id[0] != 0
    assert "1 in g" in run.told()


def test_a_second_group_throws(world):
    run = world("A period=1", "A start 1: join g, join g, join h", "A act 1: leave g, join h")
    groups = []
    for act in (run.reset, run.step):
        act()
        groups += [*run.env.get_steps("Ball?team=0")[0].group_id]
    assert len(set(groups) - {0}) == 2
    assert len([line for line in run.told() if line.startswith("A threw UnityAgentsException")]) == 1


@pytest.mark.parametrize(("deed", "name"), [("add NaN", "AddReward"), ("set Infinity", "SetReward")])
def test_a_reward_that_is_no_number_throws_with_the_name_of_the_method(deed, name, world):
    run = world("A period=1", f"A act 1: {deed}")
    run.reset()
    assert run.step() == [("wants", 0, 0, 2)]
    (thrown,) = [line for line in run.told() if "threw" in line]
    assert name in thrown
