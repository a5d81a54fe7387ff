// ML-Agents' shape, the scene's clock: what Python is told of the agents that want an action or have ended, and what
// it says then. The scene runs until somebody asks or has ended; Records.cs says how both look as bytes.
//
// A request waits here until a step has something to tell, and is answered then.
using System;
using System.Collections.Generic;
using System.Linq;
using NetMQExample.MLAgents.SideChannels;
using UnityEngine;
using UnityEngine.SceneManagement;

namespace NetMQExample.MLAgents
{
    /// <summary>Answers Python's requests when a step has rows. For the main thread.</summary>
    internal sealed class SceneClock : SimulatorBase
    {
        private readonly List<SceneKind> kinds = new List<SceneKind>();
        private bool begun;
        private int known;

        public override string Name => SceneManager.GetActiveScene().name;

        // Of the first reset: Python's, where it gave one.
        public int? Seed { get; private set; }

        public bool HasRows { get; set; }

        /// <summary>Whether the last request begins all anew.</summary>
        public bool Resets { get; private set; }

        /// <summary>The kind of an agent's behavior, with the sizes of the first agent that it had.</summary>
        /// <exception cref="UnityAgentsException">This agent has others.</exception>
        public SceneKind KindOf(AgentLife agent)
        {
            var kind = kinds.Find(one => one.Behavior == agent.Behavior);
            if (kind == null) kinds.Add(kind = new SceneKind(kinds.Count, agent));
            else kind.Check(agent);
            return kind;
        }

        public override Message Describe() => Greeting(Time.fixedDeltaTime, "scene", new List<object>());

        public override Message Say(Message request) => throw new MessageException("unknown-kind",
            $"kind {MessageWriter.Shown(request.Kind)}: a scene by its own clock knows reset, step and close alone; "
            + "infos and pictures go through side channels and sensors");

        public override bool Do(StepRequest request, StepAnswer answer, bool again)
        {
            // The step that it has waited for has something to tell.
            if (again)
            {
                Tell(answer);
                return true;
            }
            if (!request.SceneClock)
                throw new MessageException("wrong-clock", "this scene goes by its own clock, as ML-Agents' do: "
                    + "drive it by netmq_example.mlagents_envs.environment.UnityEnvironment");
            if (!begun && !request.Resets) throw new MessageException("no-reset", "call reset before step");
            // Checked before anything is taken of it.
            for (var i = 0; i < request.Count; i++) Asked(request[i]).Check(request[i]);
            if (request.Exchange.Length > 0) SideChannelManager.Receive(new[] { request.Exchange.ToArray() });
            Resets = request.Resets;
            if (Resets && !begun) Begin(request.Options);
            for (var i = 0; i < request.Count; i++) Asked(request[i]).Take(request[i]);
            if (Resets) Episodes++;
            else Steps++;
            return false;
        }

        private void Begin(ReadOnlyMemory<byte> options)
        {
            begun = true;
            if (options.Length > 0 && MessageTree.Read(options) is Dictionary<string, object> said
                && said.TryGetValue("seed", out var seed) && seed is long number) Seed = unchecked((int)number);
        }

        private SceneKind Asked(RequestSection section) =>
            section.Kind < kinds.Count && kinds[section.Kind].Asked ? kinds[section.Kind] : throw new MessageException(
                "bad-actions", $"actions for kind {section.Kind}, of which nobody wanted one");

        private void Tell(StepAnswer answer)
        {
            answer.SceneClock = true;
            answer.Exchange = SideChannelManager.GetSideChannelMessage();
            if (kinds.Count > known)
                answer.Infos = MessageTree.Write(new Dictionary<string, object>
                {
                    ["kinds"] = kinds.Skip(known).Select(kind => (object)kind.Description).ToList(),
                });
            known = kinds.Count;
            foreach (var kind in kinds) kind.WriteEnded(answer);
            foreach (var kind in kinds) kind.WriteWanting(answer);
            HasRows = false;
        }
    }
}
