// Scenes with scripts of a user's own, played until somebody ends them or a minute is over. Runner.cs and Weather.cs
// are the classes of docs/guide/from_gymize.md and docs/guide/13_side_channels.md.
//
//     dotnet checks.dll scene gymize ENDPOINT [HOW]
//         HOW is wrong, mistake, mute, gone, radar, named, alone or env.
//     dotnet checks.dll scene Racer ENDPOINT [first | channels | lost | VIEW_ENDPOINT]
//     dotnet checks.dll scene Faller ENDPOINT
//     dotnet checks.dll scene Arena ENDPOINT
//     dotnet checks.dll scene Twins ENDPOINT [twice]
//     dotnet checks.dll scene Weather ENDPOINT
//     dotnet checks.dll scene OwnChannels ENDPOINT
using System;
using System.Linq;
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.SideChannels;
using UnityEngine;
using UnityPlayer;

#pragma warning disable CA1823, CS0414, IDE0051, IDE0052 // Only reflection reads these members.

namespace NetMQExample.Tests
{
    internal static class Scenes
    {
        private static int made;

        public static void Run(string name, string endpoint, string[] how)
        {
            var player = new Player(typeof(GymManager).Assembly, typeof(Runner).Assembly);
            player.Begin(() =>
            {
                var thing = new GameObject("scene");
                // Components wake up when their object is switched on: the fields are set by then, as in a scene file.
                thing.SetActive(false);
                if (name == "Racer" || name == "Faller")
                {
                    // Nothing says whose Update comes first.
                    var manager = new MonoBehaviour[1];
                    if (how.FirstOrDefault() == "first") manager[0] = thing.AddComponent<GymManager>();
                    thing.AddComponent(name == "Racer" ? typeof(Racer) : typeof(Faller));
                    manager[0] ??= how.FirstOrDefault() == "channels"
                        ? thing.AddComponent<Channels>()
                        : thing.AddComponent<GymManager>();
                    Inspector.Set(manager, "endpoint", endpoint);
                    Inspector.Set(manager, "envName", "Racer");
                    // The second scene has none.
                    manager[0].enabled = how.FirstOrDefault() != "lost" || made++ == 0;
                    if (name == "Faller") Inspector.Set(manager, "byHand", "true");
                    if (how.Length > 0 && how[0].StartsWith("tcp", StringComparison.Ordinal))
                    {
                        var eye = new GameObject("eye").AddComponent<Camera>();
                        eye.tag = "MainCamera";
                        var recorder = new MonoBehaviour[] { thing.AddComponent<ViewRecorder>() };
                        Inspector.Set(recorder, "endpoint", how[0]);
                        Inspector.Set(recorder, "width", "32");
                        Inspector.Set(recorder, "height", "24");
                    }
                    thing.SetActive(true);
                    return;
                }
                if (name == "Arena" || name == "Twins")
                {
                    var manager = new MonoBehaviour[] { thing.AddComponent<GymManager>() };
                    Inspector.Set(manager, "endpoint", endpoint);
                    Inspector.Set(manager, "envName", name);
                    var second = how.Length > 0 ? UnityEngine.Object.Instantiate(thing) : null;
                    for (var i = 0; i < 2 && name == "Twins"; i++) thing.AddComponent<Twin>();
                    thing.SetActive(true);
                    if (second != null) second.SetActive(true);
                    if (name == "Twins") return;
                    foreach (var bot in new[] { "leader", "stays", "ends", "ends_off", "off", "led", "destroyed",
                        "respawned", "replaced" })
                        Bot.Spawn(bot);
                    return;
                }
                if (name == "gymize")
                {
                    Gymize(thing, endpoint, how.FirstOrDefault());
                    return;
                }
                var script =
                    (MonoBehaviour)(name == "Weather"
                        ? thing.AddComponent<Weather>()
                        : thing.AddComponent<OwnChannels>());
                Inspector.Set(new[] { script }, "endpoint", endpoint);
                if (how.Length > 0) Inspector.Set(new[] { script }, "timeout", how[0]);
                thing.SetActive(true);
            });
            player.Run(TimeSpan.FromSeconds(60), () => false);
            player.Stop();
        }

        private static void Gymize(GameObject thing, string endpoint, string how)
        {
            // Before any other agent.
            if (how == "wrong") Add<Speeder>("wrong locator").Name = "speeder";
            var scripts = new MonoBehaviour[]
            {
                how == "mistake" ? (MonoBehaviour)thing.AddComponent<Speeder>() : thing.AddComponent<Runner>(),
                thing.AddComponent<GymManager>(),
            };
            var says = thing.AddComponent<Says>();
            says.hears = how != "mute";
            Inspector.Set(scripts, "endpoint", endpoint);
            Inspector.Set(scripts, "envName", "Runner");
            if (how == "alone")
            {
                scripts[1].enabled = false;
                says.eye = new GameObject("eye").AddComponent<Camera>();
                says.eye.transform.SetParent(thing.transform);
                says.eye.gameObject.AddComponent<CameraSensor>().Camera = says.eye;
            }
            thing.SetActive(true);
            if (how == "gone") scripts[0].enabled = false;
            if (how == "wrong") Add<CameraSensor>("eye");
            if (how == "named")
            {
                ((Agent)scripts[0]).Name = "one";
                Add<Runner>("second").Name = "two";
                Add<Clocked>("clocked").Name = "clocked";
                Add<Runner>("third").Name = "one";
                Add<Runner>("last");
            }
            if (how == "env") Add<Referee>("referee");
            if (how == "radar")
            {
                var other = new GameObject("twin");
                other.SetActive(false);
                other.transform.SetParent(thing.transform);
                var radar = other.AddComponent<Radar>();
                Inspector.Set(new[] { radar }, "locator", "@.place(1:)");
                other.SetActive(true);
            }
        }

