// A scene that is part of the page.

take(packed.scene);
