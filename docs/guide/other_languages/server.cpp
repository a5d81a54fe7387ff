// Lesson 01's server in C++ with cppzmq: answers Hello with World, and anything else with a text that begins
// with error:.
//
//     c++ -std=c++17 server.cpp -o server -lzmq
//     ./server [ENDPOINT]             port 0 takes a free one; Ctrl-C ends it
#include <algorithm>
#include <iostream>
#include <zmq_addon.hpp>

std::string answer(std::string text) {
    std::replace_if(text.begin(), text.end(), [](unsigned char c) { return !std::isprint(c); }, '?');
    return text == "Hello" ? "World" : "error: expected Hello, got '" + text.substr(0, 40) + "'";
}

int main(int argc, char** argv) {
    const std::string endpoint = argc > 1 ? argv[1] : "tcp://127.0.0.1:5551";
    zmq::context_t context;
    zmq::socket_t socket(context, zmq::socket_type::rep);
    socket.set(zmq::sockopt::linger, 0);
    // A peer that announces more than the largest message is disconnected.
    socket.set(zmq::sockopt::maxmsgsize, std::int64_t{65536});
    try {
        socket.bind(endpoint);
    } catch (const zmq::error_t& error) {
        std::cerr << "cannot listen on " << endpoint << ": " << error.what()
                  << "; try tcp://127.0.0.1:0, which takes a free port\n";
        return 1;
    }
    std::cout << "listening on " << socket.get(zmq::sockopt::last_endpoint) << std::endl;
    std::vector<zmq::message_t> request;
    // REP may not send before it has read every frame.
    for (; zmq::recv_multipart(socket, std::back_inserter(request)); request.clear())
        socket.send(zmq::buffer(answer(request[0].to_string())));
}
