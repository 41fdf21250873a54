// A scene that is part of the page.

(async () => {
  try {
    await load(packed.scene);
  } catch (problem) {
    tell("problem", `the motion cannot be computed here: ${problem.message}`);
  }
})();
