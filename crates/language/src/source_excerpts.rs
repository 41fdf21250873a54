//! Descriptions of parts of a scene, with formulae as written in the scene.

use qrm_scene::scene::{Body, LoadKind, Value};

/// Descriptions of the parts of one scene.
#[derive(Clone, Copy, Debug)]
pub struct SourceExcerpts<'s> {
    /// The scene's text.
    pub source: &'s str,
}

impl SourceExcerpts<'_> {
    /// The text of a formula.
    pub fn formula(&self, value: &Value) -> String {
        let text = self.source.get(value.whole_span()).unwrap_or_default();
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// The text of a position or a direction: the name of a point, or two formulae.
    pub fn pair(&self, [x, y]: &[Value; 2]) -> String {
        // Both coordinates of a named point have the location of its name.
        if x.whole_span() == y.whole_span() {
            self.formula(x)
        } else {
            format!("({}, {})", self.formula(x), self.formula(y))
        }
    }

    /// The description of a body: its position and inertia.
    pub fn body(&self, body: &Body) -> String {
        let place = body.com.as_ref().map(|com| format!("centre of mass `{}`", self.pair(com)));
        let formula =
            |what: &str, value: &Option<Value>| value.as_ref().map(|v| format!("{what} `{}`", self.formula(v)));
        let facts =
            [formula("mass", &body.mass), place, formula("angle", &body.angle), formula("inertia", &body.inertia)];
        facts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// The description of a load.
    pub fn load(&self, load: &LoadKind) -> String {
        load.in_words(&|value| self.formula(value), &|pair| self.pair(pair))
    }
}
