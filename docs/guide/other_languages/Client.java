// Lesson 01's client in Java with JeroMQ: says Hello ten times, and waits 2.5 s at most for each World.
//
//     java -cp jeromq.jar Client.java [ENDPOINT]
//
// JeroMQ 0.5 and later says that ZMQ.REQ is deprecated: write SocketType.REQ there.
import org.zeromq.ZContext;
import org.zeromq.ZMQ;
import org.zeromq.ZMsg;

public class Client {
    public static void main(String[] args) {
        String endpoint = args.length > 0 ? args[0] : "tcp://127.0.0.1:5551";
        try (ZContext context = new ZContext()) {
            // ZContext sets linger to 0: a message that nobody fetched is dropped at the end.
            ZMQ.Socket socket = context.createSocket(ZMQ.REQ);
            socket.setMaxMsgSize(65536);
            socket.setReceiveTimeOut(2500);
            socket.setSendTimeOut(0);
            socket.connect(endpoint);
            System.out.println("asking " + endpoint);
            for (int i = 1; i <= 10; i++) {
                ZMsg reply = socket.send("Hello") ? ZMsg.recvMsg(socket) : null;
                if (reply == null) {
                    System.err.printf("gave up: no reply from %s within 2.5 s; is the server running?%n", endpoint);
                    System.exit(1);
                }
                String text = new String(reply.pop().getData(), ZMQ.CHARSET);
                // The reply may hold anything: letters, marks, numbers, punctuation, symbols, spaces are shown.
                String shown = text.replaceAll("[^\\p{L}\\p{M}\\p{N}\\p{P}\\p{S} ]", "?");
                System.out.printf("%d: sent Hello, received %.200s%n", i, shown);
            }
            System.out.println("done: 10 replies");
        } catch (RuntimeException e) {
            System.err.printf("bad endpoint '%s': %s; write it like tcp://127.0.0.1:5551%n", endpoint, e.getMessage());
            System.exit(2);
        }
    }
}
