// Lesson 01's server in JavaScript with zeromq.js: answers Hello with World, and anything else with a text that begins
// with error:.
//
//     npm install zeromq@6
//     node server.mjs [ENDPOINT]             port 0 takes a free one; Ctrl-C ends it
import { Reply } from "zeromq"

const printable = (text) => text.slice(0, 40).replace(/[^\p{L}\p{M}\p{N}\p{P}\p{S} ]/gu, "?")
const answer = (text) => (text === "Hello" ? "World" : `error: expected Hello, got '${printable(text)}'`)

const endpoint = process.argv[2] ?? "tcp://127.0.0.1:5551"
// A peer that announces more than the largest message is disconnected.
const socket = new Reply({ linger: 0, maxMessageSize: 65536 })
try {
  await socket.bind(endpoint)
} catch (error) {
  console.error(`cannot listen on ${endpoint}: ${error.message}; try tcp://127.0.0.1:0, which takes a free port`)
  process.exit(1)
}
console.log(`listening on ${socket.lastEndpoint}`)
for await (const [request] of socket) await socket.send(answer(request.toString()))
