// Lesson 01's client in JavaScript with zeromq.js: says Hello ten times, and waits 2.5 s at most for each World.
//
//     npm install zeromq@6
//     node client.mjs [ENDPOINT]
import { Request } from "zeromq"

// The reply may hold anything: only letters, marks, numbers, punctuation, symbols and spaces are shown.
const printable = (text) => text.slice(0, 200).replace(/[^\p{L}\p{M}\p{N}\p{P}\p{S} ]/gu, "?")

const endpoint = process.argv[2] ?? "tcp://127.0.0.1:5551"
// Linger 0: a message that nobody fetched is dropped at the end.
const socket = new Request({ linger: 0, maxMessageSize: 65536, receiveTimeout: 2500, sendTimeout: 0 })
try {
  socket.connect(endpoint)
  console.log(`asking ${endpoint}`)
  for (let i = 1; i <= 10; i++) {
    await socket.send("Hello")
    const [reply] = await socket.receive()
    console.log(`${i}: sent Hello, received ${printable(reply.toString())}`)
  }
  console.log("done: 10 replies")
} catch (error) {
  const late = error.code === "EAGAIN"
  if (late) console.error(`gave up: no reply from ${endpoint} within 2.5 s; is the server running?`)
  else console.error(`bad endpoint '${endpoint}': ${error.message}; write it like tcp://127.0.0.1:5551`)
  process.exitCode = late ? 1 : 2
}
