// Lesson 05, an array of a single number is that number to .NET as well: Convert.ToSingle(array). And each array has a
// text, for a log.
using System;
using System.Linq;
using System.Runtime.InteropServices;

namespace NetMQExample
{
    public sealed partial class MessageArray : IConvertible
    {
        private const int MostShown = 8;

        /// <summary>Such as <c>float32 [2, 3]: 1, 2, 3, 4, 5, 6</c>; of a long one the first numbers.</summary>
        public override string ToString()
        {
            var count = Data.Length / SizeOf(Dtype);
            var shown = Enumerable.Range(0, Math.Min(count, MostShown))
                .Select(at => FormattableString.Invariant($"{At(at)}"));
            var more = count > MostShown ? ", …" : "";
            return $"{Dtype} [{string.Join(", ", Shape)}]: {string.Join(", ", shown)}{more}";
        }

        TypeCode IConvertible.GetTypeCode() => TypeCode.Object;
        bool IConvertible.ToBoolean(IFormatProvider provider) => Convert.ToBoolean(Number(), provider);
        byte IConvertible.ToByte(IFormatProvider provider) => Convert.ToByte(Number(), provider);
        char IConvertible.ToChar(IFormatProvider provider) => (char)Convert.ToUInt16(Number(), provider);
        DateTime IConvertible.ToDateTime(IFormatProvider provider) =>
            throw new InvalidCastException("a number is no date");
        decimal IConvertible.ToDecimal(IFormatProvider provider) => Convert.ToDecimal(Number(), provider);
        double IConvertible.ToDouble(IFormatProvider provider) => Convert.ToDouble(Number(), provider);
        short IConvertible.ToInt16(IFormatProvider provider) => Convert.ToInt16(Number(), provider);
        int IConvertible.ToInt32(IFormatProvider provider) => Convert.ToInt32(Number(), provider);
        long IConvertible.ToInt64(IFormatProvider provider) => Convert.ToInt64(Number(), provider);
        sbyte IConvertible.ToSByte(IFormatProvider provider) => Convert.ToSByte(Number(), provider);
        float IConvertible.ToSingle(IFormatProvider provider) => Convert.ToSingle(Number(), provider);
        string IConvertible.ToString(IFormatProvider provider) => ToString();
        ushort IConvertible.ToUInt16(IFormatProvider provider) => Convert.ToUInt16(Number(), provider);
        uint IConvertible.ToUInt32(IFormatProvider provider) => Convert.ToUInt32(Number(), provider);
        ulong IConvertible.ToUInt64(IFormatProvider provider) => Convert.ToUInt64(Number(), provider);

        object IConvertible.ToType(Type type, IFormatProvider provider) => type.IsInstanceOfType(this) ? this
            : type == typeof(string) ? ToString() : Convert.ChangeType(Number(), type, provider);

        private object Number() => Data.Length == SizeOf(Dtype) ? At(0)
            : throw new InvalidCastException($"this array has no single number: {this}");

        private object At(int at) => Dtype switch
        {
            "uint8" => At<byte>(at),
            "uint16" => At<ushort>(at),
            "int32" => At<int>(at),
            "int64" => At<long>(at),
            "float32" => At<float>(at),
            _ => At<double>(at),
        };

        // Mono lacks the indexer of a ReadOnlySpan that C# asks for.
        private T At<T>(int at) where T : struct => MemoryMarshal.Read<T>(Data.Span.Slice(at * SizeOf(Dtype)));
    }
}
