// ML-Agents' shape, behavior parameters: the name, sizes and kind of decision of the agent on the same game object.
//
// Use: scenes of ML-Agents have it already, and its fields have ML-Agents' names there. Agents of one Behavior Name and
// Team Id are of one behavior in Python, "Ball?team=0"; all of them have the same sizes.
// Trouble: a model is not run here. It is kept, and one line says what to do.
using System;
using NetMQExample.MLAgents.Inference;
using UnityEngine;
using UnityEngine.Serialization;
using Object = UnityEngine.Object;

namespace NetMQExample.MLAgents.Policies
{
    /// <summary>The settings of an agent.</summary>
    [AddComponentMenu("NetMQ Example/ML-Agents/Behavior Parameters")]
    public class BehaviorParameters : MonoBehaviour
    {
        [SerializeField, Tooltip("The name of its behavior in Python")] private string m_BehaviorName = "My Behavior";
        [SerializeField] private BrainParameters m_BrainParameters = new BrainParameters();
        [SerializeField, Tooltip("Is kept and not run")] private Object m_Model;
        [SerializeField, Tooltip("Is kept and not used")] private InferenceDevice m_InferenceDevice;
        [SerializeField, Tooltip("Default: Python, else Heuristic")] private BehaviorType m_BehaviorType;
        [FormerlySerializedAs("m_TeamID"), Tooltip("Which team it plays for")] public int TeamId;
        [SerializeField, FormerlySerializedAs("m_useChildSensors"), Tooltip("Sensors of its children are its own")]
        private bool m_UseChildSensors = true;
        [SerializeField, Tooltip("Is kept and not used")] private bool m_UseChildActuators = true;
        [SerializeField, Tooltip("Is kept and not used")] private bool m_DeterministicInference;
        [SerializeField, Tooltip("Which members with [Observable] it sees")]
        private ObservableAttributeOptions m_ObservableAttributeHandling;

        private bool said;

        /// <summary>Something has changed by which the agent chooses who decides.</summary>
        internal event Action Changed;

        /// <summary>The sizes. Change them before the agent is enabled.</summary>
        public BrainParameters BrainParameters { get => m_BrainParameters; internal set => m_BrainParameters = value; }

        /// <summary>A model of any inference package. It is not run.</summary>
        public AnyModel Model { get => m_Model; set => Set(ref m_Model, value); }

        public InferenceDevice InferenceDevice { get => m_InferenceDevice; set => m_InferenceDevice = value; }
        public BehaviorType BehaviorType { get => m_BehaviorType; set => Set(ref m_BehaviorType, value); }
        public string BehaviorName { get => m_BehaviorName; set => Set(ref m_BehaviorName, value); }
        public bool UseChildSensors { get => m_UseChildSensors; set => m_UseChildSensors = value; }
        public bool UseChildActuators { get => m_UseChildActuators; set => m_UseChildActuators = value; }
        public bool DeterministicInference { get => m_DeterministicInference; set => m_DeterministicInference = value; }

        public ObservableAttributeOptions ObservableAttributeHandling
        {
            get => m_ObservableAttributeHandling;
            set => m_ObservableAttributeHandling = value;
        }

        public string FullyQualifiedBehaviorName => $"{m_BehaviorName}?team={TeamId}";

        /// <summary>Whether the agent's Heuristic decides: so it does in place of a model, too.</summary>
        public bool IsInHeuristicMode() => m_BehaviorType != BehaviorType.Default || !PythonIsThere;

        private static bool PythonIsThere => Academy.IsInitialized && Academy.Instance.IsCommunicatorOn;

        private void Start() => Check();

        private void Set<T>(ref T setting, T value)
        {
            setting = value;
            Check();
            Changed?.Invoke();
        }

        private void Check()
        {
            if (!said && IsInHeuristicMode() && m_BehaviorType != BehaviorType.HeuristicOnly
                && (m_Model != null || m_BehaviorType == BehaviorType.InferenceOnly))
            {
                said = true;
                Debug.LogWarning($"{name}: a model does not run here, and its Heuristic decides. Let Python decide: "
                    + "Behavior Type Default, and mlagents_learn with --resume --inference before you press Play");
            }
        }
    }
}
