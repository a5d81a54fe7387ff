// Prints what ML-Agents' sensors write, and lesson 11's rays, a line for each:
//
//     … play.dll mlsensors     numbers, actions and masks, and what is said of mistakes
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using System.Runtime.InteropServices;
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.Actuators;
using NetMQExample.MLAgents.Demonstrations;
using NetMQExample.MLAgents.Inference;
using NetMQExample.MLAgents.Policies;
using NetMQExample.MLAgents.Sensors;
using NetMQExample.MLAgents.Sensors.Reflection;
using UnityEngine;
using UnityPlayer;
using FrameBuffer = NetMQExample.FrameBuffer;
using NetMQLifetime = NetMQExample.NetMQLifetime;
using RayView = NetMQExample.RayView;

// As a project's own: within NetMQExample, the lessons' names would go before ML-Agents'.
namespace MlTest
{
    internal static class MlSensors
    {
        private static readonly FrameBuffer Buffer = new FrameBuffer();

        public static int Run()
        {
            var player = new Player(typeof(NetMQLifetime).Assembly);
            var shows = new Action[] {
                Vectors, Buffers, Views, Rays, Flat, Pictures, Textures, Lists, Actions, Settings,
            };
            foreach (var show in shows)
            {
                player.Begin(() =>
                {
                    Console.WriteLine($"{show.Method.Name}:");
                    show();
                });
                player.Frame();
                player.Stop();
            }
            Console.WriteLine($"left: {string.Join(" ", Player.Left)}");
            return 0;
        }

        // Three rays of 4 m, a quarter turn apart.
        private static T Eye<T>(params string[] tags) where T : RayPerceptionSensorComponentBase
        {
            var eye = new GameObject("eye").AddComponent<T>();
            eye.DetectableTags = new List<string>(tags);
            eye.RaysPerDirection = 1;
            eye.MaxRayDegrees = 90;
            eye.RayLength = 4;
            eye.SphereCastRadius = 0;
            return eye;
        }

        private static void Vectors()
        {
            var vector = new VectorSensor(16);
            vector.AddObservation(1.5f);
            vector.AddObservation(2);
            vector.AddObservation(new Vector3(3, 4, 5));
            vector.AddObservation(new Vector2(6, 7));
            vector.AddObservation(new List<float> { 8, 9 });
            vector.AddObservation(new Quaternion(0.1f, 0.2f, 0.3f, 0.4f));
            // A game object, which some add, is there or not.
            vector.AddObservation(new GameObject("there"));
            vector.AddOneHotObservation(1, 2);
            Show(vector);
            vector.Update();
            vector.AddObservation(true);
            Show(vector);
            Show(vector);
            var few = new VectorSensor(2, "few");
            few.AddObservation(new[] { 1f, 2, 3 });
            Show(few);
            Show(new VectorSensor(1, observationType: ObservationType.GoalSignal));
            Say(() => few.AddObservation(float.NaN));
            Say(() => few.AddObservation(new Vector3(0, 1f / Zero, 0)));
            var one = new VectorSensor(2);
            var stack = new StackingSensor(one, 3);
            for (var i = 1; i <= 4; i++)
            {
                stack.Update();
                one.AddObservation(i);
                one.AddObservation(-i);
                Show(stack);
            }
            Console.WriteLine(string.Join(" ", stack.GetStackedObservations()));
            stack.Reset();
            stack.Update();
            one.AddObservation(new Vector2(5, -5));
            Show(stack);
        }

        private static float Zero => 0;

        private static void Buffers()
        {
            var component = new GameObject("bee").AddComponent<BufferSensorComponent>();
            component.ObservableSize = 2;
            component.MaxNumObservables = 3;
            var sensor = component.CreateSensors()[0];
            component.AppendObservation(new[] { 1f, 2 });
            component.AppendObservation(new[] { 3f, 4 });
            Show(sensor);
            component.AppendObservation(new[] { 5f, 6 });
            component.AppendObservation(new[] { 7f, 8 });
            Show(sensor);
            sensor.Update();
            Show(sensor);
            Say(() => component.AppendObservation(new[] { 1f }));
            Say(() => component.AppendObservation(new[] { 1f, float.PositiveInfinity }));
            Say(() => _ = new StackingSensor(sensor, 2));
        }

