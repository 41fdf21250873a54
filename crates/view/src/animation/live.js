// A scene that a server has, and again whenever its file changes.

/** The versions of what the page has. */
let known = { version: 0, scene: 0 };
let noteShown = "";
let isGone = false;

function apply(news) {
  known = { version: news.version, scene: news.scene_version };
  setText("mistake", news.problem ?? "");
  if (noteShown !== (news.note ?? "")) setText("news", (noteShown = news.note ?? ""));
  if (news.scene) waiting = news.scene;
  if (!pressed?.move) showWaiting();
}

/** The scene of the file that is not shown yet. */
let waiting = null;

/** Shows the scene of the file. While a point is moved, the scene before it follows the values of the file. */
function showWaiting() {
  if (!waiting) return;
  for (const name of followed) delete changed[name];
  followed.clear();
  load(waiting).then(sceneShown);
  waiting = null;
}

const delay = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
let request = new AbortController();

/** Waits until the page can be seen: browsers allow few connections, which hidden pages leave to others. */
async function untilVisible() {
  while (document.hidden) await new Promise((done) => document.addEventListener("visibilitychange", done, { once: true }));
}
document.addEventListener("visibilitychange", () => {
  if (document.hidden) request.abort();
});

/** The answer to a request for news; null without one. */
async function nextNews() {
  request = new AbortController();
  try {
    const answer = await fetch(`news?${new URLSearchParams(known)}`, { signal: request.signal });
    // Another server at this port does not know the address.
    isGone = [403, 404].includes(answer.status);
    if (!answer.ok) await delay(500);
    return answer.status === 200 ? await answer.json() : null;
  } catch {
    isGone = !request.signal.aborted;
    if (isGone) await delay(500);
    return null;
  }
}

(async () => {
  for (;;) {
    await untilVisible();
    const wasGone = isGone;
    const news = await nextNews();
    if (isGone) setText("news", "qrm live has ended; the page goes on without it");
    else if (wasGone) setText("news", noteShown);
    if (news) apply(news);
  }
})();

part("write").hidden = !packed.is_writable;
part("write").addEventListener("click", async () => {
  const values = { ...changed };
  const lines = Object.entries(values).map(([name, value]) => `${name}=${value}`);
  let said = "";
  written = values;
  try {
    const answer = await fetch("values", { method: "POST", body: lines.join("\n") });
    said = await answer.text();
    setText("news", answer.ok ? said : noteShown);
    if (!answer.ok) setText("problem", said);
  } catch (problem) {
    setText("problem", `the values were not written: ${problem.message}`);
  }
  await delay(4000);
  if (part("news").textContent === said) setText("news", noteShown);
});
