"""ML-Agents' shape in the player, and lesson 11's rays: the numbers of each sensor, actions, masks, and the names of
fields in its scenes.
"""

import pytest

# The output of the program, part by part. All numbers were worked out by hand, from ML-Agents' source 3.0.0.
PRINTED = """
Vectors:
VectorSensor_size16 [16] 0 1: 1.5 2 3 4 5 6 7 8 9 0.1 0.2 0.3 0.4 1 0 1
VectorSensor_size16 was given 1 numbers and has 16: zeros are padded. Set its size to 1; that of CollectObservations \
is in Behavior Parameters
VectorSensor_size16 [16] 0 1: 1 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0
VectorSensor_size16 [16] 0 1: 1 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0
few was given 3 numbers and has 2: the rest is cut. Set its size to 3; that of CollectObservations is in Behavior \
Parameters
few [2] 0 1: 1 2
VectorSensor_size1_GoalSignal was given 0 numbers and has 1: zeros are padded. Set its size to 0; that of \
CollectObservations is in Behavior Parameters
VectorSensor_size1_GoalSignal [1] 1 1: 0
UnityAgentsException: AddObservation was given NaN: look for a division by 0 in the script
UnityAgentsException: AddObservation was given Infinity: look for a division by 0 in the script
StackingSensor_size3_VectorSensor_size2 [6] 0 1: 0 0 0 0 1 -1
StackingSensor_size3_VectorSensor_size2 [6] 0 1: 0 0 1 -1 2 -2
StackingSensor_size3_VectorSensor_size2 [6] 0 1: 1 -1 2 -2 3 -3
StackingSensor_size3_VectorSensor_size2 [6] 0 1: 2 -2 3 -3 4 -4
2 -2 3 -3 4 -4
StackingSensor_size3_VectorSensor_size2 [6] 0 1: 0 0 0 0 5 -5
Buffers:
BufferSensor [3, 2] 0 4,1: 1 2 3 4 0 0
BufferSensor [3, 2] 0 4,1: 1 2 3 4 5 6
BufferSensor [3, 2] 0 4,1: 0 0 0 0 0 0
UnityAgentsException: BufferSensor was given a row of 1 numbers: its Observable Size is 2
UnityAgentsException: AppendObservation was given Infinity: look for a division by 0 in the script
UnityAgentsException: BufferSensor cannot be stacked: only vectors and pictures can
Views:
thin: 1 0 0 0.75 0 1 0 0.5 0 0 1 1
thick: 1 0 0 0.625 0 1 0 0.375 0 0 1 1
without layer 3: 1 0 0 0.75 0 0 1 1 0 0 1 1
turned: 0 1 0 0.5 0 0 1 1 1 0 0 0.75
small: 0 0 1 1 0 0 1 1 0 0 1 1
Rays:
RayPerceptionSensor [12] 0 1: 1 0 0 0.75 0 1 0 0.5 0 0 1 1
RayPerceptionSensor [12] 0 1: 1 0 0 0.625 0 1 0 0.375 0 0 1 1
RayPerceptionSensor [12] 0 1: 1 0 0 0.625 0 0 1 1 0 0 1 1
RayPerceptionSensor [12] 0 1: 1 0 0 0.25 0 1 0 0.125 0 0 1 1
RayPerceptionSensor [12] 0 1: 0 0 1 1 0 0 1 1 0 0 1 1
RayPerceptionSensor [12] 0 1: 0 1 0 0.375 1 0 0 0.625 0 0 1 1
wall 0 0.625 4 0.5
RayPerceptionSensor: the number of rays and tags cannot change in Play: set it before the agent is enabled
StackingSensor_size2_RayPerceptionSensor [4] 0 1: 0 0 1 1
RayPerceptionSensor: the number of rays and tags cannot change in Play: set it before the agent is enabled
30 60 90 120 150
90 60 120 30 150
Flat:
RayPerceptionSensor [12] 0 1: 1 0 0 0.75 0 1 0 0.5 0 0 1 1
RayPerceptionSensor [12] 0 1: 1 0 0 0.625 0 1 0 0.375 0 0 1 1
RayPerceptionSensor [12] 0 1: 0 0 0 0 0 0 0 0 0 0 0 0
Pictures:
UnityAgentsException: eye: its Camera Sensor has no Camera: give it one
False True
CameraSensor [3, 2, 4] uint8 0 1,2,2: 200 200 10 10 10 10 10 10 100 100 20 20 20 20 20 20 50 50 31 31 31 31 31 31
StackingSensor_size2_CameraSensor [2, 2, 4] uint8 0 1,2,2: 0 0 0 0 0 0 0 0 117 117 20 20 20 20 20 20
StackingSensor_size2_CameraSensor [2, 2, 4] uint8 0 1,2,2: 117 117 20 20 20 20 20 20 0 0 0 0 0 0 0 0
StackingSensor_size2_CameraSensor [2, 2, 4] uint8 0 1,2,2: 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0
True
UnityAgentsException: screen: its Render Texture Sensor has no Render Texture: give it one
RenderTextureSensor [3, 2, 2] uint8 0 1,2,2: 0 0 0 0 0 0 0 0 0 0 0 0
RenderTextureSensor [3, 2, 2] uint8 0 1,2,2: 1 1 1 1 2 2 2 2 3 3 3 3
CameraSensor sees black only, for there is no graphics card: start without -nographics
StackingSensor_size2_CameraSensor [2, 2, 4] uint8 0 1,2,2: 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0
Textures:
Texture [3, 2, 2] 0 1,2,2: 0 0.2 1 0 0 0.4 0 0 0 0.8 0 0
Texture [1, 2, 2] 0 1,2,2: 0 0.467 0.333 0
Lists:
VectorSensor_size3 StackingSensor_size2_VectorSensor_size3: a, b, old, Own, StackingSensor_size2_VectorSensor_size3
Own [2, 1, 3] 0 1,2,2: 0 0 0 0 0 0.5
UnityAgentsException: a sensor writes to place 3 of 3: compare its Write with its GetObservationSpec
[Observable] Ant.Song cannot be seen: give it a getter, and one of the types int, bool, float, Vector2, Vector3, \
Vector4, Quaternion or an enum
none none: b, legs, ObservableAttribute:Ant.mood, ObservableAttribute:Ant.Place, ObservableAttribute:Ant.senses, \
StackingSensor_size2_ObservableAttribute:Ant.Awake
b [0] 0 1:
legs [1] 0 1: 6
ObservableAttribute:Ant.mood [2] 0 1: 0 1
ObservableAttribute:Ant.Place [4] 0 1: 1 2 3 4
ObservableAttribute:Ant.senses [2] 0 1: 0 1
StackingSensor_size2_ObservableAttribute:Ant.Awake [2] 0 1: 0 1
[Observable] Ant.Song cannot be seen: give it a getter, and one of the types int, bool, float, Vector2, Vector3, \
Vector4, Quaternion or an enum
ant: a Grid Sensor does not see here: use a Ray Perception Sensor, or write a SensorComponent of your own
ant has two sensors called b, and their order may change: give each a Sensor Name of its own
ant: actuators of one's own do not act here: move what they do into OnActionReceived, and their actions into Behavior \
Parameters
VectorSensor_size1 none: b, b, ObservableAttribute:Ant.mood, ObservableAttribute:Ant.Place, \
ObservableAttribute:Ant.senses, StackingSensor_size2_ObservableAttribute:Ant.Awake, VectorSensor_size1
UnityAgentsException: EmptyComponent makes no sensor: override CreateSensors
Actions:
1 9 3 4 | 9 3 | 12 2 1 4 2
IndexOutOfRangeException: action 2 of 2: does Behavior Parameters have as many?
ArgumentOutOfRangeException: 2 actions from 1 on are more than the array's 2 (Parameter 'offset')
1 0 0 4 | 0 False True 0
True False True
2 2 5 2
False
True 0 1 0 1 0
UnityAgentsException: all choices of branch 1 are masked: WriteDiscreteActionMask must leave one
UnityAgentsException: a mask for choice 2 of branch 1: Behavior Parameters has branches of 3, 2 choices, and both are \
counted from 0
False
Settings:
Ant?team=2 True
a model: True False True
ant: a model does not run here, and its Heuristic decides. Let Python decide: Behavior Type Default, and \
mlagents_learn with --resume --inference before you press Play
4
True
ant: demonstrations are not recorded here: record them with Unity's package ML-Agents in another copy of the project, \
and give mlagents_learn their .demo files
""".strip().split("\n")