        // A wall ahead at 3 m, and a coin to the right at 2 m.
        private static void Room()
        {
            var wall = Thing(PrimitiveType.Cube, "wall", new Vector3(0, 0, 3.5f));
            wall.transform.localScale = new Vector3(20, 1, 1);
            Thing(PrimitiveType.Sphere, "coin", new Vector3(2.5f, 0, 0)).layer = 3;
        }

        private static void Views()
        {
            Room();
            var car = new GameObject("car").transform;
            View("thin", car, 0, -5);
            View("thick", car, 0.5f, -5);
            View("without layer 3", car, 0, ~(1 << 3));
            car.rotation = Quaternion.Euler(0, 90, 0);
            View("turned", car, 0, -5);
            // Its own collider is around the place where rays begin.
            car.rotation = Quaternion.identity;
            car.gameObject.AddComponent<BoxCollider>();
            car.localScale = new Vector3(0.25f, 0.25f, 0.25f);
            View("small", car, 0, -5);
        }

        private static void View(string what, Transform car, float radius, int layers)
        {
            var seen = new float[12];
            new RayView(car, 1, 90, 4, radius, layers, "wall", "coin").Observe(seen);
            Console.WriteLine($"{what}: {Numbers(seen)}");
        }

        private static void Rays()
        {
            Room();
            var eye = Eye<RayPerceptionSensorComponent3D>("wall", "coin");
            var rays = (RayPerceptionSensor)eye.CreateSensors()[0];
            Look(rays);
            eye.SphereCastRadius = 0.5f;
            Look(rays);
            eye.RayLayerMask = ~(1 << 3);
            Look(rays);
            eye.RayLayerMask = -5;
            eye.transform.localScale = new Vector3(2, 2, 2);
            Look(rays);
            eye.transform.localScale = Vector3.one;
            eye.StartVerticalOffset = 5;
            eye.EndVerticalOffset = 5;
            Look(rays);
            eye.AlternatingRayOrder = false;
            eye.StartVerticalOffset = 0;
            eye.EndVerticalOffset = 0;
            Look(rays);
            var seen = RayPerceptionSensor.Perceive(eye.GetRayPerceptionInput()).RayOutputs[1];
            Console.WriteLine(FormattableString.Invariant($"{seen.HitGameObject.name} {seen.HitTagIndex} ")
                + FormattableString.Invariant($"{seen.HitFraction} {seen.ScaledRayLength} {seen.ScaledCastRadius}"));
            eye.DetectableTags = null;
            eye.RayLength = 1;
            eye.RaysPerDirection = 0;
            eye.ObservationStacks = 2;
            var stack = eye.CreateSensors()[0];
            Look(stack);
            eye.RaysPerDirection = 2;
            eye.MaxRayDegrees = 60;
            Console.WriteLine(string.Join(" ", eye.GetRayPerceptionInput().Angles));
            eye.AlternatingRayOrder = true;
            Console.WriteLine(string.Join(" ", eye.GetRayPerceptionInput().Angles));
        }

        private static void Flat()
        {
            var wall = new GameObject("wall") { tag = "wall" }.AddComponent<BoxCollider2D>();
            wall.transform.position = new Vector3(0, 3.5f, 7);
            wall.size = new Vector2(20, 1);
            var ball = new GameObject("ball") { tag = "ball" }.AddComponent<CircleCollider2D>();
            ball.transform.position = new Vector3(2.5f, 0, 0);
            var eye = Eye<RayPerceptionSensorComponent2D>("wall", "ball");
            var rays = (RayPerceptionSensor)eye.CreateSensors()[0];
            Look(rays);
            eye.SphereCastRadius = 0.5f;
            Look(rays);
            // Unlike in 3D, a ray meets the collider around it.
            eye.gameObject.AddComponent<CircleCollider2D>().radius = 0.1f;
            eye.SphereCastRadius = 0;
            Look(rays);
        }

