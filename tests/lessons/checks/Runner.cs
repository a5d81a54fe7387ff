using System.Collections.Generic;
// was: using Gymize; and using NumSharp;
using NetMQExample;
using UnityEngine;

public sealed class Runner : Agent
{
    [Box] private Vector3 place;
    [Discrete] private int Lives { get; set; }
    [Obs(".memory.goal")] private float goal = 4;
    [Text("@.says")] private string last = "";

    public override void OnReset()
    {
        place = Vector3.zero;
        (Lives, last) = (3, "go");
    }

    public override void OnAction(object action)
    {
        var parts = (Dictionary<string, object>)action;
        var push = (MessageArray)parts["push"]; // was: (NDArray)
        foreach (var way in push.Items<float>()) place += Vector3.right * way; // was: push.ToArray<float>()
        if ((long)parts["jump"] == 1) Lives -= 1;
        AddReward(place.x);
        if (place.x >= goal) Terminate();
        if (Lives == 0) Truncate();
        SendInfo($"at {place.x}");
    }

    public override void OnInfo(object info) => last = (string)info;
}
