// Lesson 08, the camera of the car: as DrawnCamera.cs, but a real one. It renders when it is asked to, and only then.
//
// Beside a camera of your own it sees what that one sees, which goes on as it is.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Cameras for CameraReadback.cs.</summary>
    public static class CarCamera
    {
        /// <summary>Puts a camera on a car, 1.5 m above the ground and tilted down.</summary>
        /// <param name="right">Metres to the right of the middle.</param>
        public static Camera On(Transform car, double right)
        {
            var camera = new GameObject("Camera").AddComponent<Camera>();
            camera.transform.SetParent(car, false);
            camera.transform.localPosition = new Vector3((float)right, 1.5f, 0);
            camera.transform.localRotation = Quaternion.Euler(16.26f, 0, 0);
            camera.enabled = false;
            camera.fieldOfView = 60;
            camera.clearFlags = CameraClearFlags.SolidColor;
            camera.backgroundColor = new Color32(150, 190, 230, 255);
            return camera;
        }

        /// <summary>The same with a texture, which you destroy together with the camera.</summary>
        /// <param name="right">Metres to the right of the middle.</param>
        public static Camera On(Transform car, double right, int width, int height)
        {
            var camera = On(car, right);
            // The bytes in it are those of the screen, also where a project computes its light in linear space.
            camera.targetTexture = new RenderTexture(width, height, 24,
                RenderTextureFormat.ARGB32, RenderTextureReadWrite.sRGB);
            return camera;
        }

        /// <summary>Puts a camera beside one of yours, to see as it does.</summary>
        /// <param name="own">It may be enabled, and show the game.</param>
        /// <param name="right">Metres to its right.</param>
        public static Camera Beside(Camera own, double right, int width, int height)
        {
            var camera = On(own.transform, right, width, height);
            var texture = camera.targetTexture;
            // It takes over the place as well, and where that one draws.
            camera.CopyFrom(own);
            camera.targetTexture = texture;
            camera.transform.localPosition = new Vector3((float)right, 0, 0);
            return camera;
        }
    }
}
