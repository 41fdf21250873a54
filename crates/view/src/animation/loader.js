// Script and style sheet of a simulated page are compressed: this script unpacks and starts them.

const root = document.currentScript.closest(".qrm-animation");
/** What the page holds. */
root.packed = JSON.parse(root.querySelector("script[type='application/json']").textContent);

/** The values of the digits of base 85: printable signs but those that HTML or JSON would escape. */
const VALUES = new Map(
  [...Array(94)].map((_, i) => String.fromCharCode(33 + i)).filter((sign) => !"\"&'<>\\`".includes(sign))
    .map((sign, value) => [sign, value])
);

/** The bytes of a text of digits, five of them for four bytes; a part of a byte at the end does not count. */
function decoded(text) {
  const view = new DataView(new ArrayBuffer(4 * Math.ceil(text.length / 5)));
  const values = Uint8Array.from(text, (sign) => VALUES.get(sign));
  for (let place = 0; place < text.length; place += 5) {
    let word = 0;
    for (let digit = place; digit < place + 5; digit++) word = 85 * word + (values[digit] ?? 84);
    view.setUint32((place / 5) * 4, word);
  }
  return new Uint8Array(view.buffer, 0, (text.length * 4) / 5);
}

/** What gzip made of bytes, in base 85. */
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
