"""A gRPC server for the performance lab: one method, whose request and reply are plain bytes."""

from __future__ import annotations

from concurrent import futures

import grpc


def main() -> None:
    unlimited = [("grpc.max_receive_message_length", -1), ("grpc.max_send_message_length", -1)]
    server = grpc.server(futures.ThreadPoolExecutor(max_workers=4), options=unlimited)
    # Without serializers a message is its bytes: what Protocol Buffers would add is not measured.
    echo = grpc.unary_unary_rpc_method_handler(lambda request, context: request)
    server.add_generic_rpc_handlers([grpc.method_handlers_generic_handler("lab", {"Echo": echo})])
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    print(f"listening on tcp://127.0.0.1:{port}", flush=True)
    server.wait_for_termination()


if __name__ == "__main__":
    main()
