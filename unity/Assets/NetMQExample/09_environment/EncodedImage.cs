// Lesson 09, a picture that is a file already: PNG or JPEG. In Python it is its pixels, uint8 [height, width, 3], or
// [height, width] in grey.
//
//     public override object GetObservation() => new EncodedImage(texture.EncodeToJPG());
//
// The Python side is trees.py, and needs Pillow.
namespace NetMQExample
{
    /// <summary>A PNG or JPEG file as a value: an observation, or an info.</summary>
    public sealed class EncodedImage
    {
        /// <summary>The file is not copied.</summary>
        public EncodedImage(byte[] file) => File = Require.Given("file", file);

        public byte[] File { get; }
    }
}
