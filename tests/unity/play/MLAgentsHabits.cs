// Agents of ML-Agents' shape as public ones are written, each with a habit of theirs.
using System;
using System.Globalization;
using System.Linq;
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.Actuators;
using UnityEngine;
using Object = UnityEngine.Object;
using Random = UnityEngine.Random;

namespace MLAgentsWorlds
{
#pragma warning disable CS0672 // They are obsolete, and public agents override them.
    /// <summary>As many were written in 2020.</summary>
    public class Old : Agent
    {
        public override void OnActionReceived(float[] vectorAction) =>
            Told.Write($"{name} act {Shown(vectorAction)}");

        public override void Heuristic(float[] actionsOut)
        {
            Told.Write($"{name} decide {Shown(actionsOut)}");
            for (var i = 0; i < actionsOut.Length; i++) actionsOut[i] = i + 1;
        }

        private static string Shown(float[] numbers) =>
            string.Join(" ", numbers.Select(one => one.ToString(CultureInfo.InvariantCulture)));
    }

#pragma warning restore CS0672
    /// <summary>An agent without a Heuristic.</summary>
    public class Bare : Agent
    {
        public override void OnActionReceived(ActionBuffers actions) => Told.Write($"{name} act");
    }

    /// <summary>It has Unity's messages for itself, as public agents have them: private, without
    /// override.</summary>
    public class Messages : Agent
    {
        private bool fixedOnce, updatedOnce;

        public override void Initialize() => Told.Write($"{name} init");
        public override void OnActionReceived(ActionBuffers actions) => Told.Write($"{name} act");

#pragma warning disable CS0114 // It is what they write.
        private void Awake() => Told.Write($"{name} Awake");
#pragma warning restore CS0114

        private void Start() => Told.Write($"{name} Start");
        private void OnTriggerEnter(Collider other) => Told.Write($"{name} OnTriggerEnter");
        private void OnDestroy() => Told.Write($"{name} OnDestroy");

        private void FixedUpdate()
        {
            if (!fixedOnce) Told.Write($"{name} FixedUpdate");
            fixedOnce = true;
        }

        private void Update()
        {
            if (!updatedOnce) Told.Write($"{name} Update");
            updatedOnce = true;
        }
    }

    /// <summary>Its OnEnable hides that of Agent.</summary>
    public class Hides : Agent
    {
        public override void Initialize() => Told.Write($"{name} init");

#pragma warning disable CS0114
        private void OnEnable() => Told.Write($"{name} OnEnable");
#pragma warning restore CS0114
    }

    /// <summary>Uses the names of types that a member of a base would hide.</summary>
    public class Names : Agent
    {
        private readonly State state = new State();
        private readonly Group group = new Group();
        private Action<float> onBegin = value => { };

        public override void Initialize()
        {
            Random.InitState(1);
            onBegin(Random.Range(0f, 1f) + Random.value + Mathf.Clamp(Time.deltaTime, 0, Screen.width));
            var world = Space.World;
            var seen = Physics.Raycast(Vector3.zero, Vector3.up, out var hit, 1, Physics.DefaultRaycastLayers);
            var made = Object.FindAnyObjectByType<Names>();
            Debug.Log($"| {name} {world} {seen} {hit.distance} {Application.isPlaying} {Color.red.r} "
                + $"{Input.GetAxis("Horizontal")} {made.name} {state} {group}");
        }

        private sealed class State { public override string ToString() => "state"; }

        private sealed class Group { public override string ToString() => "group"; }
    }
}
