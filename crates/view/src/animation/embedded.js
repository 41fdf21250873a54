// A scene that is part of the page.

const hint = document.createElement("p");
hint.innerHTML = "To draw links and joints: <code></code>";
hint.lastElementChild.textContent = `qrm live ${packed.command}`;
part("command").after(hint);
load(packed.scene);
