// A scene shows cubes of one colour each, and cameras look at them when they are told to.
using System;

namespace UnityEngine.Rendering
{
    public enum GraphicsDeviceType { Null = 4, OpenGLCore = 17 }
    public abstract class RenderPipelineAsset : ScriptableObject { }

    public sealed class GraphicsSettings : Object
    {
        /// <summary>None: the built-in pipeline.</summary>
        public static RenderPipelineAsset currentRenderPipeline { get; internal set; }
    }
}

namespace UnityEngine
{
    using UnityEngine.Rendering;

    public enum PrimitiveType { Sphere = 0, Cube = 3 }
    public enum CameraClearFlags { Skybox = 1, Color = 2, SolidColor = 2, Depth = 3, Nothing = 4 }
    public enum RenderTextureFormat { ARGB32 = 0 }
    public enum RenderTextureReadWrite { Default = 0, sRGB = 2 }

    public sealed class Shader : Object
    {
        /// <summary>Those of the game.</summary>
        internal static string[] All { get; set; } = { "Sprites/Default" };
        public static Shader Find(string name) => Array.IndexOf(All, name) < 0 ? null : new Shader { Title = name };
    }

    public class Material : Object
    {
        public Material(Material source)
        {
            MainThread.Only("CreateWithMaterial");
            color = source.color;
            LoadedScene.Made.Add(this);
        }

        public Material(Shader shader)
        {
            MainThread.Only("CreateWithShader");
            Drawn = shader.Title;
            LoadedScene.Made.Add(this);
        }

        internal Material() { }
        /// <summary>By which shader; Standard is the built-in pipeline's.</summary>
        internal string Drawn { get; } = "Standard";
        public Color color { get; set; } = new Color(1, 1, 1, 1);
    }

    public class Renderer : Component
    {
        private static readonly Material Default = new Material();
        private Material own;
        public bool enabled { get; set; } = true;
        public Material sharedMaterial { get; set; } = Default;

        // In Unity each caller gets a copy of its own.
        public Material material
        {
            get
            {
                MainThread.Only("get_material");
                if (own == null) own = sharedMaterial = new Material(sharedMaterial);
                return own;
            }
        }
    }

    public class MeshRenderer : Renderer { }

    public class RenderTexture : Texture
    {
        public RenderTexture(
            int width, int height, int depth, RenderTextureFormat format = RenderTextureFormat.ARGB32,
            RenderTextureReadWrite readWrite = RenderTextureReadWrite.Default)
        {
            MainThread.Only("Internal_Create");
            this.width = width;
            this.height = height;
            Pixels = new byte[width * height * 4];
            LoadedScene.Made.Add(this);
        }

        public static RenderTexture active { get; set; }
        // Red, green, blue and alpha, as a picture of RGBA32.
        internal byte[] Pixels { get; }

        /// <summary>A graphics card would have its memory back.</summary>
        public void Release() => MainThread.Only(nameof(Release));
    }

    public sealed class Camera : Behaviour
    {
        private static readonly Rasterizer Graphics = new Rasterizer();
        /// <summary>The time that rendering has taken so far. In Unity the graphics card does it.</summary>
        internal static System.Diagnostics.Stopwatch Rendering { get; } = new System.Diagnostics.Stopwatch();

        public static Camera main
        {
            get
            {
                MainThread.Only("get_main");
                foreach (var thing in LoadedScene.Objects)
                    if (thing.tag == "MainCamera" && thing.GetComponent<Camera>() is Camera camera
                        && camera.isActiveAndEnabled)
                        return camera;
                return null;
            }
        }

        public float fieldOfView { get; set; } = 60;
        public float nearClipPlane { get; set; } = 0.3f;
        public float farClipPlane { get; set; } = 1000;
        public CameraClearFlags clearFlags { get; set; } = CameraClearFlags.Skybox;
        public Color backgroundColor { get; set; } = new Color(0.19215686f, 0.3019608f, 0.4745098f, 0);
        public RenderTexture targetTexture { get; set; }
        // The part of what it draws on; here it draws on all of a render texture.
        public Rect rect { get; set; } = new Rect(0, 0, 1, 1);
        // A bit for each layer.
        public int cullingMask { get; set; } = -1;

        // Not whether it is enabled.
        public void CopyFrom(Camera other)
        {
            MainThread.Only(nameof(CopyFrom));
            transform.SetPositionAndRotation(other.transform.position, other.transform.rotation);
            (fieldOfView, nearClipPlane, farClipPlane) = (other.fieldOfView, other.nearClipPlane, other.farClipPlane);
            (clearFlags, backgroundColor, targetTexture) = (other.clearFlags, other.backgroundColor,
                other.targetTexture);
            cullingMask = other.cullingMask;
        }

        public void Render()
        {
            MainThread.Only(nameof(Render));
            if (targetTexture == null || SystemInfo.graphicsDeviceType == GraphicsDeviceType.Null) return;
            Rendering.Start();
            Graphics.Draw(this, targetTexture);
            Rendering.Stop();
        }
    }

    public sealed class SystemInfo
    {
        internal static bool NoGraphics { get; set; }
        internal static bool NoReadback { get; set; }
        /// <summary>Some graphics cards keep what a camera has rendered with the highest row first.</summary>
        internal static bool TopRowFirst { get; set; }
        public static GraphicsDeviceType graphicsDeviceType =>
            NoGraphics ? GraphicsDeviceType.Null : GraphicsDeviceType.OpenGLCore;
        public static bool supportsAsyncGPUReadback => !NoGraphics && !NoReadback;
    }
}
