// The simulator: a module of WebAssembly that takes a scene and computes its motion.

/** An instance of the module. Each scene has one of its own, so that nothing is left of the scene before it. */
async function simulator(module) {
  const instance = await WebAssembly.instantiate(module, {});
  const { memory, reserve, output, output_length, load, run, draft, at, drag } = instance.exports;
  let isBroken = false;
  /** The output of a function for some bytes; its message of a failure is thrown. */
  const call = (work, input) => {
    try {
      // The memory may move while it grows.
      const place = reserve(input.length);
      new Uint8Array(memory.buffer, place, input.length).set(input);
      const isDone = work() === 1;
      const text = new TextDecoder().decode(new Uint8Array(memory.buffer, output(), output_length()));
      if (!isDone) throw new Error(text);
      return JSON.parse(text);
    } catch (problem) {
      if (!(problem instanceof WebAssembly.RuntimeError)) throw problem;
      isBroken = true;
      throw new Error(`the simulator stopped: ${problem.message}`);
    }
  };
  const lines = (values) => {
    const pairs = Object.entries(values).map(([name, value]) => `${name}=${value}`);
    return new TextEncoder().encode(pairs.join("\n"));
  };
  return {
    /** Whether a call stopped in the middle: another instance is needed. */
    isBroken: () => isBroken,
    load: (scene) => call(load, scene),
    run: (values) => call(run, lines(values)),
    /** A run by few steps and without an estimate of its error, of a motion that ends at about that time. */
    draft: (values, end) => call(() => draft(end), lines(values)),
    /** The numbers of the last motion at a time, in the order of its tracks. */
    at: (time) => call(() => at(time), []),
    /** The start at which points, each with its weight, are nearest to a place; the search starts at the pose of a time. */
    drag: (time, x, y, points) => call(() => drag(time, x, y), lines(points)),
  };
}