        private static void Pictures()
        {
            var camera = new GameObject("camera").AddComponent<Camera>();
            camera.backgroundColor = new Color32(10, 20, 31, 255);
            var cube = GameObject.CreatePrimitive(PrimitiveType.Cube);
            cube.transform.position = new Vector3(-1, 1, 2);
            cube.transform.localScale = new Vector3(2, 2, 0.1f);
            cube.GetComponent<Renderer>().material.color = new Color32(200, 100, 50, 255);
            var eye = new GameObject("eye").AddComponent<CameraSensorComponent>();
            Say(() => eye.CreateSensors());
            eye.Camera = camera;
            eye.Width = 4;
            eye.Height = 2;
            var sensor = eye.CreateSensors()[0];
            eye.RuntimeCameraEnable = false;
            Console.WriteLine($"{camera.enabled} {camera.targetTexture == null}");
            Look(sensor);
            eye.Grayscale = true;
            eye.ObservationStacks = 2;
            (sensor as IDisposable)?.Dispose();
            sensor = eye.CreateSensors()[0];
            Look(sensor);
            camera.backgroundColor = new Color(0, 0, 0, 1);
            cube.SetActive(false);
            Look(sensor);
            sensor.Reset();
            Look(sensor);
            Console.WriteLine($"{camera.targetTexture == null}");
            (sensor as IDisposable)?.Dispose();
            var screen = new GameObject("screen").AddComponent<RenderTextureSensorComponent>();
            Say(() => screen.CreateSensors());
            screen.RenderTexture = new RenderTexture(2, 2, 24, RenderTextureFormat.ARGB32, RenderTextureReadWrite.sRGB);
            sensor = screen.CreateSensors()[0];
            Look(sensor);
            camera.backgroundColor = new Color32(1, 2, 3, 255);
            camera.targetTexture = screen.RenderTexture;
            camera.Render();
            Show(sensor);
            (sensor as IDisposable)?.Dispose();
            SystemInfo.NoGraphics = true;
            sensor = eye.CreateSensors()[0];
            Look(sensor);
            (sensor as IDisposable)?.Dispose();
            SystemInfo.NoGraphics = false;
        }

        private static void Lists()
        {
            var agent = new GameObject("ant").AddComponent<Ant>();
            var parameters = agent.gameObject.AddComponent<BehaviorParameters>();
            parameters.BrainParameters.VectorObservationSize = 3;
            parameters.BrainParameters.NumStackedVectorObservations = 2;
            agent.gameObject.AddComponent<VectorSensorComponent>().SensorName = "b";
            Below(agent, "child").AddComponent<VectorSensorComponent>().SensorName = "a";
            Below(agent, "asleep").AddComponent<VectorSensorComponent>().gameObject.SetActive(false);
            Below(agent, "own").AddComponent<OwnComponent>();
            Below(agent, "old").AddComponent<OldComponent>();
            Names(agent, parameters);
            Show(new OwnSensor());
            Say(() => Show(new OwnSensor { Wide = 3 }));
            parameters.UseChildSensors = false;
            parameters.ObservableAttributeHandling = ObservableAttributeOptions.ExamineAll;
            parameters.BrainParameters.VectorObservationSize = 0;
            foreach (var sensor in Names(agent, parameters)) Show(sensor);
            parameters.ObservableAttributeHandling = ObservableAttributeOptions.ExcludeInherited;
            parameters.BrainParameters.VectorObservationSize = 1;
            parameters.BrainParameters.NumStackedVectorObservations = 1;
            agent.gameObject.AddComponent<VectorSensorComponent>().SensorName = "b";
            agent.gameObject.AddComponent<GridSensorComponent>();
            agent.gameObject.AddComponent<OwnActuators>();
            Names(agent, parameters);
            Say(() => agent.gameObject.AddComponent<EmptyComponent>().CreateSensors());
        }

