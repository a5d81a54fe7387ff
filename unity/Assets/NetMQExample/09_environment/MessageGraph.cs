// Lesson 09, a graph: Gymnasium's GraphInstance, as a value (MessageTree.cs) and in a space (GymSpace.cs).
namespace NetMQExample
{
    /// <summary>Points, what lies between them, and which it connects: Gymnasium's GraphInstance. Each is an array, or
    /// null.</summary>
    public sealed class MessageGraph
    {
        /// <summary>Without edges, the other two are left out.</summary>
        public MessageGraph(object nodes, object edges = null, object edgeLinks = null)
        {
            Nodes = nodes;
            Edges = edges;
            EdgeLinks = edgeLinks;
        }

        /// <summary>An item for each node.</summary>
        public object Nodes { get; }

        /// <summary>An item for each edge.</summary>
        public object Edges { get; }

        /// <summary>For each edge the numbers of two nodes, counted from 0: int32 [edges, 2].</summary>
        public object EdgeLinks { get; }
    }
}
