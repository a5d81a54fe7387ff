// An agent of ML-Agents' shape that tells each of its calls, and does in them what the test wants.
using System;
using System.Collections;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.Actuators;
using NetMQExample.MLAgents.Sensors;
using UnityEngine;

// Outside of the kit's namespaces, as a project that moves in is: there, NetMQExample.Agent would be nearer.
namespace MLAgentsWorlds
{
    /// <summary>Sees the number of its CollectObservations, and decides the number of its Heuristic.</summary>
    public class Told : Agent
    {
        private readonly Dictionary<string, int> calls = new Dictionary<string, int>();
        public int see = 1;

        public override void Initialize() => Tell("init");

        public override void OnEpisodeBegin() =>
            Tell("begin", Invariant($"steps={StepCount} sum={GetCumulativeReward()} episodes={CompletedEpisodes}"));

        public override void CollectObservations(VectorSensor sensor)
        {
            Tell("see", sensor == null ? "nothing" : $"{StepCount}");
            for (var i = 0; i < see; i++) sensor?.AddObservation(i == 0 ? calls["see"] : i);
        }

        public override void WriteDiscreteActionMask(IDiscreteActionMask actionMask)
        {
            Deeds.Mask = actionMask;
            Quietly("mask");
        }

        public override void OnActionReceived(ActionBuffers actions) => Tell("act", Shown(actions));

        public override void Heuristic(in ActionBuffers actionsOut)
        {
            Tell("decide", Shown(actionsOut));
            var (numbers, choices) = (actionsOut.ContinuousActions, actionsOut.DiscreteActions);
            for (var i = 0; i < numbers.Length; i++) numbers[i] = calls["decide"];
            for (var i = 0; i < choices.Length; i++) choices[i] = 1;
        }

        protected override void OnDisable()
        {
            Quietly("off");
            base.OnDisable();
        }

        /// <summary>A call that is told where something is done in it: each frame has one.</summary>
        internal void Quietly(string call)
        {
            if (Deeds.Any(this, call, Count(call))) Write($"{name} {call}");
            Deeds.Do(this, call, calls[call]);
        }

        internal static string Invariant(FormattableString text) => FormattableString.Invariant(text);
        internal static void Write(string line) => Console.WriteLine($"| {line.TrimEnd()}");

        private static string Shown(ActionBuffers actions) => string.Join(" ", actions.ContinuousActions
            .Select(one => one.ToString(CultureInfo.InvariantCulture))
            .Concat(actions.DiscreteActions.Select(one => $"#{one}")));

        private void Start()
        {
            Tell("start");
            StartCoroutine(AfterPhysics());
        }

        private void Update() => Quietly("update");
        private void FixedUpdate() => Quietly("fixed");
        private void OnTriggerEnter(Collider other) => Quietly("trigger");

        private IEnumerator AfterPhysics()
        {
            for (; ; Quietly("physics")) yield return new WaitForFixedUpdate();
        }

        private void Tell(string call, string how = "")
        {
            Write($"{name} {call} {how}");
            Deeds.Do(this, call, Count(call));
        }

        private int Count(string call)
        {
            calls.TryGetValue(call, out var before);
            return calls[call] = before + 1;
        }
    }
}