        private static T Add<T>(string name)
            where T : Component => new GameObject(name).AddComponent<T>();
    }

    internal sealed class Says : MonoBehaviour
    {
        public Camera eye;
        public bool hears;

        private void Start()
        {
            if (hears && GymManager.Current != null)
                GymManager.Current.Simulator.OnInfo += info => Debug.Log($"heard {info}");
        }

        private void LateUpdate()
        {
            if (eye != null) Debug.Log($"the sensor's camera draws: {eye.enabled}");
            eye = null;
        }
    }

    internal sealed class Referee : MonoBehaviour
    {
        private void OnEnable() => GymEnv.OnInfo += Hear;
        private void OnDisable() => GymEnv.OnInfo -= Hear;

        private static void Hear(object info)
        {
            GymEnv.SendInfo($"the referee heard {info}");
            GymEnv.SendInfo("agent", "yours");
            GymEnv.SetReward("agent", 5);
            GymEnv.AddReward("agent", 0.5);
            if ((string)info == "enough") GymEnv.Terminate();
            else GymEnv.Truncate("agent");
            try { GymEnv.AddReward("nobody", 1); }
            catch (MessageException e) { Debug.Log(e.Message); }
        }
    }

    internal sealed class Channels : GymManager
    {
        protected override void Enter()
        {
            Debug.Log("enters");
            base.Enter();
        }

        protected override void Leave()
        {
            base.Leave();
            Debug.Log("leaves");
        }
    }

    /// <summary>Dies in its third step, each in its own way.</summary>
    internal sealed class Bot : Agent
    {
        private static readonly System.Collections.Generic.Dictionary<string, Bot> Newest = new();

        [Discrete] private int age;
        private bool dying;

        public static void Spawn(string name)
        {
            var bot = new GameObject(name).AddComponent<Bot>();
            bot.Name = name;
            Newest[name] = bot;
        }

        public override void OnReset()
        {
            age = 0;
            dying = false;
            if (Name != "led") gameObject.SetActive(true);
            if (Name != "leader") return;
            Newest["led"].gameObject.SetActive(true);
            if (Newest["destroyed"].dying) Spawn("destroyed");
        }

        public override void OnTick(double dt)
        {
            AddReward(1);
            if (++age != 3 || Name == "stays" || Name == "leader") return;
            AddReward(-11);
            SendInfo("died");
            if (Name != "off" && Name != "replaced") Terminate();
            if (Name == "ends_off" || Name == "off" || Name == "led") gameObject.SetActive(false);
            dying = Name == "destroyed" || Name == "respawned" || Name == "replaced";
            if (dying) Destroy(gameObject);
            // It lives on until the end of the frame, which may be the next episode.
            if ((Name == "respawned" || Name == "replaced") && Newest[Name] == this) Spawn(Name);
        }
    }

    internal sealed class Faller : Agent
    {
        private int ticks;

        public override void OnReset() => ticks = 0;

        public override void OnTick(double dt)
        {
            AddReward(0.5);
            if (++ticks == 3) Terminate();
        }
    }

    internal sealed class Twin : Agent
    {
        private double sum;

        public override GymSpace Observation { get; } = GymSpace.Box(0, 9, 1);
        public override GymSpace Action { get; } = GymSpace.Discrete(3);
        public override void OnReset() => sum = 0;
        public override void OnAction(SpaceReader action) => sum += action[0];

        public override void OnStepped()
        {
            AddReward(sum);
            if (sum > 3) enabled = false;
        }

        public override void Observe(SpaceWriter seen) => seen.Add(sum);
    }

    internal sealed class Radar : SensorComponent
    {
        public override object GetObservation() => new Vector2(7, 8);
    }

    internal sealed class Speeder : Agent
    {
        [Box(".speed[")] private readonly float speed = 1;
    }

    internal abstract class Animal : Agent
    {
        private void FixedUpdate() { }
    }

    internal sealed class Clocked : Animal { }

    internal sealed class OwnChannels : SideChannelBehaviour
    {
        private void Start() =>
            Academy.Instance.EnvironmentParameters.RegisterCallback("wind", value => Debug.Log($"wind {value:F0}"));

        protected override void Update()
        {
            base.Update();
            Academy.Instance.StatsRecorder.Add("frames", Time.frameCount);
        }
    }
}
