// A scene that a server has, and again whenever its file changes.

/** What the page knows already. */
let known = { version: 0, scene: 0 };

async function apply(news) {
  known = { version: news.version, scene: news.scene_version };
  setText("mistake", news.problem ?? "");
  setText("news", news.note ?? "");
  if (news.scene) await loadOrReport(news.scene);
}

(async () => {
  for (;;) {
    try {
      const answer = await fetch(`news?${new URLSearchParams(known)}`);
      if (!answer.ok) throw new Error(answer.statusText);
      if (answer.status === 200) await apply(await answer.json());
    } catch (problem) {
      const isGone = problem instanceof TypeError;
      setText("news", isGone ? "qrm live has ended; what is here goes on" : problem.message);
      await new Promise((done) => setTimeout(done, 500));
    }
  }
})();

part("write").hidden = false;
part("write").addEventListener("click", async () => {
  const lines = Object.entries(changed).map(([name, value]) => `${name}=${value}`);
  try {
    const answer = await fetch("values", { method: "POST", body: lines.join("\n") });
    setText(answer.ok ? "news" : "problem", await answer.text());
  } catch (problem) {
    setText("problem", `the values were not written: ${problem.message}`);
  }
});
