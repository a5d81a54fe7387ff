"""The parts of Unity that a project may lack, and the types by which a script shows that it needs one.

Unity calls them built-in packages. A script in a project without the module of a type does not compile.
"""

import re
from collections.abc import Iterable

VERSION = "1.0.0"
# tests/unity/test_unity_project.py compares these types with the sources of Unity that declare them.
TYPES = {
    "com.unity.modules.animation": {"Animator", "HumanBodyBones"},
    # EncodeToJPG is called on the texture, and so without the name of its class.
    "com.unity.modules.imageconversion": {"ImageConversion", "EncodeToJPG"},
    "com.unity.modules.imgui": {"GUI", "GUILayout", "GUILayoutOption"},
    "com.unity.modules.jsonserialize": {"JsonUtility"},
    # CreatePrimitive gives each shape a collider.
    "com.unity.modules.physics": {
        "BoxCollider",
        "Collider",
        "CreatePrimitive",
        "Physics",
        "RaycastHit",
        "SimulationMode",
        "SphereCollider",
    },
    "com.unity.modules.ui": {"Canvas"},
}


def needed(scripts: Iterable[str]) -> set[str]:
    """The modules that these C# files need, by the names of Unity's packages; each has VERSION."""
    words = {word for code in scripts for word in re.findall(r"\w+", re.sub(r"//.*", "", code))}
    return {module for module, types in TYPES.items() if types & words}
