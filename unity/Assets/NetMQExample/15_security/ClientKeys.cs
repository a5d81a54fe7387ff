// Lesson 15, a client's keys: with three options a NetMQ socket encrypts, and the server knows whose it is.
//
//     var keys = new ClientKeys("keys");          server.key there, and this client's own pair
//     keys.Apply(socket);                         before Connect
//
// It goes with any NetMQ socket that connects.
// The pair is made at the first start, and its secret key never leaves the machine: one that came with the game would
// be the same in every copy, a password that everybody has. The game ships with the server's public key: as text in a
// field, or as server.key in the folder. The owner of the server then enrols this client's public key: client.key.
// The files are those of python/netmq_example/security/keys.py.
using System;
using System.IO;
using System.Runtime.InteropServices;
using System.Text.RegularExpressions;
using NetMQ;

namespace NetMQExample
{
    /// <summary>The server's public key, and this client's own pair.</summary>
    public sealed class ClientKeys
    {
        // Keys are written in Z85, which has no quotation mark.
        private const string Key = @"([!#-~]{40})";
        private const int LargestBytes = 4096;
        private readonly NetMQCertificate server, own;

        /// <summary>Reads them, and makes this client's pair where there is none.</summary>
        /// <param name="folder">Where they are kept. In Unity: below Application.persistentDataPath.</param>
        /// <param name="serverKey">The server's public key; if empty, that in server.key.</param>
        /// <exception cref="ArgumentException">A key is missing; the message names cause and cure.</exception>
        public ClientKeys(string folder, string serverKey = "")
        {
            var open = Path.Combine(Require.Given("folder", folder), "server.key");
            var secret = Path.Combine(folder, "client.key_secret");
            if (Require.Given("serverKey", serverKey) != "" && !Regex.IsMatch(serverKey, $"^{Key}$"))
                throw new ArgumentException($"no key: '{serverKey}'; a key has 40 characters, as in server.key");
            try
            {
                if (serverKey == "") serverKey = Read(open, "public");
                server = Certificate(open, () => NetMQCertificate.FromPublicKey(serverKey));
                if (!File.Exists(secret)) Make(folder, secret);
                var secretKey = Read(secret, "secret");
                var publicKey = Read(secret, "public");
                own = Certificate(secret, () => new NetMQCertificate(secretKey, publicKey));
            }
            catch (Exception e) when (e is IOException || e is UnauthorizedAccessException)
            {
                throw new ArgumentException($"cannot keep keys in {folder}: {e.Message}; name another folder");
            }
        }

        private ClientKeys(NetMQCertificate server, NetMQCertificate own) => (this.server, this.own) = (server, own);

        /// <summary>The key by which the server knows this client. Everybody may have it.</summary>
        public string PublicKey => own.PublicKeyZ85;

        /// <summary>Somebody whom the server does not know: a new pair, which is kept nowhere.</summary>
        public ClientKeys Stranger() => new ClientKeys(server, new NetMQCertificate());

        /// <summary>Gives a socket these keys. Call it before Connect.</summary>
        public void Apply(NetMQSocket socket)
        {
            socket.Options.CurveServerCertificate = server;
            socket.Options.CurveCertificate = own;
        }

        private static void Make(string folder, string secret)
        {
            var pair = new NetMQCertificate();
            var open = Path.Combine(folder, "client.key");
            if (File.Exists(open))
                throw new ArgumentException(
                    $"{open} is there, and is never overwritten; rotate makes a new pair, revoke frees a name");
            Directory.CreateDirectory(folder);
            // Nobody else may read it, not even for a moment: first its mode, then what it holds.
            using (new FileStream(secret, FileMode.CreateNew)) { }
            try
            {
                OnlyMine(secret);
                File.WriteAllText(secret, $"{Public(pair)}    secret-key = \"{pair.SecretKeyZ85}\"\n");
                File.WriteAllText(open, Public(pair));
            }
            catch (IOException)
            {
                // On a full disk: half a pair would be in the way ever after.
                File.Delete(secret);
                File.Delete(open);
                throw;
            }
        }

        private static string Public(NetMQCertificate pair) => $"curve\n    public-key = \"{pair.PublicKeyZ85}\"\n";

        private static string Read(string path, string kind)
        {
            var line = $"(?m)^\\s*{kind}-key *= *[\"']{Key}[\"']";
            var file = new FileInfo(path);
            // A pipe or a device, which may have no end, has no length.
            var readable = file.Exists && file.Length > 0 && file.Length <= LargestBytes;
            var found = Regex.Match(readable ? File.ReadAllText(path) : "", line);
            return found.Success ? found.Groups[1].Value : throw NoKey(path);
        }

        private static NetMQCertificate Certificate(string path, Func<NetMQCertificate> make)
        {
            // Characters that no key has.
            try { return make(); }
            catch (Exception e) when (e is ArgumentException || e is IndexOutOfRangeException) { throw NoKey(path); }
        }

        private static ArgumentException NoKey(string path) => new ArgumentException(
            $"no key in {Path.GetFullPath(path)}; keys.py makes keys, and server.key is a copy of the server's");

        private static void OnlyMine(string path)
        {
            // netstandard2.1 has no name for it. On Windows and on a phone the folder is the user's alone.
            try { Chmod(path, Convert.ToInt32("600", 8)); }
            catch (Exception e) when (e is DllNotFoundException || e is EntryPointNotFoundException) { }
        }

        [DllImport("libc", EntryPoint = "chmod")]
        private static extern int Chmod(string path, int mode);
    }
}
