// Records of the scene's clock: each line of the input is a request in digits, and is answered with what is read of
// it; the golden answers come before.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Runtime.InteropServices;

namespace NetMQExample.PlayTest
{
    internal static class ClockFrames
    {
        public static int Print()
        {
            // As test_13_scene_clock_bytes.py says it.
            var three = Answer(1, Array.Empty<byte>(), new List<object> { Ball(), Goal() }, answer =>
            {
                Section(answer, 0, Columns.Groups | Columns.Masks, Marks.Wants, new[] { 0, 2 }, new[] { 0, 0.5 },
                    Bytes(new[] { 1f, 2, 3 }, 0, 85, 170, 255).Concat(Bytes(new[] { -1, 0.25f, 0 }, 1, 2, 3, 4))
                        .ToArray(),
                    new[] { 0, 3 }, new[] { 0, -1.5f }, new byte[] { 0, 1, 0, 0, 0, 0, 0, 0, 0, 1 });
                Section(answer, 1, Columns.None, Marks.Wants, new[] { 1 }, new[] { 0.0 }, Bytes(new[] { 9f }));
            });
            var ends = Answer(3, "said".Select(one => (byte)one).ToArray(), null, answer =>
            {
                Section(answer, 0, Columns.Groups | Columns.Ended, Marks.Terminated, new[] { 2 }, new[] { 1.0 },
                    Bytes(new[] { 1f, 1, 1 }, 9, 9, 9, 9), new[] { 3 }, new[] { 2f });
                Section(answer, 1, Columns.Ended, Marks.Truncated, new[] { 1 }, new[] { -0.25 }, Bytes(new[] { 4f }));
                Section(answer, 0, Columns.Groups, Marks.Wants, new[] { 2 }, new[] { 0.0 },
                    Bytes(new[] { 0f, 0, 0 }, 0, 0, 0, 0), new[] { 3 }, new[] { 0f });
            });
            foreach (var digits in new[] { three, ends, Answer(4, Array.Empty<byte>(), null, answer => { }) })
                Console.WriteLine(digits);
            var request = new StepRequest();
            for (var line = Console.ReadLine(); line != null; line = Console.ReadLine())
                Console.WriteLine(Read(request, line));
            return 0;
        }

        private static string Read(StepRequest request, string digits)
        {
            try
            {
                request.Read(Enumerable.Range(0, digits.Length / 2)
                .Select(i => Convert.ToByte(digits.Substring(2 * i, 2), 16)).ToArray());
            }
            catch (MessageException e) { return e.Code; }
            var rows = Enumerable.Range(0, request.Count).Select(i => request[i]).SelectMany(section =>
                Enumerable.Range(0, section.Count).Select(row =>
                    $"{section.Kind}:{section.OrderOf(row)}:{Digits(section.Row(row).ToArray())}"));
            return $"{request.Id} {request.SceneClock} {request.Resets} {Digits(request.Exchange.ToArray())} "
                + string.Join(" ", rows);
        }

        private static string Answer(long id, byte[] exchange, List<object> kinds, Action<StepAnswer> sections)
        {
            var answer = new StepAnswer();
            answer.Begin(id);
            answer.SceneClock = true;
            answer.Exchange = exchange;
            if (kinds != null) answer.Infos = MessageTree.Write(new Dictionary<string, object> { ["kinds"] = kinds });
            sections(answer);
            return Digits(answer.Frame().ToArray());
        }

        private static void Section(StepAnswer answer, int kind, Columns columns, Marks mark, int[] ids,
            double[] rewards, byte[] values, int[] groups = null, float[] groupRewards = null, byte[] masks = null)
        {
            answer.BeginSection(kind, ids.Length, columns | Columns.Ids);
            var to = answer.BeginColumn();
            to.Write(MemoryMarshal.AsBytes(ids.AsSpan()));
            if (groups != null)
            {
                answer.BeginColumn();
                to.Write(MemoryMarshal.AsBytes(groups.AsSpan()));
                foreach (var reward in groupRewards) to.Write(reward);
            }
            if (masks != null)
            {
                answer.BeginColumn();
                to.Write((uint)(masks.Length / ids.Length));
                to.Write(masks);
            }
            for (var row = 0; row < ids.Length; row++) answer.Set(row, rewards[row], mark | Marks.Seen, null);
            answer.BeginValues(ids.Length, false).Write(values);
            answer.EndSection();
        }

        private static byte[] Bytes(float[] numbers, params byte[] picture) =>
            MemoryMarshal.AsBytes(numbers.AsSpan()).ToArray().Concat(picture).ToArray();

        private static string Digits(byte[] bytes) => string.Concat(bytes.Select(one => one.ToString("x2")));

        private static object Ball() => Kind("Ball", 0, 2, new long[] { 3, 2 },
            Sensor("VectorSensor_size3", "float32", 0, new long[] { 3 }, 1),
            Sensor("Eye", "uint8", 1, new long[] { 1, 2, 2 }, 1, 2, 2));

        private static object Goal() =>
            Kind("Goal", 1, 0, new long[] { 2 }, Sensor("seen", "float32", 0, new long[] { 1 }, 1));

        private static object Kind(string name, long team, long continuous, long[] branches, params object[] sensors) =>
            new Dictionary<string, object>
            {
                ["name"] = name,
                ["team"] = team,
                ["continuous"] = continuous,
                ["branches"] = branches.Select(one => (object)one).ToList(),
                ["sensors"] = sensors.ToList(),
            };

        private static object Sensor(string name, string dtype, long type, long[] shape, params long[] properties) =>
            new Dictionary<string, object>
            {
                ["name"] = name,
                ["shape"] = shape.Select(one => (object)one).ToList(),
                ["dtype"] = dtype,
                ["type"] = type,
                ["properties"] = properties.Select(one => (object)one).ToList(),
            };
    }
}
