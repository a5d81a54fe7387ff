// Lesson 01's server in Go with pebbe/zmq4: answers Hello with World, and anything else with a text that begins with
// error:.
//
//	go mod init hello
//	go get github.com/pebbe/zmq4
//	go run server.go [ENDPOINT]             port 0 takes a free one; Ctrl-C ends it
package main

import (
	"fmt"
	"os"

	zmq "github.com/pebbe/zmq4"
)

func answer(text string) string {
	if text == "Hello" {
		return "World"
	}
	// %q escapes unprintable characters, and puts it into double quotes.
	shown := fmt.Sprintf("%.40q", text)
	return fmt.Sprintf("error: expected Hello, got '%s'", shown[1:len(shown)-1])
}

func main() {
	endpoint := append(os.Args, "tcp://127.0.0.1:5551")[1]
	socket, _ := zmq.NewSocket(zmq.REP)
	socket.SetMaxmsgsize(65536) // A peer that announces more is disconnected.
	if err := socket.Bind(endpoint); err != nil {
		fmt.Fprintf(os.Stderr, "cannot listen on %s: %v; try tcp://127.0.0.1:0, which takes a free port\n", endpoint, err)
		os.Exit(1)
	}
	place, _ := socket.GetLastEndpoint()
	fmt.Println("listening on", place)
	for {
		// REP may not send before it has read every frame, as RecvMessage does.
		request, _ := socket.RecvMessage(0)
		socket.Send(answer(request[0]), 0)
	}
}
