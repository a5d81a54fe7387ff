// Lesson 12 in Unity, the example: lesson 08's car drives along its road by itself, and two cameras can be filmed.
//
// Use: it stands in the lesson's scene beside ViewRecorder, to which it gives its cameras. It drives once Python is
// there, so that a film shows it from its beginning. Your own game takes its place.
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Stands where the world's car is: its x and y are Unity's x and z.</summary>
    [AddComponentMenu("NetMQ Example/12 Filmed Drive")]
    [RequireComponent(typeof(ViewRecorder))]
    public sealed class FilmedDrive : MonoBehaviour
    {
        [SerializeField, Min(0), Tooltip("End after so many steps, and the films; 0: never")] private int count = 300;

        private readonly SelfDriving drive = new SelfDriving();
        private ViewRecorder recorder;

        private void Awake()
        {
            recorder = GetComponent<ViewRecorder>();
            gameObject.AddComponent<RoadScene>();
            gameObject.AddComponent<ChaseView>();
            // All behind the camera on the car: it does not see it.
            Cube.Make(new Vector3(3, 0.8f, 3), new Color32(200, 30, 30, 255), transform).localPosition =
                new Vector3(0, 0.6f, -2);
            Camera front = CarCamera.On(transform, 0), map = CarCamera.On(transform, 0);
            front.name = "front";
            map.name = "map";
            // 120 m of ground from above, which 60 degrees see from this height.
            map.transform.SetParent(null, false);
            map.transform.SetPositionAndRotation(new Vector3(60, 103.9f, 50), Quaternion.Euler(90, 0, 0));
            recorder.Cameras.AddRange(new[] { front, map });
        }

        private void FixedUpdate()
        {
            if (!recorder.enabled || (drive.Steps == 0 && !recorder.Connected)) return;
            drive.Step();
            var ahead = new Vector3((float)drive.Car.AheadX, 0, (float)drive.Car.AheadY);
            var place = new Vector3((float)drive.Car.X, 0, (float)drive.Car.Y);
            transform.SetPositionAndRotation(place, Quaternion.LookRotation(ahead));
            if (count == 0 || drive.Steps < count || recorder.Filming) return;
            Debug.Log($"done: {drive.Steps} steps");
            recorder.enabled = false;
        }
    }
}
