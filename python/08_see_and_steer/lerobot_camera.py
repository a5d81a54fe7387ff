"""Lesson 08, a bridge: any Unity camera becomes a camera of LeRobot, Hugging Face's kit for robots that learn.

    python python/08_see_and_steer/lerobot_camera.py         in place of server.py, beside any client of this lesson

In LeRobot: ZMQCameraConfig(server_address="127.0.0.1", port=5555, camera_name="center"). What its ZMQCamera reads is
one JSON text, {"timestamps": {name: seconds}, "images": {name: JPEG file in base64}}, from a PUB socket; see
src/lerobot/cameras/zmq in github.com/huggingface/lerobot.
It needs numpy and Pillow.
"""

import argparse
import base64
import json
import signal
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import zmq
from driver import follow_road

from netmq_example.camera.pictures import check_values, encode, pictures
from netmq_example.messages import LIMIT, Message, MessageError, read

UNITY, LEROBOT = "tcp://127.0.0.1:5558", "tcp://127.0.0.1:5555"


def bridge(unity: zmq.Socket[bytes], lerobot: zmq.Socket[bytes]) -> None:
    """Answer a picture so that the car drives on, and publish it."""
    frame = Message("")
    try:
        frame = read(unity.recv_multipart())
        check_values(frame)
        seen = pictures(frame)
        first, speed, time = next(iter(seen.values())), frame.values["speed"], frame.values["wall_time"]
        throttle, brake, steer = follow_road(first, float(speed))
        action: dict[str, Any] = {"frame": frame.id, "throttle": throttle, "brake": brake, "steer": steer}
        unity.send_multipart(Message("action", frame.id, action).frames())
    except MessageError as error:
        why = {"code": error.code, "text": error.text}
        unity.send_multipart(Message("error", error.id or frame.id, why).frames())
        return
    # Red and blue change places: what OpenCV reads from the file, blue first, LeRobot takes for red first.
    images = {name: base64.b64encode(encode(picture[:, :, ::-1])).decode() for name, picture in seen.items()}
    lerobot.send_string(json.dumps({"timestamps": dict.fromkeys(seen, time), "images": images}))


def main() -> None:
    parser = argparse.ArgumentParser(description="Publishes what a Unity camera sees for LeRobot's ZMQCamera.")
    parser.add_argument("--endpoint", default=UNITY, help="where Unity connects")
    parser.add_argument("--publish", default=LEROBOT, help="where LeRobot connects")
    options = parser.parse_args()
    # SIGTERM, which kill and process managers send, ends it as Ctrl-C does; on Windows that is SIGBREAK.
    signal.signal(getattr(signal, "SIGBREAK", signal.SIGTERM), signal.default_int_handler)
    with zmq.Context() as context, context.socket(zmq.REP) as unity, context.socket(zmq.PUB) as lerobot:
        # Old pictures are worth nothing, and a reply that nobody fetches even less.
        unity.linger = lerobot.linger = 0
        lerobot.sndhwm, unity.maxmsgsize = 2, 4 * LIMIT
        try:
            lerobot.bind(options.publish)
            unity.bind(options.endpoint)
        except zmq.ZMQError as error:
            sys.exit(f"cannot listen on {options.endpoint} and {options.publish}: {error}; try other ports")
        print(f"publishing on {lerobot.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        print(f"listening on {unity.getsockopt_string(zmq.LAST_ENDPOINT)}", flush=True)
        while True:
            # In slices: on Windows Ctrl-C does not interrupt a longer wait.
            if unity.poll(200):
                bridge(unity, lerobot)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