def test_what_sensors_write_and_what_is_said_of_mistakes(play):
    program = play("mlsensors")
    assert program.wait() == 0, program.output
    assert [line.rstrip() for line in program.lines[:-1]] == PRINTED
    left = program.lines[-1].removeprefix("left: ").split()
    assert [name for name in left if name.startswith("Texture2D")] == [], "a sensor's pixels"
    assert left.count("RenderTexture") == 1, "the scene's own"


# Each as Unity writes it, with the fields of that version; behind a # is what a property then says. In 1.0 names before
# 1.0 still stand where a scene was not saved again. 3.0 has only what is not as in 2.0.
SCENES = {
    "1.0": """
--- BehaviorParameters
  m_BrainParameters:
    vectorObservationSize: 8  # BrainParameters.VectorObservationSize: 8
    numStackedVectorObservations: 3  # BrainParameters.NumStackedVectorObservations: 3
    vectorActionSize: 02000000  # BrainParameters.ActionSpec.NumContinuousActions: 2
    vectorActionDescriptions: []
    vectorActionSpaceType: 1  # BrainParameters.ActionSpec.NumDiscreteActions: 0
  m_Model: {fileID: 11400000, guid: b0a629580a0ab48a5a774f90ff1fb48b, type: 3}
  m_InferenceDevice: 1  # InferenceDevice: GPU
  m_BehaviorType: 1  # BehaviorType: HeuristicOnly
  m_BehaviorName: 3DBall  # FullyQualifiedBehaviorName: 3DBall?team=1
  m_TeamID: 1
  m_useChildSensors: 0  # UseChildSensors: False  # UseChildActuators: True
--- RayPerceptionSensorComponent3D
  sensorName: OfOld  # SensorName: OfOld
  detectableTags:  # DetectableTags: wall coin
  - wall
  - coin
  raysPerDirection: 5  # RaysPerDirection: 5
  maxRayDegrees: 90  # MaxRayDegrees: 90
  sphereCastRadius: 0.25  # SphereCastRadius: 0.25
  rayLength: 30  # RayLength: 30
  rayLayerMask:  # RayLayerMask: 8
    serializedVersion: 2
    m_Bits: 8
  observationStacks: 2  # ObservationStacks: 2  # AlternatingRayOrder: True
  rayHitColor: {r: 1, g: 0.5, b: 0, a: 1}
  rayMissColor: {r: 1, g: 1, b: 1, a: 1}
  startVerticalOffset: 0.5  # StartVerticalOffset: 0.5
  endVerticalOffset: -0.5  # EndVerticalOffset: -0.5
--- CameraSensorComponent
  camera: {fileID: 1}
  sensorName: Eye  # SensorName: Eye
  width: 20  # Width: 20
  height: 10  # Height: 10
  grayscale: 1  # Grayscale: True
  compression: 0  # CompressionType: None  # ObservationStacks: 1
--- RenderTextureSensorComponent
  renderTexture: {fileID: 8400000, guid: 4e8f2e8f8b4f14a3b8a8a8f8f8a8f8a8, type: 2}
  sensorName: Screen  # SensorName: Screen
  grayscale: 1  # Grayscale: True
  compression: 0
--- DemonstrationRecorder
  record: 1  # Record: True
  demonstrationName: Expert  # DemonstrationName: Expert
  demonstrationDirectory: Demos  # DemonstrationDirectory: Demos
""",
    "2.0": """
--- BehaviorParameters
  m_BrainParameters:
    VectorObservationSize: 243  # BrainParameters.VectorObservationSize: 243
    NumStackedVectorObservations: 1
    m_ActionSpec:
      m_NumContinuousActions: 0  # BrainParameters.ActionSpec.NumContinuousActions: 0
      BranchSizes:
    VectorActionSize: 030000000300000002000000  # BrainParameters.ActionSpec.BranchSizes: 3 3 2
    VectorActionDescriptions: []
    VectorActionSpaceType: 0
    hasUpgradedBrainParametersWithActionSpec: 0
  m_Model: {fileID: 0}
  m_InferenceDevice: 2  # InferenceDevice: Burst
  m_BehaviorType: 0  # BehaviorType: Default
  m_BehaviorName: Crawler  # FullyQualifiedBehaviorName: Crawler?team=0
  TeamId: 0
  m_UseChildSensors: 1  # UseChildSensors: True
  m_UseChildActuators: 1
  m_ObservableAttributeHandling: 2  # ObservableAttributeHandling: ExamineAll
--- RayPerceptionSensorComponent2D
  m_SensorName: Flat  # SensorName: Flat
  m_DetectableTags: []  # DetectableTags:
  m_RaysPerDirection: 1
  m_MaxRayDegrees: 45
  m_SphereCastRadius: 0
  m_RayLength: 10
  m_RayLayerMask:  # RayLayerMask: -5
    serializedVersion: 2
    m_Bits: 4294967291
  m_ObservationStacks: 1
  rayHitColor: {r: 1, g: 0, b: 0, a: 1}
  rayMissColor: {r: 1, g: 1, b: 1, a: 1}
--- BufferSensorComponent
  m_SensorName: Bees  # SensorName: Bees
  m_ObservableSize: 4  # ObservableSize: 4
  m_MaxNumObservables: 20  # MaxNumObservables: 20
--- VectorSensorComponent
  m_SensorName: Goal  # SensorName: Goal
  m_ObservationSize: 2  # ObservationSize: 2
  m_ObservationType: 1  # ObservationType: GoalSignal
  m_ObservationStacks: 1
""",
    "3.0": """
--- BehaviorParameters
  m_BrainParameters:
    VectorObservationSize: 0  # BrainParameters.VectorObservationSize: 0
    NumStackedVectorObservations: 1
    m_ActionSpec:
      m_NumContinuousActions: 3  # BrainParameters.ActionSpec.NumContinuousActions: 3
      BranchSizes: 02000000  # BrainParameters.ActionSpec.BranchSizes: 2
    VectorActionSize: []
    VectorActionDescriptions: []
    VectorActionSpaceType: 1
    hasUpgradedBrainParametersWithActionSpec: 1
  m_InferenceDevice: 3  # InferenceDevice: CPU
  m_BehaviorType: 2  # BehaviorType: InferenceOnly
  m_BehaviorName: Walker  # FullyQualifiedBehaviorName: Walker?team=4
  TeamId: 4
  m_DeterministicInference: 1  # DeterministicInference: True
  m_ObservableAttributeHandling: 1  # ObservableAttributeHandling: ExcludeInherited
--- RayPerceptionSensorComponent3D
  m_SensorName: Rays  # SensorName: Rays
  m_DetectableTags:
  - wall
  m_RaysPerDirection: 3
  m_MaxRayDegrees: 70
  m_SphereCastRadius: 0.5
  m_RayLength: 20
  m_RayLayerMask:  # RayLayerMask: 1
    serializedVersion: 2
    m_Bits: 1
  m_ObservationStacks: 1
  m_AlternatingRayOrder: 0  # AlternatingRayOrder: False
  m_UseBatchedRaycasts: 1  # UseBatchedRaycasts: True
  m_StartVerticalOffset: 1  # StartVerticalOffset: 1
  m_EndVerticalOffset: 2  # EndVerticalOffset: 2
--- CameraSensorComponent
  m_Camera: {fileID: 2}
  m_SensorName: Eye
  m_Width: 64  # Width: 64
  m_Height: 48  # Height: 48
  m_Grayscale: 0
  m_ObservationType: 1  # ObservationType: GoalSignal
  m_RuntimeCameraEnable: 1  # RuntimeCameraEnable: True
  m_ObservationStacks: 4  # ObservationStacks: 4
  m_Compression: 1  # CompressionType: PNG
--- RenderTextureSensorComponent
  m_RenderTexture: {fileID: 0}
  m_SensorName: Screen
  m_Grayscale: 0
  m_ObservationStacks: 2  # ObservationStacks: 2
  m_Compression: 1
--- DemonstrationRecorder
  Record: 0  # Record: False
  NumStepsToRecord: 100  # NumStepsToRecord: 100
  DemonstrationName: Expert
  DemonstrationDirectory:
""",
}


