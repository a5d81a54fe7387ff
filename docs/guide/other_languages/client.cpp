// Lesson 01's client in C++ with cppzmq: says Hello ten times, and waits 2.5 s at most for each World.
//
//     c++ -std=c++17 client.cpp -o client -lzmq
//     ./client [ENDPOINT]
#include <algorithm>
#include <iostream>
#include <zmq_addon.hpp>

int main(int argc, char** argv) try {
    const std::string endpoint = argc > 1 ? argv[1] : "tcp://127.0.0.1:5551";
    zmq::context_t context;
    zmq::socket_t socket(context, zmq::socket_type::req);
    socket.set(zmq::sockopt::linger, 0);  // A message that nobody fetched is dropped at the end.
    socket.set(zmq::sockopt::maxmsgsize, std::int64_t{65536});
    socket.set(zmq::sockopt::rcvtimeo, 2500);
    socket.set(zmq::sockopt::sndtimeo, 0);
    socket.connect(endpoint);
    std::cout << "asking " << endpoint << std::endl;
    for (int i = 1; i <= 10; i++) {
        std::vector<zmq::message_t> reply;
        if (!socket.send(zmq::str_buffer("Hello")) || !zmq::recv_multipart(socket, std::back_inserter(reply))) {
            std::cerr << "gave up: no reply from " << endpoint << " within 2.5 s; is the server running?\n";
            return 1;
        }
        std::string text = reply[0].to_string().substr(0, 200);
        // The reply may hold anything: only printable ASCII goes to the terminal.
        std::replace_if(text.begin(), text.end(), [](unsigned char c) { return !std::isprint(c); }, '?');
        std::cout << i << ": sent Hello, received " << text << std::endl;
    }
    std::cout << "done: 10 replies\n";
} catch (const zmq::error_t& error) {
    std::cerr << "bad endpoint '" << argv[argc - 1] << "': " << error.what()
              << "; write it like tcp://127.0.0.1:5551\n";
    return 2;
}
