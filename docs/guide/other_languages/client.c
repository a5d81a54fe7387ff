// Lesson 01's client in C with CZMQ: says Hello ten times, and waits 2.5 s at most for each World.
//
//     cc client.c -o client -lczmq -lzmq
//     ./client [ENDPOINT]
#include <czmq.h>

int main(int argc, char **argv) {
    const char *endpoint = argc > 1 ? argv[1] : "tcp://127.0.0.1:5551";
    setvbuf(stdout, NULL, _IOLBF, 0); // In a pipe, too, each line is there at once.
    zsys_handler_set(NULL); // Otherwise CZMQ catches Ctrl-C, and the program would have to ask for it.
    zsock_t *socket = zsock_new(ZMQ_REQ); // CZMQ sets linger to 0: a message that nobody fetched is dropped at the end.
    zsock_set_maxmsgsize(socket, 65536);
    zsock_set_rcvtimeo(socket, 2500);
    zsock_set_sndtimeo(socket, 0);
    if (zsock_connect(socket, "%s", endpoint)) {
        fprintf(stderr, "bad endpoint '%s': write it like tcp://127.0.0.1:5551\n", endpoint);
        zsock_destroy(&socket);
        return 2;
    }
    printf("asking %s\n", endpoint);
    int replies = 0;
    char *reply;
    while (replies < 10 && !zstr_send(socket, "Hello") && zstr_recvx(socket, &reply, NULL) > 0) {
        // The reply may hold anything: only printable ASCII goes to the terminal.
        for (char *c = reply; *c; c++)
            *c = isprint((unsigned char) *c) ? *c : '?';
        printf("%d: sent Hello, received %.200s\n", ++replies, reply);
        zstr_free(&reply);
    }
    if (replies == 10)
        puts("done: 10 replies");
    else
        fprintf(stderr, "gave up: no reply from %s within 2.5 s; is the server running?\n", endpoint);
    zsock_destroy(&socket);
    return replies == 10 ? 0 : 1;
}
