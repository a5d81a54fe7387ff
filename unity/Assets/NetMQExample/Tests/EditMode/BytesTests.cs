// For Window > General > Test Runner, EditMode: what needs no Play, as the bytes of the messages.
using System;
using System.Linq;
using System.Text;
using NUnit.Framework;

namespace NetMQExample.EditModeTests
{
    public class BytesTests
    {
        [Test]
        public void AMessageComesBackAsItWasSent()
        {
            var message = new Message("frame", 7) { Values = { ["x"] = 0.5, ["text"] = "zwölf" } };
            message.Arrays.Add(new MessageArray("uint8", new byte[] { 1, 2, 3, 4, 5, 6 }, 2, 3));
            var back = Message.Read(new[] { Bytes(message.Header()), message.Arrays[0].Data });
            Assert.That((back.Kind, back.Id), Is.EqualTo(("frame", 7L)));
            Assert.That((back.Values["x"], back.Values["text"]), Is.EqualTo(((object)0.5, (object)"zwölf")));
            Assert.That(back.Arrays.Single().Shape, Is.EqualTo(new[] { 2, 3 }));
            Assert.That(back.Arrays.Single().Data.ToArray(), Is.EqualTo(new byte[] { 1, 2, 3, 4, 5, 6 }));
        }

        [Test]
        public void ACutMessageIsRefused() =>
            Assert.Throws<MessageException>(() => Message.Read(new[] { Bytes("{") }));

        [Test]
        public void APoseIsReadInUnitysAxes()
        {
            var pose = BodyPose.Parse("pose/0/ 3 1.5" + string.Concat(Enumerable.Repeat(" 0.1 0.2 0.3 1", 33)));
            Assert.That((pose.Number, pose.Seconds), Is.EqualTo((3L, 1.5)));
            Assert.That(pose.Places.Take(3), Is.EqualTo(new[] { 0.1, -0.2, 0.3 }));
            Assert.That(BodyPose.Parse("pose/0/ 3 1.5 0.1"), Is.Null);
        }

        private static ReadOnlyMemory<byte> Bytes(string text) => Encoding.UTF8.GetBytes(text);
    }
}
