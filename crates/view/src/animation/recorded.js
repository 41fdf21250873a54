// A motion that was recorded before.

install(JSON.parse(root.querySelector("script[type='application/json']").textContent));
start();
