"""ML-Agents' own tests of its steps and side channels, in this kit's words: what its types and channels do there, they
do here.
"""

import pickle
import uuid
from typing import Any

import pytest

np = pytest.importorskip("numpy", reason="ML-Agents' environment needs numpy: kit.py run 9 installs it")

from netmq_example.mlagents_envs import exception  # noqa: E402
from netmq_example.mlagents_envs.base_env import (  # noqa: E402
    ActionSpec,
    ActionTuple,
    BehaviorMapping,
    BehaviorSpec,
    DecisionStep,
    DecisionSteps,
    DimensionProperty,
    ObservationSpec,
    ObservationType,
    TerminalStep,
    TerminalSteps,
    _ActionTupleBase,
)
from netmq_example.mlagents_envs.exception import (  # noqa: E402
    UnityActionException,
    UnityCommunicationException,
    UnityException,
)
from netmq_example.mlagents_envs.side_channel import (  # noqa: E402
    DefaultTrainingAnalyticsSideChannel,
    EngineConfigurationChannel,
    EnvironmentParametersChannel,
    IncomingMessage,
    OutgoingMessage,
    RawBytesChannel,
    SideChannel,
    SideChannelManager,
)

SEEN = ObservationSpec((3, 2), (DimensionProperty.UNSPECIFIED,) * 2, ObservationType.DEFAULT, "seen")
GOAL = ObservationSpec((5,), (DimensionProperty.NONE,), ObservationType.GOAL_SIGNAL, "goal")
SPEC = BehaviorSpec([SEEN, GOAL], ActionSpec.create_hybrid(2, (3, 4)))


def decisions():
    ids = np.array([10, 7, 12], np.int32)
    masks = [np.zeros((3, 3), bool), np.zeros((3, 4), bool)]
    masks[1][1, 2] = True
    seen = [np.arange(18, dtype=np.float32).reshape(3, 3, 2), np.ones((3, 5), np.float32)]
    group = np.array([0, 2, 2], np.int32)
    return DecisionSteps(seen, np.array([0, 1, 2], np.float32), ids, masks, group, np.array([0, 5, 6], np.float32))


def ended():
    seen = [np.zeros((2, 3, 2), np.float32), np.zeros((2, 5), np.float32)]
    ids, cut = np.array([4, 3], np.int32), np.array([True, False])
    return TerminalSteps(seen, np.array([1, 2], np.float32), cut, ids, np.zeros(2, np.int32), np.zeros(2, np.float32))


# Steps


def test_decision_steps_are_a_mapping_by_id():
    steps = decisions()
    assert (len(steps), list(steps), dict(steps.agent_id_to_index)) == (3, [10, 7, 12], {10: 0, 7: 1, 12: 2})
    assert steps.agent_id_to_index is steps.agent_id_to_index, "made once"
    one = steps[7]
    assert isinstance(one, DecisionStep) and (one.reward, one.agent_id, one.group_id, one.group_reward) == (1, 7, 2, 5)
    assert one.obs[0].tolist() == [[6, 7], [8, 9], [10, 11]]
    assert [mask.tolist() for mask in one.action_mask] == [[False] * 3, [False, False, True, False]]
    assert 12 in steps and 0 not in steps
    assert np.int32(12) in steps and steps[np.int32(12)].agent_id == 12
    with pytest.raises(KeyError) as raised:
        steps[0]
    assert str(raised.value) == "agent 0 is not among these 3"
    steps.obs = [steps.obs[1]]
    assert steps[10].obs[0].tolist() == [1] * 5, "observations may be replaced"


def test_terminal_steps_have_six_values_in_ml_agents_order():
    steps = ended()
    one = steps[3]
    assert isinstance(one, TerminalStep) and (one.interrupted, one.agent_id, one.reward) == (False, 3, 2)
    assert (list(steps), steps.interrupted.tolist(), steps[4].interrupted) == ([4, 3], [True, False], True)
    kinds: list[Any] = [DecisionSteps, TerminalSteps, DecisionStep, TerminalStep]
    for kind in kinds:
        with pytest.raises(TypeError):
            kind([], np.zeros(0), np.zeros(0))


