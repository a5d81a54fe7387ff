"""Lesson 08, the cameras on the car: what they see now, as the arrays of a message.

Take home: this file, pictures.py, world.py, whose camera only stands for your own, and messages.py of lesson 05.
"""

import sys
from pathlib import Path

from pictures import encode
from world import Car, DrawnCamera, Road

# messages.py is lesson 05's. At home it lies beside this file.
sys.path.append(str(Path(__file__).parent / "../05_messages"))
from messages import Array

# How far to the right of the car's middle each camera is: two as far apart as eyes, three as in Udacity's car.
RIGHT = {"center": (0.0,), "left,right": (-0.075, 0.075), "left,center,right": (-0.8, 0.0, 0.8)}


class Cameras:
    def __init__(self, road: Road, names: str, jpeg: bool) -> None:
        self.names, self.encoding, self._drawn = names, "jpeg" if jpeg else "raw", DrawnCamera(road)

    def arrays(self, car: Car, number: int) -> list[Array]:
        """Raw pictures with the lowest row first, or JPEG files, which have the top row first."""
        seen = [self._drawn.draw(car, number, right) for right in RIGHT[self.names]]
        if self.encoding == "raw":
            return [Array("uint8", picture.shape, picture) for picture in seen]
        files = [encode(picture[::-1]) for picture in seen]
        return [Array("uint8", (len(file),), file) for file in files]