        private static void Actions()
        {
            var array = new[] { 1f, 2, 3, 4 };
            var buffers = new ActionBuffers(new ActionSegment<float>(array, 1, 2), new ActionSegment<int>(new[] { 7 }));
            var segment = buffers.ContinuousActions;
            segment[0] = 9;
            Console.WriteLine($"{string.Join(" ", array)} | {string.Join(" ", segment)} | {segment.Sum()} "
                + $"{segment.Length} {segment.Offset} {segment.Array.Length} {segment.ToList().Count}");
            Say(() => segment[2] = 1);
            Say(() => _ = new ActionSegment<int>(new int[2], 1, 2));
            buffers.Clear();
            Console.WriteLine($"{string.Join(" ", array)} | {buffers.DiscreteActions[0]} {buffers.IsEmpty()} "
                + $"{ActionBuffers.Empty.IsEmpty()} {default(ActionSegment<int>).Count()}");
            var chosen = ActionBuffers.FromDiscreteActions(new[] { 2f, 1 });
            Console.WriteLine($"{segment.Equals(new ActionSegment<float>(array, 1, 2))} {segment.Equals(default)} "
                + chosen.Equals(new ActionBuffers(null, new[] { 2, 1 })));
            var spec = ActionSpec.Combine(ActionSpec.MakeContinuous(2), ActionSpec.MakeDiscrete(3, 2), default);
            Console.WriteLine($"{spec.NumContinuousActions} {spec.NumDiscreteActions} {spec.SumOfDiscreteBranchSizes} "
                + $"{new ActionBuffers(spec).DiscreteActions.Length}");
            var mask = new DiscreteActionMask(spec.BranchSizes);
            Console.WriteLine($"{mask.Any}");
            mask.SetActionEnabled(0, 1, false);
            mask.WriteMask(1, new[] { 0 });
            mask.Check();
            Console.WriteLine($"{mask.Any} {string.Join(" ", mask.Bytes)}");
            mask.SetActionEnabled(1, 1, false);
            Say(mask.Check);
            Say(() => mask.SetActionEnabled(1, 2, false));
            mask.SetActionEnabled(1, 0, true);
            mask.Check();
            mask.Clear();
            Console.WriteLine($"{mask.Any}");
        }

        private static void Textures()
        {
            foreach (var gray in new[] { false, true })
            {
                var texture = new Texture2D(2, 2, TextureFormat.RGB24, false);
                texture.LoadRawTextureData(new byte[] { 255, 0, 0, 0, 0, 0, 0, 0, 0, 51, 102, 204 });
                Show(new TextureSensor(texture, gray));
                UnityEngine.Object.Destroy(texture);
            }
        }

        private static void Settings()
        {
            var ant = new GameObject("ant").AddComponent<BehaviorParameters>();
            ant.BehaviorName = "Ant";
            ant.TeamId = 2;
            Console.WriteLine($"{ant.FullyQualifiedBehaviorName} {ant.IsInHeuristicMode()}");
            ant.BehaviorType = BehaviorType.HeuristicOnly;
            ant.Model = ScriptableObject.CreateInstance<NNModel>();
            NNModel model = ant.Model;
            ModelAsset asset = ant.Model;
            Console.WriteLine($"a model: {model != null} {asset != null} {ant.Model != null}");
            ant.BehaviorType = BehaviorType.Default;
            ant.BrainParameters.ActionSpec = ActionSpec.MakeDiscrete(4);
            var copy = ant.BrainParameters.Clone();
            copy.ActionSpec.BranchSizes[0] = 5;
            Console.WriteLine(ant.BrainParameters.ActionSpec.BranchSizes[0]);
            ant.InferenceDevice = InferenceDevice.Burst;
            ant.Model = null;
            Console.WriteLine(ant.Model == null);
            var recorder = ant.gameObject.AddComponent<DemonstrationRecorder>();
            recorder.Record = true;
        }

        private static List<ISensor> Names(MonoBehaviour agent, BehaviorParameters parameters)
        {
            var all = SensorList.Of(agent, parameters, out var vector, out var stacked);
            Console.WriteLine($"{vector?.GetName() ?? "none"} {stacked?.GetName() ?? "none"}: "
                + string.Join(", ", all.Select(sensor => sensor.GetName())));
            return all;
        }

        private static GameObject Below(Component above, string name)
        {
            var thing = new GameObject(name);
            thing.transform.SetParent(above.transform);
            return thing;
        }