@pytest.mark.parametrize("kind", [DecisionSteps, TerminalSteps])
def test_steps_of_nobody(kind):
    none = kind.empty(SPEC)
    assert (len(none), list(none)) == (0, [])
    assert [(seen.shape, seen.dtype) for seen in none.obs] == [((0, 3, 2), np.float32), ((0, 5), np.float32)]
    assert [none.agent_id.dtype, none.group_id.dtype] == [np.int32] * 2
    assert none.reward.dtype == none.group_reward.dtype == np.float32
    if kind is TerminalSteps:
        assert none.interrupted.dtype == bool
    else:
        assert none.action_mask is None


def test_specs():
    shape, properties, kind, name = SEEN
    assert (shape, properties, kind, name) == ((3, 2), (0, 0), ObservationType.DEFAULT, "seen")
    floats, branches = ActionSpec.create_continuous(3), ActionSpec.create_discrete((2, 3))
    assert (floats.is_continuous(), floats.is_discrete(), floats.discrete_size) == (True, False, 0)
    assert (branches.is_continuous(), branches.is_discrete(), branches.discrete_size) == (False, True, 2)
    assert not SPEC.action_spec.is_continuous() and not SPEC.action_spec.is_discrete()
    assert [tuple(one) for one in (floats, branches, SPEC.action_spec)] == [(3, ()), (0, (2, 3)), (2, (3, 4))]
    observation_specs, action_spec = SPEC
    assert observation_specs == [SEEN, GOAL] and tuple(action_spec) == (2, (3, 4))
    assert DimensionProperty.VARIABLE_SIZE | DimensionProperty.TRANSLATIONAL_EQUIVARIANCE == 6


def test_specs_have_the_names_of_2020():
    floats = BehaviorSpec([SEEN], ActionSpec.create_continuous(3))
    branches = BehaviorSpec([SEEN, GOAL], ActionSpec.create_discrete((2, 3)))
    assert branches.observation_shapes == [(3, 2), (5,)]
    assert (floats.action_shape, floats.action_size, floats.discrete_action_branches) == (3, 3, None)
    assert (branches.action_shape, branches.action_size, branches.discrete_action_branches) == ((2, 3), 2, (2, 3))
    assert floats.is_action_continuous() and not floats.is_action_discrete() and branches.is_action_discrete()


def test_empty_and_random_actions():
    for spec in (ActionSpec.create_continuous(3), ActionSpec.create_discrete((5, 2)), SPEC.action_spec):
        for count in (0, 1, 4):
            zeros, drawn = spec.empty_action(count), spec.random_action(count)
            for action in (zeros, drawn):
                assert action.continuous.shape == (count, spec.continuous_size)
                assert action.discrete.shape == (count, spec.discrete_size)
                assert (action.continuous.dtype, action.discrete.dtype) == (np.float32, np.int32)
            assert not zeros.continuous.any() and not zeros.discrete.any()
    np.random.seed(3)
    first = SPEC.action_spec.random_action(100)
    np.random.seed(3)
    assert (SPEC.action_spec.random_action(100).discrete == first.discrete).all()
    assert np.abs(first.continuous).max() <= 1 and [*first.discrete.min(0), *first.discrete.max(0)] == [0, 0, 2, 3]


def test_an_action_has_the_half_that_is_not_given():
    assert (ActionTuple().continuous, ActionTuple().discrete) == (None, None)
    floats = ActionTuple(np.ones((2, 3)))
    assert (floats.continuous.dtype, floats.discrete.shape, floats.discrete.dtype) == (np.float32, (2, 0), np.int32)
    whole = ActionTuple(discrete=[[1], [2]])
    assert (whole.continuous.shape, whole.discrete.tolist()) == ((2, 0), [[1], [2]])
    assert ActionTuple(discrete=np.array([[1.0]])).discrete.tolist() == [[1]]
    for wrong in (1.5, 2**40):
        with pytest.raises(UnityActionException, match=r"^discrete actions are whole numbers of 32 bits, not array"):
            ActionTuple(discrete=np.array([[wrong]]))

    class LogProbabilities(_ActionTupleBase):
        discrete_dtype = np.float32

    assert LogProbabilities(discrete=np.array([[-0.5]])).discrete.dtype == np.float32


