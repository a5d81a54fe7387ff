// An agent as gymize's README has it: OnReset loads the scene anew, Convert reads an action, and Update ends the
// episode.
using System;
using System.Collections.Generic;
using NetMQExample;
using UnityEngine;
using UnityEngine.SceneManagement;

#pragma warning disable CS0414 // Only reflection reads these members.

public class Racer : Agent
{
    [Obs] private string m_NickName = "nobody";
    [Box] private float Distance;
    [Box(".Height=$", "float")] private int m_Height = 3;
    [Graph]
    private GraphInstance track = new GraphInstance(
        new[,] { { 1f, 2f }, { 3f, 4f } }, new[,] { { 5f } }, new[,] { { 0, 1 } });
    [Obs(".eye")] private EncodedImage m_Eye = new EncodedImage(Convert.FromBase64String(Pixel));

    // A PNG file of 2 x 1 pixels: red, blue.
    private const string Pixel =
        "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAIAAAB7QOjdAAAADUlEQVR4nGP4zwAE/wEHAAH/4iOeWQAAAABJRU5ErkJggg==";

    private static int s_Loads;
    private float m_Speed;

    public override void OnReset() =>
        SceneManager.LoadScene(SceneManager.GetActiveScene().name, LoadSceneMode.Single);

    public override void OnAction(object action)
    {
        Dictionary<string, object> actions = action as Dictionary<string, object>;
        List<object> arr = actions["arr"] as List<object>;
        m_Speed = Convert.ToSingle(actions["speed"]) * Convert.ToInt32(arr[0]);
        Distance += m_Speed;
        Debug.Log(actions["speed"]);
        SendInfo($"{(long)arr[0]} of {s_Loads}");
    }

    public override void OnInfo(object info)
    {
        if (info is byte[] raw) m_NickName = $"{raw.Length} bytes";
        else m_NickName = (string)info;
    }

    private void Awake() => s_Loads++;

    private void Update()
    {
        if (Distance >= 3) Terminate();
    }
}
