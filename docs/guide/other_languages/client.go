// Lesson 01's client in Go with pebbe/zmq4: says Hello ten times, and waits 2.5 s at most for each World.
//
//	go mod init hello
//	go get github.com/pebbe/zmq4
//	go run client.go [ENDPOINT]
package main

import (
	"fmt"
	"os"
	"time"

	zmq "github.com/pebbe/zmq4"
)

func main() {
	endpoint := append(os.Args, "tcp://127.0.0.1:5551")[1]
	socket, _ := zmq.NewSocket(zmq.REQ)
	socket.SetMaxmsgsize(65536)
	socket.SetRcvtimeo(2500 * time.Millisecond)
	socket.SetSndtimeo(0)
	if err := socket.Connect(endpoint); err != nil {
		fmt.Fprintf(os.Stderr, "bad endpoint '%s': %v; write it like tcp://127.0.0.1:5551\n", endpoint, err)
		os.Exit(2)
	}
	fmt.Println("asking", endpoint)
	for i := 1; i <= 10; i++ {
		socket.Send("Hello", 0)
		reply, err := socket.RecvMessage(0)
		if err != nil {
			fmt.Fprintf(os.Stderr, "gave up: no reply from %s within 2.5 s; is the server running?\n", endpoint)
			os.Exit(1)
		}
		// The reply may hold anything: %q escapes unprintable characters.
		text := fmt.Sprintf("%.200q", reply[0])
		fmt.Printf("%d: sent Hello, received %s\n", i, text[1:len(text)-1])
	}
	fmt.Println("done: 10 replies")
}