@pytest.mark.parametrize("era", SCENES)
def test_scenes_of_three_eras_keep_their_values(play, tmp_path, era):
    scene, expected, component = [], [], ""
    for line in SCENES[era].strip().split("\n"):
        field, *said = line.split("  # ")
        scene.append(field)
        component = field.removeprefix("--- ") if field.startswith("---") else component
        expected += [f"{component}.{each}" for each in said]
    path = tmp_path / "scene.txt"
    path.write_text("\n".join(scene), encoding="utf-8")
    program = play("mlscene", path)
    assert program.wait() == 0, program.output
    assert [line for line in program.lines if " has no " in line] == [], "fields that would be lost"
    said = [line.rstrip() for line in program.lines]
    assert [line for line in expected if line not in said] == [], program.output


# A ball falls from 10 m by 8 m/s², a step each half second, through a gate around 4 m to two floors around -13 m.
TOUCHED = """
Early wakes
Late wakes
Early
Late
ball: gate enters
gate: ball enters
0.5: 4 -8
ball: gate leaves
gate: ball leaves
1: -2 -12
ball: floor hits False
floor: ball hits True
ball: other hits False
1.5: -10 -16
ball: off
floor: off
ball: off
2: -20 -20
2.5: -32 -24
(1.0, 100.0, 0.0)
5 -1 -1 17 Ignore Raycast ''
""".strip().split("\n")


def test_the_player_tells_scripts_what_they_touch(play):
    program = play("touches")
    assert program.wait() == 0, program.output
    assert program.lines == TOUCHED
