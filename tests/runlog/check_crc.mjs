// Reads MCAP files with @mcap/core, every checksum on; prints per file how many messages each topic has and a digest.
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { FileHandleReadable } from "@mcap/nodejs";
import { decompress } from "fzstd";
import { createHash } from "node:crypto";
import { open, readFile } from "node:fs/promises";

const decompressHandlers = { zstd: (buffer, size) => decompress(buffer, new Uint8Array(Number(size))) };

function tally() {
  const topics = new Map();
  return {
    add(topic, message) {
      const entry = topics.get(topic) ?? { count: 0, hash: createHash("sha256") };
      entry.count += 1;
      entry.hash.update(message.data);
      topics.set(topic, entry);
    },
    result() {
      return Object.fromEntries([...topics].map(([topic, e]) => [topic, [e.count, e.hash.digest("hex")]]));
    },
  };
}

async function stream(path) {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  reader.append(await readFile(path));
  const channels = new Map();
  const out = tally();
  const kinds = {};
  for (let record; (record = reader.nextRecord()); ) {
    kinds[record.type] = (kinds[record.type] ?? 0) + 1;
    if (record.type === "Channel") channels.set(record.id, record.topic);
    if (record.type === "Message") out.add(channels.get(record.channelId), record);
  }
  return { topics: out.result(), done: reader.done(), kinds };
}

async function indexed(path) {
  const readable = new FileHandleReadable(await open(path, "r"));
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const out = tally();
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    out.add(reader.channelsById.get(message.channelId).topic, message);
  }
  const attachments = [];
  for await (const item of reader.readAttachments({ validateCrcs: true })) attachments.push(item.name);
  const metadata = [];
  for await (const item of reader.readMetadata()) metadata.push(item.name);
  return {
    topics: out.result(),
    attachments,
    metadata,
    schemas: [...reader.schemasById.values()].map((schema) => schema.name),
    messages: Number(reader.statistics.messageCount),
  };
}

const results = {};
for (const path of process.argv.slice(2)) results[path] = { stream: await stream(path), indexed: await indexed(path) };
console.log(JSON.stringify(results));
