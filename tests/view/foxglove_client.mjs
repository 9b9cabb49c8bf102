// Reads a live run with Foxglove's own client: node foxglove_client.mjs URL SUBPROTOCOL COUNT
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const [url, subprotocol, count] = process.argv.slice(2);
const client = new protocol.FoxgloveClient({ ws: new WebSocket(url, [subprotocol]) });
const found = { info: null, channels: {}, messages: {} };
const topics = new Map(); // subscription -> topic
client.on("error", (error) => { console.error(String(error)); process.exit(1); });
client.on("serverInfo", (info) => { found.info = info; });
client.on("advertise", (channels) => {
  for (const channel of channels) {
    found.channels[channel.topic] = { encoding: channel.encoding, schemaName: channel.schemaName, schema: channel.schema, schemaEncoding: channel.schemaEncoding };
    topics.set(client.subscribe(channel.id), channel.topic);
    found.messages[channel.topic] = [];
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const topic = topics.get(subscriptionId);
  found.messages[topic].push([String(timestamp), new TextDecoder().decode(data)]);
  if (topic === "/joints" && found.messages[topic].length === Number(count)) {
    process.stdout.write(JSON.stringify(found), () => process.exit(0));
  }
});
