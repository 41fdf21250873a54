// The simulator: a module of WebAssembly that takes a scene and computes its motion.

/** What gzip made of bytes, in base64. */
async function unpacked(base64) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** An instance of the module. Each scene has one of its own, so that nothing is left of the scene before it. */
async function simulator(module) {
  const instance = await WebAssembly.instantiate(module, {});
  const { memory, reserve, output, output_length, load, run, drag } = instance.exports;
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
  const lines = (values) => {
    const pairs = Object.entries(values).map(([name, value]) => `${name}=${value}`);
    return new TextEncoder().encode(pairs.join("\n"));
  };
  return {
    load: (scene) => call(load, scene),
    /** A draft needs to know about when the motion ends; a run that is none has an estimate of its error. */
    run: (values, draftEnd) => call(() => run(draftEnd), lines(values)),
    /** The start at which points, each with its weight, are nearest to a place; it is sought from the pose of a time. */
    drag: (time, x, y, points) => call(() => drag(time, x, y), lines(points)),
  };
}