        internal static GameObject Thing(PrimitiveType type, string tag, Vector3 place)
        {
            var thing = GameObject.CreatePrimitive(type);
            thing.name = thing.tag = tag;
            thing.transform.position = place;
            return thing;
        }

        private static void Look(ISensor sensor)
        {
            sensor.Update();
            Show(sensor);
        }

        private static void Show(ISensor sensor)
        {
            Buffer.Clear();
            SensorRows.Write(sensor, Buffer);
            var bytes = Buffer.From(0).Span;
            var numbers = SensorRows.IsPicture(sensor)
                ? bytes.ToArray().Select(one => (float)one)
                : MemoryMarshal.Cast<byte, float>(bytes).ToArray();
            var spec = sensor.GetObservationSpec();
            var meant = Enumerable.Range(0, spec.Rank).Select(i => (int)spec.DimensionProperties[i]);
            var kind = SensorRows.IsPicture(sensor) ? " uint8" : "";
            Console.WriteLine($"{sensor.GetName()} [{string.Join(", ", spec.Shape)}]{kind} "
                + $"{(int)spec.ObservationType} {string.Join(",", meant)}: "
                + Numbers(numbers));
        }

        private static string Numbers(IEnumerable<float> numbers) =>
            string.Join(" ", numbers.Select(one => one.ToString("0.###", CultureInfo.InvariantCulture)));

        private static void Say(Action mistake)
        {
            try
            {
                mistake();
                Console.WriteLine("no exception");
            }
            catch (Exception e) { Console.WriteLine($"{e.GetType().Name}: {e.Message.Split('\n')[0]}"); }
        }

        private class Insect : MonoBehaviour
        {
            [Observable("legs")] protected int legs = 6;
        }

        [Flags]
        private enum Senses { Smell = 1, Touch = 2 }
        private enum Mood { Calm, Hungry }

        private sealed class Ant : Insect
        {
            [Observable] private Mood mood = Mood.Hungry;
            [Observable] private Senses senses = Senses.Touch;
            [Observable(numStackedObservations: 2)] private bool Awake => true;
            [Observable] private Vector4 Place => new Vector4(1, 2, 3, 4);
            [Observable] private string Song => mood + senses.ToString();
        }

        private sealed class OwnComponent : SensorComponent
        {
            public override ISensor[] CreateSensors() => new ISensor[] { new OwnSensor() };
        }

        private sealed class OldComponent : SensorComponent
        {
            [Obsolete("as of 1.0")] public override ISensor CreateSensor() => new VectorSensor(1, "old");
            [Obsolete("as of 1.0")] public override int[] GetObservationShape() => new[] { 1 };
        }

        private sealed class EmptyComponent : SensorComponent { }

        private sealed class OwnActuators : ActuatorComponent
        {
            public override ActionSpec ActionSpec => default;
            public override IActuator[] CreateActuators() => new IActuator[0];
        }

        private sealed class TextureSensor : ISensor
        {
            private readonly Texture2D texture;
            private readonly bool gray;

            public TextureSensor(Texture2D texture, bool gray) => (this.texture, this.gray) = (texture, gray);
            public ObservationSpec GetObservationSpec() => ObservationSpec.Visual(gray ? 1 : 3, 2, 2);
            public int Write(ObservationWriter writer) => writer.WriteTexture(texture, gray);
            public byte[] GetCompressedObservation() => null;
            public void Update() { }
            public void Reset() { }
            public CompressionSpec GetCompressionSpec() => CompressionSpec.Default();
            public string GetName() => "Texture";
        }

        private sealed class OwnSensor : ISensor
        {
            public int Wide { get; set; } = 2;
            public ObservationSpec GetObservationSpec() => ObservationSpec.Visual(2, 1, 3);
            public int Write(ObservationWriter writer)
            {
                writer[1, 0, Wide] = 0.5f;
                return 6;
            }

            public byte[] GetCompressedObservation() => null;
            public void Update() { }
            public void Reset() { }
            public CompressionSpec GetCompressionSpec() => CompressionSpec.Default();
            public string GetName() => "Own";
        }
    }
}