def test_all_of_it_can_be_pickled():
    steps, over = pickle.loads(pickle.dumps((decisions(), ended())))
    assert list(steps) == [10, 7, 12] and steps[7].group_reward == 5 and over[4].interrupted
    mapping = pickle.loads(pickle.dumps(BehaviorMapping({"Ball?team=0": SPEC})))
    assert (list(mapping), mapping["Ball?team=0"], len(mapping)) == (["Ball?team=0"], SPEC, 1)
    action = pickle.loads(pickle.dumps(SPEC.action_spec.empty_action(2)))
    assert action.discrete.shape == (2, 2)
    assert issubclass(exception.UnityPolicyException, UnityException)
    for kind in vars(exception).values():
        if not isinstance(kind, type) or not issubclass(kind, UnityException):
            continue
        raised = kind("why")
        again = pickle.loads(pickle.dumps(raised))
        assert (type(again), str(again)) == (type(raised), str(raised)) and isinstance(again, UnityException)


# Side channels


def carried(sender, receiver):
    SideChannelManager([receiver]).process_side_channel_message(
        bytes(SideChannelManager([sender]).generate_side_channel_messages())
    )


class Numbers(SideChannel):
    def __init__(self):
        super().__init__(uuid.UUID("a85ba5c0-4f87-11ea-a517-784f4387d1f7"))
        self.received = []

    def on_message_received(self, msg):
        self.received.append(msg.read_int32())

    def send(self, number):
        msg = OutgoingMessage()
        msg.write_int32(number)
        self.queue_message_to_send(msg)


@pytest.mark.parametrize(
    ("channel", "send"),
    [
        (EngineConfigurationChannel, lambda it: it.set_configuration_parameters(width=4, height=5, time_scale=2.0)),
        (EnvironmentParametersChannel, lambda it: it.set_float_parameter("gravity", 9.5)),
    ],
)
def test_settings_go_to_unity_only(channel, send, caplog):
    sender, receiver = channel(), RawBytesChannel(channel().channel_id)
    send(sender)
    carried(sender, receiver)
    messages = receiver.get_and_clear_received_messages()
    assert messages
    with pytest.raises(UnityCommunicationException):
        sender.on_message_received(IncomingMessage(bytes(messages[0])))
    # In an exchange it is one line, and the others get theirs.
    send(sender)
    carried(sender, channel())
    assert "came from Unity" in caplog.text


class OfAnotherPackage:
    """As ML-Agents' own SideChannel is: it is no class of this kit."""

    def __init__(self):
        self.channel_id = uuid.UUID("a85ba5c0-4f87-11ea-a517-784f4387d1f7")
        self.message_queue = [bytearray(b"\4\0\0\0")]
        self.received = []

    def on_message_received(self, msg):
        self.received.append(msg.read_int32())


def test_channels_of_ml_agents_own_package_are_carried():
    foreign, own = OfAnotherPackage(), Numbers()
    manager = SideChannelManager([foreign])
    SideChannelManager([own]).process_side_channel_message(bytes(manager.generate_side_channel_messages()))
    assert own.received == [4] and foreign.message_queue == []
    own.send(7)
    manager.process_side_channel_message(bytes(SideChannelManager([own]).generate_side_channel_messages()))
    assert foreign.received == [7]
    assert manager._side_channels_dict == {foreign.channel_id: foreign}
    with pytest.raises(TypeError, match=r"^channel takes a Channel, not 'log'$"):
        SideChannelManager(["log"])


def test_unitys_analytics_are_told_nothing():
    channel = DefaultTrainingAnalyticsSideChannel()
    channel.environment_initialized()
    assert channel.message_queue == [] and str(channel.channel_id).startswith("b664a4a9-")
