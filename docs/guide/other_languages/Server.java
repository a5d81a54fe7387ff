// Lesson 01's server in Java with JeroMQ: answers Hello with World, and anything else with a text that begins
// with error:.
//
//     java -cp jeromq.jar Server.java [ENDPOINT]             port 0 takes a free one; Ctrl-C ends it
//
// JeroMQ 0.5 and later says that ZMQ.REP is deprecated: write SocketType.REP there.
import org.zeromq.ZContext;
import org.zeromq.ZMQ;
import org.zeromq.ZMsg;

public class Server {
    static String answer(String text) {
        String shown = text.replaceAll("[^\\p{L}\\p{M}\\p{N}\\p{P}\\p{S} ]", "?");
        return text.equals("Hello") ? "World" : String.format("error: expected Hello, got '%.40s'", shown);
    }

    public static void main(String[] args) {
        String endpoint = args.length > 0 ? args[0] : "tcp://127.0.0.1:5551";
        try (ZContext context = new ZContext()) {
            ZMQ.Socket socket = context.createSocket(ZMQ.REP);
            socket.setMaxMsgSize(65536); // A peer that announces more is disconnected.
            String place = endpoint.replaceFirst(":[0*]$", "");
            if (place.equals(endpoint)) {
                socket.bind(endpoint);
            } else {
                place += ":" + socket.bindToRandomPort(place);
            }
            System.out.println("listening on " + place);
            while (true) {
                // REP may not send before it has read every frame.
                socket.send(answer(new String(ZMsg.recvMsg(socket).pop().getData(), ZMQ.CHARSET)));
            }
        } catch (RuntimeException e) {
            System.err.printf("cannot listen on %s: %s, taken or not of this machine; "
                + "try tcp://127.0.0.1:0, which takes a free port%n", endpoint, e.getMessage());
            System.exit(1);
        }
    }
}
