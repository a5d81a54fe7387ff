using System;
using NetMQExample.MLAgents;
using NetMQExample.MLAgents.SideChannels;
using UnityEngine;

public sealed class WeatherChannel : SideChannel
{
    public WeatherChannel() => ChannelId = new Guid("8d4c1c4e-3c0a-4a5e-9d5b-6f0f6f3c2b11");

    public void Ask(string place)
    {
        using var msg = new OutgoingMessage();
        msg.WriteString(place);
        QueueMessageToSend(msg);
    }

    protected override void OnMessageReceived(IncomingMessage msg) => Debug.Log(msg.ReadString());
}

public sealed class Weather : SideChannelBehaviour
{
    private readonly WeatherChannel channel = new WeatherChannel();

    protected override void Begin()
    {
        base.Begin();
        SideChannelManager.RegisterSideChannel(channel);
        Academy.Instance.EnvironmentParameters.RegisterCallback("wind",
            value => transform.position = new Vector3(value, 0, 0));
        channel.Ask("Rome");
    }

    protected override void OnDisable()
    {
        SideChannelManager.UnregisterSideChannel(channel);
        base.OnDisable();
    }
}
