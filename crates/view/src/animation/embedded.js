// A scene that is part of the page.

load(packed.scene);
