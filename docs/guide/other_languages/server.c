// Lesson 01's server in C with CZMQ: answers Hello with World, and anything else with a text that begins with error:.
//
//     cc server.c -o server -lczmq -lzmq
//     ./server [ENDPOINT]             port 0 takes a free one; Ctrl-C ends it
#include <czmq.h>

int main(int argc, char **argv) {
    const char *endpoint = argc > 1 ? argv[1] : "tcp://127.0.0.1:5551";
    zsys_handler_set(NULL); // Otherwise CZMQ catches Ctrl-C, and the program would have to ask for it.
    zsock_t *socket = zsock_new(ZMQ_REP);
    zsock_set_maxmsgsize(socket, 65536); // A peer that announces more is disconnected.
    if (zsock_bind(socket, "%s", endpoint) < 0) {
        const char *why = zmq_strerror(zmq_errno());
        fprintf(stderr, "cannot listen on %s: %s; try tcp://127.0.0.1:0, which takes a free port\n", endpoint, why);
        zsock_destroy(&socket);
        return 1;
    }
    printf("listening on %s\n", zsock_last_endpoint(socket));
    fflush(stdout); // In a pipe, too, the line is there at once.
    for (;;) {
        char *request;
        zstr_recvx(socket, &request, NULL); // The first frame, and it reads the others.
        for (char *c = request; *c; c++)
            *c = isprint((unsigned char) *c) ? *c : '?';
        if (streq(request, "Hello"))
            zstr_send(socket, "World");
        else
            zstr_sendf(socket, "error: expected Hello, got '%.40s'", request);
        zstr_free(&request);
    }
}
