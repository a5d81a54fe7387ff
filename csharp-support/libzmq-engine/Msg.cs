// Msg: one frame in a buffer that can be reused, for programs that must not allocate.
using System;
using System.Text;
using System.Threading;

namespace NetMQ
{
    /// <summary>What a <see cref="Msg"/> is, besides its bytes.</summary>
    [Flags]
    public enum MsgFlags : byte
    {
        /// <summary>Nothing special.</summary>
        None = 0,
        /// <summary>Further frames of the same message follow.</summary>
        More = 1,
        /// <summary>For ZeroMQ itself.</summary>
        Command = 2,
        /// <summary>A peer's identity.</summary>
        Identity = 64,
        /// <summary>Several Msg share the buffer.</summary>
        Shared = 128,
    }

    /// <summary>Where the bytes of a <see cref="Msg"/> live.</summary>
    public enum MsgType : byte
    {
        /// <summary>Not initialised, or closed.</summary>
        Uninitialised = 0,
        /// <summary>No bytes.</summary>
        Empty = 101,
        /// <summary>An array of the program.</summary>
        GC = 102,
        /// <summary>A buffer of the <see cref="BufferPool"/>.</summary>
        Pool = 103,
    }

    /// <summary>One frame. Each Init needs a Close; sending leaves it empty, receiving replaces what it held.</summary>
    public struct Msg
    {
        private sealed class Owners
        {
            internal int Count = 1;
        }

        private Owners? owners;
        private byte[]? data;
        private int offset;

        /// <summary>The number of bytes.</summary>
        public int Size { get; private set; }

        /// <summary>Where the bytes live.</summary>
        public MsgType MsgType { get; private set; }

        /// <summary>What it is, besides its bytes.</summary>
        public MsgFlags Flags { get; private set; }

        /// <summary>True if there are no bytes.</summary>
        public readonly bool IsEmpty => data == null || Size == 0;

        /// <summary>True between an Init and Close.</summary>
        public readonly bool IsInitialised => MsgType != MsgType.Uninitialised;

        /// <summary>True if further frames of the same message follow.</summary>
        public readonly bool HasMore => (Flags & MsgFlags.More) != 0;

        /// <summary>True if another Msg shares the buffer.</summary>
        public readonly bool IsShared => (Flags & MsgFlags.Shared) != 0;

        /// <summary>True for a peer's identity.</summary>
        public readonly bool IsIdentity => (Flags & MsgFlags.Identity) != 0;

        /// <summary>The whole buffer.</summary>
        [Obsolete("Use implicit casting to Span or Slice instead")]
        public readonly byte[]? Data => data;

        /// <summary>Where in the buffer the bytes begin.</summary>
        [Obsolete("Use implicit casting to Span or Slice instead")]
        public readonly int Offset => offset;

        /// <summary>One byte.</summary>
        public readonly byte this[int index]
        {
            get => data![offset + index];
            set => data![offset + index] = value;
        }

        /// <summary>The bytes.</summary>
        public static implicit operator Span<byte>(Msg msg) => msg.Slice();

        /// <summary>The bytes.</summary>
        public static implicit operator ReadOnlySpan<byte>(Msg msg) => msg.Slice();

        /// <summary>No bytes.</summary>
        public void InitEmpty() => Init(MsgType.Empty, null, 0, 0);

        /// <summary>A buffer of the <see cref="BufferPool"/>, which gets it back at Close.</summary>
        public void InitPool(int size) => Init(MsgType.Pool, BufferPool.Take(size), 0, size);

        /// <summary>The first bytes of an array of the program.</summary>
        public void InitGC(byte[] data, int size) => Init(MsgType.GC, data, 0, size);

        /// <summary>Some bytes of an array of the program.</summary>
        public void InitGC(byte[] data, int offset, int size) => Init(MsgType.GC, data, offset, size);

        private void Init(MsgType type, byte[]? buffer, int start, int size)
        {
            MsgType = type;
            Flags = MsgFlags.None;
            data = buffer;
            offset = start;
            Size = size;
            owners = null;
        }

        /// <summary>Gives the buffer back.</summary>
        public void Close()
        {
            if (!IsInitialised) throw new FaultException("Cannot close an uninitialised Msg.");
            if (MsgType == MsgType.Pool && (owners == null || Interlocked.Decrement(ref owners.Count) == 0))
            {
                BufferPool.Return(data!);
            }
            owners = null;
            data = null;
            MsgType = MsgType.Uninitialised;
        }

