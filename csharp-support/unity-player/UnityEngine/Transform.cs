// Where a game object is, how it is turned, and what it belongs to.
namespace UnityEngine
{
    public class Transform : Component
    {
        private Vector3 place;
        private Quaternion turn = Quaternion.identity;
        private Vector3 size = Vector3.one;
        private Transform above;

        // Beside others as in Unity, but for one thing: what has parts must have the scale 1.
        public Vector3 position
        {
            get { MainThread.Only("get_position"); return above == null ? place : above.position + (above.rotation * place); }
            set { MainThread.Only("set_position"); place = above == null ? value : above.rotation.Back * (value - above.position); }
        }

        public Quaternion rotation
        {
            get { MainThread.Only("get_rotation"); return above == null ? turn : above.rotation * turn; }
            set { MainThread.Only("set_rotation"); turn = above == null ? value : above.rotation.Back * value; }
        }

        public Vector3 localPosition
        {
            get { MainThread.Only("get_localPosition"); return place; }
            set { MainThread.Only("set_localPosition"); place = value; }
        }

        public Quaternion localRotation
        {
            get { MainThread.Only("get_localRotation"); return turn; }
            set { MainThread.Only("set_localRotation"); turn = value; }
        }

        public Vector3 eulerAngles
        {
            get => rotation.eulerAngles;
            set => rotation = Quaternion.Euler(value);
        }

        public Vector3 forward
        {
            get => rotation * Vector3.forward;
            set => rotation = Quaternion.LookRotation(value);
        }

        public Vector3 localScale
        {
            get { MainThread.Only("get_localScale"); return size; }
            set { MainThread.Only("set_localScale"); size = value; }
        }

        public Vector3 lossyScale
        {
            get { MainThread.Only("get_lossyScale"); return above == null ? size : Vector3.Scale(above.lossyScale, size); }
        }

        public Transform root => above == null ? this : above.root;

        public Transform parent
        {
            get { MainThread.Only("get_parent"); return above; }
            set { SetParent(value, true); }
        }

        public void SetParent(Transform p) => SetParent(p, true);

        public void SetParent(Transform parent, bool worldPositionStays)
        {
            MainThread.Only(nameof(SetParent));
            var (before, looked) = (position, rotation);
            above = parent;
            if (worldPositionStays) SetPositionAndRotation(before, looked);
        }

        public void SetPositionAndRotation(Vector3 position, Quaternion rotation)
        {
            MainThread.Only(nameof(SetPositionAndRotation));
            (this.position, this.rotation) = (position, rotation);
        }

        public Vector3 TransformDirection(Vector3 direction) => rotation * direction;

        // Around its own axes: z first, then x, then y.
        public void Rotate(Vector3 eulers) => localRotation *= Quaternion.Euler(eulers);

        public void Rotate(float xAngle, float yAngle, float zAngle) => Rotate(new Vector3(xAngle, yAngle, zAngle));

        public void LookAt(Transform target)
        {
            if (target != null) LookAt(target.position);
        }

        public void LookAt(Vector3 worldPosition)
        {
            var way = worldPosition - position;
            if (way.sqrMagnitude > 0) rotation = Quaternion.LookRotation(way, Vector3.up);
        }

        internal bool IsBelow(Transform top) => this == top || (above != null && above.IsBelow(top));

        internal bool IsPartOf(GameObject whole) => above != null && above.Owner == whole;
    }
}
