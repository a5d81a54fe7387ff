// Lesson 08 in Unity: the main camera follows the car, so that one sees it drive. Python does not see this picture.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Keeps the main camera behind and above this object.</summary>
    [AddComponentMenu("NetMQ Example/08 Chase View")]
    public sealed class ChaseView : MonoBehaviour
    {
        private void LateUpdate()
        {
            var view = Camera.main;
            if (view == null) return;
            var (place, turn) = (transform.position, transform.rotation);
            var behind = place + turn * new Vector3(0, 4, -8);
            view.transform.SetPositionAndRotation(behind, turn * Quaternion.Euler(15, 0, 0));
        }
    }
}
