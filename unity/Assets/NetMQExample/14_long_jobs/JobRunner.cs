// Lesson 14 in Unity: a job is started or come back to, and watched, on a thread of its own; Update logs what is new.
//
// Use: start python/14_long_jobs/server.py, add this component and JobView to a GameObject, press Play. Stop and press
// Play again with the id from the console in Resume: the job has gone on meanwhile.
using System;
using System.Threading;
using UnityEngine;

namespace NetMQExample
{
    /// <summary>Has one job done, and shows how far it is.</summary>
    [AddComponentMenu("NetMQ Example/14 Job Runner")]
    [DisallowMultipleComponent]
    public sealed class JobRunner : NetworkBehaviour
    {
        [SerializeField, Tooltip("The server")] private string endpoint = "tcp://127.0.0.1:5564";
        [SerializeField, Tooltip("count, picture, path, deaf, or your own")] private string kind = "picture";
        [SerializeField, Min(1), Tooltip("How far to count; the side of the picture")] private int count = 100;
        [SerializeField, Tooltip("What else your own kind has to know")] private string text = "";
        [SerializeField, Tooltip("Come back to the job with this id; empty: begin one")] private string resume = "";
        [SerializeField, Min(0), Tooltip("Cancel the job when so much is done; 0: never")] private int cancelAt = 0;
        [SerializeField, Min(0), Tooltip("Leave the job alone when so much is done; 0: never")] private int leaveAt = 0;
        [SerializeField, Tooltip("Have the server forget the job after its end")] private bool forget = false;
        [SerializeField, Min(0.01f), Tooltip("Seconds to wait for a word of the job")] private float timeout = 1;
        [SerializeField, Min(1), Tooltip("How often to connect anew")] private int tries = 5;
        [SerializeField, Tooltip("With how much is done, from 0 to 1")] private Arrival<float> advanced = new();
        [SerializeField, Tooltip("With the result")] private Arrival<JobNews> ended = new();

        private volatile JobNews newest;
        private volatile JobClient client;
        // Of a job that has not ended: an app that was not seen for a while comes back to it.
        private string id;

        /// <summary>The newest about the job, or null. For the main thread, such as JobView.</summary>
        public JobNews Newest => newest;

        /// <summary>With how much is done, from 0 to 1, for scripts.</summary>
        public event Action<float> Advanced { add => advanced.Raised += value; remove => advanced.Raised -= value; }

        /// <summary>With the result, for scripts.</summary>
        public event Action<JobNews> Ended { add => ended.Raised += value; remove => ended.Raised -= value; }

        /// <summary>Asks for the job's end; for a button.</summary>
        public void Cancel() => client?.Cancel();

        protected override void Talk(CancellationToken stop)
        {
            newest = null;
            id ??= resume == "" ? JobClient.NewId() : resume;
            using var mine = client = new JobClient(endpoint, id, Seconds(timeout), tries, Log);
            Log($"asking {endpoint} for job {id}");
            foreach (var news in mine.Watch(resume == "" ? mine.Goal(kind, count, text) : mine.Ask("status"), stop))
            {
                if (!news.SameTenthAs(newest)) Log(news.Line);
                newest = news;
                Arrive(advanced, news.Share);
                if (news.Kind == "result") Arrive(ended, news);
                if (news.Kind != "feedback") continue;
                if (cancelAt > 0 && news.Done >= cancelAt) mine.Cancel();
                if (leaveAt == 0 || news.Done < leaveAt) continue;
                Log($"left at {news.Done}; come back with --resume {id}");
                return;
            }
            if (forget) foreach (var news in mine.Watch(mine.Ask("forget"), stop)) Log(news.Line);
            id = null;
            if (newest.Status == "aborted") throw new GaveUpException("the job was aborted; see above");
            Log(newest.Outcome);
        }
    }
}
