using System;
using NetMQExample;
using UnityEngine;

// A cube that goes to the right, a step at a time, and two cameras that see it.
public sealed class Looker : Agent
{
    [Discrete] private int steps;

    private void Awake()
    {
        GameObject.CreatePrimitive(PrimitiveType.Cube).transform.SetParent(transform, false);
        foreach (var (name, away) in new[] { ("Main Camera", -9f), ("front", -6f) })
        {
            var camera = new GameObject(name).AddComponent<Camera>();
            camera.transform.position = new Vector3(0, 0, away);
            GetComponent<ViewRecorder>().Cameras.Add(camera);
        }
    }

    public override void OnReset() => Go(0);
    public override void OnAction(object action) => Go(steps + Convert.ToInt32(action));

    private void Go(int now)
    {
        steps = now;
        transform.position = new Vector3(0.3f * (now - 3), 0, 0);
    }
}
