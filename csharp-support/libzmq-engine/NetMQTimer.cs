// A timer that ticks on a poller's thread.
using System;
using System.Diagnostics;

namespace NetMQ
{
    /// <summary>Which timer ticked.</summary>
    public class NetMQTimerEventArgs : EventArgs
    {
        /// <summary>For one timer.</summary>
        public NetMQTimerEventArgs(NetMQTimer timer) => Timer = timer;

        /// <summary>The timer.</summary>
        public NetMQTimer Timer { get; }
    }

    /// <summary>Raises an event again and again while a <see cref="NetMQPoller"/> that it was added to runs.</summary>
    public class NetMQTimer
    {
        private readonly NetMQTimerEventArgs eventArgs;
        private int interval;
        private bool enable = true;

        /// <summary>With an interval.</summary>
        public NetMQTimer(TimeSpan interval) : this((int)interval.TotalMilliseconds) { }

        /// <summary>With an interval in milliseconds.</summary>
        public NetMQTimer(int interval)
        {
            this.interval = interval;
            eventArgs = new NetMQTimerEventArgs(this);
        }

        /// <summary>The interval is over.</summary>
        public event EventHandler<NetMQTimerEventArgs>? Elapsed;

        /// <summary>The time between two ticks, in milliseconds. Setting it starts a new interval.</summary>
        public int Interval
        {
            get => interval;
            set
            {
                interval = value;
                Schedule();
            }
        }

        /// <summary>False to stop ticking.</summary>
        public bool Enable
        {
            get => enable;
            set
            {
                if (enable == value) return;
                enable = value;
                Schedule();
            }
        }

        internal static long Now => Stopwatch.GetTimestamp() * 1000 / Stopwatch.Frequency;

        /// <summary>When the next tick is due; -1 if that is not decided.</summary>
        internal long When { get; set; } = -1;

        /// <summary>Ticks on, with a new interval from now.</summary>
        public void EnableAndReset()
        {
            enable = true;
            Schedule();
        }

        internal void Schedule() => When = enable ? Now + interval : -1;

        internal void Tick(object sender)
        {
            Elapsed?.Invoke(sender, eventArgs);
            if (enable) Schedule();
        }
    }
}
