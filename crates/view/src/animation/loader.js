// Script and style sheet of a simulated page are compressed: this script unpacks and starts them.

const root = document.currentScript.closest(".qrm-animation");
/** What the page holds. */
root.packed = JSON.parse(root.querySelector("script[type='application/json']").textContent);

/** The values of the digits of base 91: printable signs but those that JSON or a script would escape. */
const VALUES = {};
for (let code = 33, value = 0; code < 127; code++) if (![34, 60, 92].includes(code)) VALUES[String.fromCharCode(code)] = value++;

/** The bytes of a text of digits, two of them for 13 or 14 bits. */
function decoded(text) {
  const bytes = new Uint8Array(text.length);
  let [waiting, count, length] = [0, 0, 0];
  for (let place = 0; place < text.length; place += 2) {
    const number = VALUES[text[place]] + 91 * (VALUES[text[place + 1]] ?? 0);
    waiting |= number << count;
    count += place + 1 === text.length ? 8 : (number & 8191) > 88 ? 13 : 14;
    for (; count > 7; count -= 8, waiting >>= 8) bytes[length++] = waiting;
  }
  return bytes.subarray(0, length);
}

/** What gzip made of bytes, in base 91. */
root.unpacked = async (text) => {
  const stream = new Blob([decoded(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

(async () => {
  const text = async (packed) => new TextDecoder().decode(await root.unpacked(packed));
  root.querySelector("style").textContent = await text(root.packed.style);
  const script = document.createElement("script");
  script.append(await text(root.packed.script));
  root.append(script);
})().catch((error) => {
  root.querySelector("style").textContent = "";
  const shown = root.querySelector(".qrm-problem");
  [shown.textContent, shown.hidden] = [`this page cannot start: ${error.message}`, false];
});
