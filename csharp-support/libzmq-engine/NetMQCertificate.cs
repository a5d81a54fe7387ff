// CURVE keys, made and written by libzmq.
using System;
using System.Text;

namespace NetMQ
{
    /// <summary>A pair of CURVE keys, or only a peer's public one.</summary>
    public unsafe class NetMQCertificate
    {
        /// <summary>A new pair.</summary>
        public NetMQCertificate()
        {
            var publicText = new byte[41];
            var secretText = new byte[41];
            fixed (byte* open = publicText, secret = secretText) Check(Native.Instance.CurveKeys(open, secret));
            PublicKey = Decode(publicText);
            SecretKey = Decode(secretText);
        }

        /// <summary>A known pair, 32 bytes each.</summary>
        public NetMQCertificate(byte[] secretKey, byte[] publicKey)
        {
            if (secretKey.Length != 32) throw new ArgumentException("secretKey must be 32 bytes length");
            if (publicKey.Length != 32) throw new ArgumentException("publicKey must be 32 bytes length");
            SecretKey = secretKey;
            PublicKey = publicKey;
        }

        /// <summary>A known pair as text, 40 characters of Z85 each.</summary>
        public NetMQCertificate(string secretKey, string publicKey)
        {
            if (secretKey.Length != 40) throw new ArgumentException("secretKey must be 40 char long");
            if (publicKey.Length != 40) throw new ArgumentException("publicKey must be 40 char long");
            SecretKey = Decode(Native.CString(secretKey));
            PublicKey = Decode(Native.CString(publicKey));
        }

        private NetMQCertificate(byte[]? secretKey, byte[] publicKey, bool known)
        {
            if ((secretKey ?? publicKey).Length != 32) throw new ArgumentException("key must be 32 bytes length");
            SecretKey = secretKey;
            PublicKey = known ? publicKey : PublicOf(publicKey);
        }

        /// <summary>The secret key, 32 bytes, if known.</summary>
        public byte[]? SecretKey { get; }

        /// <summary>The secret key as text, if known.</summary>
        public string? SecretKeyZ85 => SecretKey == null ? null : Encode(SecretKey);

        /// <summary>True if the secret key is known.</summary>
        public bool HasSecretKey => SecretKey != null;

        /// <summary>The public key, 32 bytes.</summary>
        public byte[] PublicKey { get; }

        /// <summary>The public key as text.</summary>
        public string PublicKeyZ85 => Encode(PublicKey);

        /// <summary>The pair that belongs to a secret key.</summary>
        public static NetMQCertificate CreateFromSecretKey(byte[] secretKey)
            => new NetMQCertificate(secretKey, secretKey, false);

        /// <summary>The pair that belongs to a secret key.</summary>
        public static NetMQCertificate CreateFromSecretKey(string secretKey) => CreateFromSecretKey(Key(secretKey));

        /// <summary>A peer's public key.</summary>
        public static NetMQCertificate FromPublicKey(byte[] publicKey) => new NetMQCertificate(null, publicKey, true);

        /// <summary>A peer's public key.</summary>
        public static NetMQCertificate FromPublicKey(string publicKey) => FromPublicKey(Key(publicKey));

        private static byte[] Key(string text)
            => text.Length == 40 ? Decode(Native.CString(text))
                : throw new ArgumentException("key must be 40 bytes length");

        private static byte[] PublicOf(byte[] secretKey)
        {
            var publicText = new byte[41];
            fixed (byte* open = publicText, secret = Native.CString(Encode(secretKey)))
            {
                Check(Native.Instance.CurvePublicKey(open, secret));
            }
            return Decode(publicText);
        }

        private static void Check(int result)
        {
            if (result < 0) throw new NotSupportedException("this libzmq was built without CURVE");
        }

        private static string Encode(byte[] key)
        {
            var text = new byte[41];
            fixed (byte* to = text, from = key) Native.Instance.EncodeZ85(to, from, (IntPtr)key.Length);
            return Encoding.ASCII.GetString(text, 0, 40);
        }

        private static byte[] Decode(byte[] text)
        {
            var key = new byte[32];
            fixed (byte* to = key, from = text)
            {
                if (Native.Instance.DecodeZ85(to, from) == null) throw new ArgumentException("Invalid key character");
            }
            return key;
        }
    }
}
