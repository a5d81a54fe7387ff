// ML-Agents' shape, a hidden component: each of its FixedUpdates is one step of the academy.
using UnityEngine;

namespace NetMQExample.MLAgents
{
    // Before all others, so that what their FixedUpdate asks for always belongs to the next step.
    [DefaultExecutionOrder(-1000), AddComponentMenu("")]
    internal sealed class AcademyStepper : MonoBehaviour
    {
        public static AcademyStepper Make()
        {
            var thing = new GameObject(nameof(AcademyStepper)) { hideFlags = HideFlags.HideInHierarchy };
            DontDestroyOnLoad(thing);
            return thing.AddComponent<AcademyStepper>();
        }

        private void FixedUpdate()
        {
            if (Academy.IsInitialized && Academy.Instance.IsSteppedBy(this)) Academy.Instance.EnvironmentStep();
            // One of an academy that is no more.
            else Destroy(gameObject);
        }
    }
}
