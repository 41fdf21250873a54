// The simulator: a module of WebAssembly that takes a scene and computes its motion.

/** The digits of base 85: printable signs but those that HTML or JSON would escape. */
const DIGITS = Array.from({ length: 94 }, (_, place) => String.fromCharCode(33 + place)).filter((sign) => !"\"&'<>\\`".includes(sign));
const VALUES = new Map(DIGITS.map((sign, value) => [sign.charCodeAt(0), value]));

/** The bytes of a text of digits, five of them for four bytes. */
function decoded(text) {
  const view = new DataView(new ArrayBuffer(4 * Math.ceil(text.length / 5)));
  const values = Uint8Array.from(text, (sign) => VALUES.get(sign.charCodeAt(0)));
  for (let place = 0; place < text.length; place += 5) {
    let word = 0;
    for (let digit = place; digit < place + 5; digit++) word = 85 * word + (values[digit] ?? 84);
    view.setUint32((place / 5) * 4, word);
  }
  return new Uint8Array(view.buffer, 0, Math.floor((text.length * 4) / 5));
}

/** What gzip made of bytes, in base 85. */
async function unpacked(text) {
  const stream = new Blob([decoded(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** An instance of the module. Each scene has one of its own, so that nothing is left of the scene before it. */
async function simulator(module) {
  const instance = await WebAssembly.instantiate(module, {});
  const { memory, reserve, output, output_length, load, run, draft, drag } = instance.exports;
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
    /** The start at which points, each with its weight, are nearest to a place; the search starts at the pose of a time. */
    drag: (time, x, y, points) => call(() => drag(time, x, y), lines(points)),
  };
}
