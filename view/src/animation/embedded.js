// A scene that is part of the page.

loadOrReport(packed.scene);
