// Lesson 08 in a terminal: the terminal client of CameraSender.cs, with the same drive, and a camera that draws.
//
//     dotnet run --project csharp-console -- 8
//     dotnet run --project csharp-console -- 8 --lockstep       the world waits for each action
//     dotnet run --project csharp-console -- 8 --drive          arrow keys take over, Enter gives back
// JPEG is for the Python client and for Unity: .NET itself has no encoder.
using System;
using System.Threading;
using System.Threading.Tasks;

namespace NetMQExample.Terminal
{
    internal static class Lesson08
    {
        public static void Run(Arguments arguments)
        {
        }
    }
}
