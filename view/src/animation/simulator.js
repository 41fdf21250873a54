// The simulator: a module of WebAssembly that takes a scene and computes its motion.

/** What gzip made of bytes, in base64. */
async function unpacked(base64) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The module of these bytes, ready to be called. */
async function simulator(bytes) {
  const { instance } = await WebAssembly.instantiate(bytes, {});
  const { memory, reserve, output, output_length, load, run } = instance.exports;
  /** The output of a function for some bytes; what it says of a failure is thrown. */
  const call = (work, input) => {
    // The memory may move while it grows.
    const place = reserve(input.length);
    new Uint8Array(memory.buffer, place, input.length).set(input);
    const isDone = work() === 1;
    const text = new TextDecoder().decode(new Uint8Array(memory.buffer, output(), output_length()));
    if (!isDone) throw new Error(text);
    return JSON.parse(text);
  };
  return {
    load: (scene) => call(load, scene),
    run(values, isDraft) {
      const lines = Object.entries(values).map(([name, value]) => `${name}=${value}`);
      return call(() => run(isDraft ? 1 : 0), new TextEncoder().encode(lines.join("\n")));
    },
  };
}