        /// <summary>Shares the buffer of another Msg; the last one to close gives it back.</summary>
        public void Copy(ref Msg src)
        {
            if (!src.IsInitialised) throw new FaultException("Cannot copy an uninitialised Msg.");
            if (IsInitialised) Close();
            if (src.MsgType == MsgType.Pool)
            {
                src.owners ??= new Owners();
                Interlocked.Increment(ref src.owners.Count);
                src.Flags |= MsgFlags.Shared;
            }
            this = src;
        }

        /// <summary>Takes over the buffer of another Msg, which is empty afterwards.</summary>
        public void Move(ref Msg src)
        {
            if (!src.IsInitialised) throw new FaultException("Cannot move an uninitialised Msg.");
            if (IsInitialised) Close();
            this = src;
            src.InitEmpty();
        }

        /// <summary>Sets flags.</summary>
        public void SetFlags(MsgFlags flags) => Flags |= flags;

        /// <summary>Clears flags.</summary>
        public void ResetFlags(MsgFlags flags) => Flags &= ~flags;

        /// <summary>The bytes.</summary>
        public readonly Span<byte> Slice() => new Span<byte>(data, offset, data == null ? 0 : Size);

        /// <summary>The bytes from a place on.</summary>
        public readonly Span<byte> Slice(int offset)
        {
            // NetMQ adds the Msg's own offset here, so a Msg that begins inside its buffer can be cut less far.
            if (this.offset + offset > Size) throw new ArgumentOutOfRangeException(nameof(offset));
            return new Span<byte>(data, this.offset + offset, Size - offset);
        }

        /// <summary>Some of the bytes.</summary>
        public readonly Span<byte> Slice(int offset, int count)
        {
            if (this.offset + offset + count > Size) throw new ArgumentOutOfRangeException(nameof(offset));
            return new Span<byte>(data, this.offset + offset, count);
        }

        /// <summary>The bytes, as memory.</summary>
        public readonly Memory<byte> SliceAsMemory() => data == null ? default : new Memory<byte>(data, offset, Size);

        /// <summary>Skips bytes at the beginning.</summary>
        public void TrimPrefix(int count)
        {
            if (count > Size || count < 0)
            {
                throw new ArgumentOutOfRangeException(nameof(count), "Count should be between 0 and size");
            }
            offset += count;
            Size -= count;
        }

        /// <summary>Copies the bytes out.</summary>
        public readonly void CopyTo(Span<byte> span) => Slice().CopyTo(span);

        /// <summary>A copy of the bytes.</summary>
        public readonly byte[] ToArray() => Slice().ToArray();

        /// <summary>A copy of the bytes.</summary>
        public readonly byte[] CloneData() => Slice().ToArray();

        /// <summary>The bytes as text.</summary>
        public readonly string GetString(Encoding encoding) => encoding.GetString(data!, offset, Size);

        /// <summary>Some of the bytes as text.</summary>
        public readonly string GetString(Encoding encoding, int offset, int count)
            => encoding.GetString(data!, this.offset + offset, count);

        /// <summary>Copies bytes in.</summary>
        public readonly void Put(byte[]? src, int dstOffset, int len) => Put(src, 0, dstOffset, len);

        /// <summary>Copies bytes in.</summary>
        public readonly void Put(byte[]? src, int srcOffset, int dstOffset, int len)
        {
            if (len != 0 && src != null) Buffer.BlockCopy(src, srcOffset, data!, dstOffset, len);
        }

        /// <summary>Copies bytes in.</summary>
        public void Put(Span<byte> src, int offset) => src.CopyTo(Slice(offset));

        /// <summary>Sets the first byte.</summary>
        public readonly void Put(byte b) => data![offset] = b;

        /// <summary>Sets one byte.</summary>
        public readonly void Put(byte b, int i) => data![offset + i] = b;

        /// <summary>Writes text in.</summary>
        public readonly void Put(Encoding encoding, string str, int index)
            => encoding.GetBytes(str, 0, str.Length, data!, offset + index);

        /// <summary>Goes through the bytes.</summary>
        public readonly Span<byte>.Enumerator GetEnumerator() => Slice().GetEnumerator();

        /// <inheritdoc/>
        public override readonly string ToString() => $"{base.ToString()}[{MsgType},{Size},{Flags}]";
    }
}
