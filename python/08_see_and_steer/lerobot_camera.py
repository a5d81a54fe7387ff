"""Lesson 08, a bridge: any Unity camera becomes a camera of LeRobot, Hugging Face's kit for robots that learn.

    python python/08_see_and_steer/lerobot_camera.py         in place of server.py, beside any client of this lesson

In LeRobot: ZMQCameraConfig(server_address="127.0.0.1", port=5555, camera_name="center"). What its ZMQCamera reads is
one JSON text, {"timestamps": {name: seconds}, "images": {name: JPEG file in base64}}, from a PUB socket; see
src/lerobot/cameras/zmq in github.com/huggingface/lerobot.
It needs numpy and Pillow.
"""

import base64
import contextlib
import json
import sys
from pathlib import Path

sys.path[:0] = map(str, Path(__file__).resolve().parents[:2])
import zmq

from netmq_example.extras import importing
from netmq_example.program import Context, Socket, listening, run, server_endpoint, server_options

with importing("numpy and Pillow: pip install numpy pillow, or let kit.py run 8 do it"):
    from driver import follow_road, main_camera

    from netmq_example.camera.pictures import encode, pictures
    from netmq_example.messages import LIMIT, Message, message_reply


def answer(frame: Message) -> Message:
    """So that the car drives on."""
    throttle, brake, steer = follow_road(main_camera(pictures(frame)), float(frame.values["speed"]))
    return Message("action", frame.id, {"frame": frame.id, "throttle": throttle, "brake": brake, "steer": steer})


def published(frame: Message) -> str:
    seen = pictures(frame)
    # Red and blue change places: what OpenCV reads from the file, blue first, LeRobot takes for red first.
    images = {name: base64.b64encode(encode(picture[:, :, ::-1])).decode() for name, picture in seen.items()}
    return json.dumps({"timestamps": dict.fromkeys(seen, frame.values["wall_time"]), "images": images})


def only_the_newest(context: Context, socket: Socket) -> None:
    """Old pictures are worth nothing."""
    socket.sndhwm = 2


def main() -> None:
    parser = server_options(__doc__, "tcp://127.0.0.1:5558")
    where = "tcp://127.0.0.1:5555"
    parser.add_argument("--publish", type=server_endpoint(where), default=where, help="where LeRobot connects")
    options = parser.parse_args()
    with (
        listening(zmq.PUB, options, prepare=only_the_newest, endpoint=options.publish, word="publishing") as lerobot,
        listening(zmq.REP, options, largest=4 * LIMIT) as unity,
    ):
        while True:
            # The socket waits in slices: on Windows Ctrl-C does not interrupt a longer wait.
            with contextlib.suppress(zmq.Again):
                frame, action, parts = message_reply(answer, unity.recv_multipart(copy=False))
                unity.send_multipart(parts)
                if action.kind == "action":
                    lerobot.send_string(published(frame))


if __name__ == "__main__":
    run(main)
