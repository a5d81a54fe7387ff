// Where a game object is, how it is turned, and what it belongs to.
using System.Collections;
using System.Collections.Generic;
using System.Linq;

namespace UnityEngine
{
    public enum Space { World, Self }

    public class Transform : Component, IEnumerable
    {
        private Vector3 place, size = Vector3.one;
        private Quaternion turn = Quaternion.identity;
        internal Transform Above { get; private set; }
        internal List<Transform> Children { get; } = new List<Transform>();
        /// <summary>This one, and all below it in the order of the hierarchy.</summary>
        internal IEnumerable<Transform> All => Children.SelectMany(child => child.All).Prepend(this);

        public Vector3 position
        {
            get { MainThread.Only("get_position"); return Above == null ? place : Above.TransformPoint(place); }
            set { MainThread.Only("set_position"); place = Above == null ? value : Above.InverseTransformPoint(value); }
        }

        public Quaternion rotation
        {
            get { MainThread.Only("get_rotation"); return Above == null ? turn : Above.rotation * turn; }
            set { MainThread.Only("set_rotation"); turn = Above == null ? value : Above.rotation.Back * value; }
        }

        public Vector3 localPosition
        {
            get => MainThread.Of("get_localPosition", place);
            set => place = MainThread.Of("set_localPosition", value);
        }
        public Quaternion localRotation
        {
            get => MainThread.Of("get_localRotation", turn);
            set => turn = MainThread.Of("set_localRotation", value);
        }
        public Vector3 localScale
        {
            get => MainThread.Of("get_localScale", size);
            set => size = MainThread.Of("set_localScale", value);
        }
        public Vector3 eulerAngles { get => rotation.eulerAngles; set => rotation = Quaternion.Euler(value); }
        public Vector3 localEulerAngles { get => turn.eulerAngles; set => localRotation = Quaternion.Euler(value); }
        public Vector3 forward { get => rotation * Vector3.forward; set => rotation = Quaternion.LookRotation(value); }
        public Vector3 up
        {
            get => rotation * Vector3.up;
            set => rotation = Quaternion.FromToRotation(Vector3.up, value);
        }
        public Vector3 right
        {
            get => rotation * Vector3.right;
            set => rotation = Quaternion.FromToRotation(Vector3.right, value);
        }
        public Vector3 lossyScale => Above == null ? localScale : Vector3.Scale(Above.lossyScale, size);
        public Transform root => Above == null ? this : Above.root;
        public int childCount => Children.Count;
        public Transform GetChild(int index) =>
            index >= 0 && index < Children.Count
                ? Children[index]
                : throw new UnityException("Transform child out of bounds");
        public IEnumerator GetEnumerator() => Children.ToList().GetEnumerator();
        /// <summary>By its name, or by those of the way to it, such as Arm/Hand. Null: there is none.</summary>
        public Transform Find(string n) =>
            n.Split('/').Aggregate(this, (here, name) => here?.Children.Find(child => child.name == name));

        public Transform parent
        {
            get { MainThread.Only("get_parent"); return Above; }
            set { SetParent(value, true); }
        }

        public void SetParent(Transform p) => SetParent(p, true);

        public void SetParent(Transform parent, bool worldPositionStays)
        {
            MainThread.Only(nameof(SetParent));
            if (parent == Above) return;
            var (before, looked, big, seen) = (position, rotation, lossyScale, Owner.activeInHierarchy);
            Above?.Children.Remove(this);
            Above = parent;
            Above?.Children.Add(this);
            if (worldPositionStays)
            {
                SetPositionAndRotation(before, looked);
                size = Above == null ? big : Apart(big, Above.lossyScale);
            }
            if (Owner.activeInHierarchy != seen) Owner.Refresh();
        }

        public void SetPositionAndRotation(Vector3 position, Quaternion rotation)
        {
            MainThread.Only(nameof(SetPositionAndRotation));
            (this.position, this.rotation) = (position, rotation);
        }

        public Vector3 TransformDirection(Vector3 direction) => rotation * direction;
        public Vector3 InverseTransformDirection(Vector3 direction) => rotation.Back * direction;

        public Vector3 TransformPoint(Vector3 position)
        {
            var here = place + (turn * Vector3.Scale(size, position));
            return Above == null ? here : Above.TransformPoint(here);
        }

        public Vector3 InverseTransformPoint(Vector3 position) =>
            Apart(turn.Back * ((Above == null ? position : Above.InverseTransformPoint(position)) - place), size);

        public void Translate(Vector3 translation) => Translate(translation, Space.Self);
        public void Translate(float x, float y, float z) => Translate(new Vector3(x, y, z));
        public void Translate(Vector3 translation, Space relativeTo) =>
            position += relativeTo == Space.World ? translation : TransformDirection(translation);

        // Around its own axes: z first, then x, then y.
        public void Rotate(Vector3 eulers) => Rotate(eulers, Space.Self);
        public void Rotate(float xAngle, float yAngle, float zAngle) => Rotate(new Vector3(xAngle, yAngle, zAngle));
        public void Rotate(float xAngle, float yAngle, float zAngle, Space relativeTo) =>
            Rotate(new Vector3(xAngle, yAngle, zAngle), relativeTo);
        public void Rotate(Vector3 eulers, Space relativeTo) => Turn(Quaternion.Euler(eulers), relativeTo);
        public void Rotate(Vector3 axis, float angle) => Rotate(axis, angle, Space.Self);
        public void Rotate(Vector3 axis, float angle, Space relativeTo) =>
            Turn(Quaternion.AngleAxis(angle, axis), relativeTo);
        public void RotateAround(Vector3 point, Vector3 axis, float angle)
        {
            var by = Quaternion.AngleAxis(angle, axis);
            SetPositionAndRotation(point + (by * (position - point)), by * rotation);
        }

        public void LookAt(Transform target)
        {
            if (target != null) LookAt(target.position);
        }

        public void LookAt(Vector3 worldPosition)
        {
            var way = worldPosition - position;
            if (way.sqrMagnitude > 0) rotation = Quaternion.LookRotation(way, Vector3.up);
        }

        private void Turn(Quaternion by, Space relativeTo)
        {
            if (relativeTo == Space.Self) localRotation *= by;
            else rotation = by * rotation;
        }

        private static Vector3 Apart(Vector3 a, Vector3 b) => new Vector3(a.x / b.x, a.y / b.y, a.z / b.z);
    }
}
