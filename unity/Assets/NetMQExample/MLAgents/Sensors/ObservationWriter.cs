// ML-Agents' shape, a writer: where a sensor's Write puts its numbers.
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;
using UnityEngine;

namespace NetMQExample.MLAgents.Sensors
{
    /// <summary>The array of one sensor. Numbers that are not written are 0.</summary>
    public class ObservationWriter
    {
        private float[] numbers = new float[0];
        private int size, height, width;

        public float this[int index] { set => numbers[Within(index, size)] = value; }
        public float this[int ch, int w] { set => this[(ch * width) + Within(w, width)] = value; }

        /// <summary>A number of a picture, from 0 to 1; the highest row is 0.</summary>
        public float this[int ch, int h, int w] { set => this[(ch * height) + Within(h, height), w] = value; }

        public void AddList(IList<float> data, int writeOffset = 0)
        {
            for (var i = 0; i < data.Count; i++) this[writeOffset + i] = data[i];
        }

        public void Add(Vector3 vec, int writeOffset = 0) => AddList(new[] { vec.x, vec.y, vec.z }, writeOffset);
        public void Add(Vector4 vec, int writeOffset = 0) => AddList(new[] { vec.x, vec.y, vec.z, vec.w }, writeOffset);

        public void Add(Quaternion quat, int writeOffset = 0) =>
            Add(new Vector4(quat.x, quat.y, quat.z, quat.w), writeOffset);

        // Its numbers are good until the next sensor writes.
        internal ReadOnlySpan<byte> BytesOf(ISensor sensor)
        {
            var shape = sensor.GetObservationSpec().Shape;
            size = sensor.ObservationSize();
            width = shape[shape.Length - 1];
            height = shape.Length > 1 ? shape[shape.Length - 2] : 1;
            if (numbers.Length < size) numbers = new float[size];
            Array.Clear(numbers, 0, size);
            sensor.Write(this);
            return MemoryMarshal.AsBytes(numbers.AsSpan(0, size));
        }

        private static int Within(int place, int end) => place >= 0 && place < end ? place : throw Outside(place, end);

        private static UnityAgentsException Outside(int place, int end) => new UnityAgentsException(
            $"a sensor writes to place {place} of {end}: compare its Write with its GetObservationSpec");
    }
}
