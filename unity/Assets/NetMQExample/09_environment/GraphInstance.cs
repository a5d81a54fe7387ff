// Lesson 09, a graph: Gymnasium's GraphInstance, as a value (MessageTree.cs) and in a space (GymSpace.cs).
namespace NetMQExample
{
    /// <summary>Points, what lies between them, and which it connects. Each is an array, such as a float[,], or
    /// null.</summary>
    public sealed class GraphInstance
    {
        /// <summary>Without edges, the other two are left out.</summary>
        public GraphInstance(object nodes = null, object edges = null, object edgeLinks = null)
        {
            Nodes = nodes;
            Edges = edges;
            EdgeLinks = edgeLinks;
        }

        public object Nodes { get; set; }
        public object Edges { get; set; }

        /// <summary>For each edge the numbers of two nodes, counted from 0: int32 [edges, 2].</summary>
        public object EdgeLinks { get; set; }

        public override string ToString() =>
            $"nodes {Nodes ?? "none"}; edges {Edges ?? "none"}; links {EdgeLinks ?? "none"}";
    }
}
