// The browser's half of BrowserConnection.cs. Unity's compiler for the web, Emscripten, adds these functions to the game;
// a text goes as the address of its bytes in the game's memory.
mergeInto(LibraryManager.library, {
  $KitWeb: {
    connections: [],
    // Unity frees what it is given here; 0 is null.
    toUnity: function (text) {
      if (text === null || text === undefined) return 0;
      var size = lengthBytesUTF8(text) + 1;
      var at = _malloc(size);
      stringToUTF8(text, at, size);
      return at;
    },
  },

  KitWebOpen__deps: ["$KitWeb"],
  KitWebOpen: function (address) {
    var connection = { received: [], closed: null, socket: null };
    try {
      connection.socket = new WebSocket(UTF8ToString(address));
      connection.socket.onmessage = function (event) {
        // The gateway answers what it is asked: who sends more than this at once is no gateway.
        if (connection.received.length > 64) connection.socket.close();
        else connection.received.push(event.data);
      };
      connection.socket.onclose = function (event) {
        // A page is not told why it was refused: the browser writes it into its console.
        connection.closed = event.reason || "the gateway is away, or has refused; see the browser's console";
      };
    } catch (error) {
      // Such as a ws:// address in a page that came by https.
      connection.closed = String(error);
    }
    return KitWeb.connections.push(connection) - 1;
  },

  KitWebIsOpen__deps: ["$KitWeb"],
  KitWebIsOpen: function (number) {
    var connection = KitWeb.connections[number];
    return connection.closed === null && connection.socket.readyState === 1 ? 1 : 0;
  },

  KitWebClosed__deps: ["$KitWeb"],
  KitWebClosed: function (number) {
    return KitWeb.toUnity(KitWeb.connections[number].closed);
  },

  KitWebSend__deps: ["$KitWeb"],
  KitWebSend: function (number, text) {
    var socket = KitWeb.connections[number].socket;
    if (socket && socket.readyState === 1) socket.send(UTF8ToString(text));
  },

  KitWebReceive__deps: ["$KitWeb"],
  KitWebReceive: function (number) {
    return KitWeb.toUnity(KitWeb.connections[number].received.shift());
  },

  KitWebClose__deps: ["$KitWeb"],
  KitWebClose: function (number) {
    var socket = KitWeb.connections[number].socket;
    // Its number is never given again, and nothing of it is kept.
    KitWeb.connections[number] = { received: [], closed: "closed", socket: null };
    if (socket) socket.onmessage = socket.onclose = null;
    if (socket) socket.close();
  },
});
