// ML-Agents' shape, a demonstration recorder: in a scene it is no missing script, and says that it does not record.
using UnityEngine;
using UnityEngine.Serialization;

namespace NetMQExample.MLAgents.Demonstrations
{
    /// <summary>Its fields have ML-Agents' names; it writes no file.</summary>
    [AddComponentMenu("")]
    public class DemonstrationRecorder : MonoBehaviour
    {
        [FormerlySerializedAs("record")] public bool Record;
        public int NumStepsToRecord;
        [FormerlySerializedAs("demonstrationName")] public string DemonstrationName;
        [FormerlySerializedAs("demonstrationDirectory")] public string DemonstrationDirectory;

        private bool said;

        private void Update()
        {
            if (!Record || said) return;
            said = true;
            Debug.LogError($"{name}: demonstrations are not recorded here: record them with Unity's package ML-Agents "
                + "in another copy of the project, and give mlagents_learn their .demo files", this);
        }
    }
}
