//! Parts of a scene in words, their formulae as the scene writes them.

use qrm_scene::scene::{Body, LoadKind, Value};

/// Words about one scene.
#[derive(Clone, Copy, Debug)]
pub struct Words<'s> {
    /// The scene's text.
    pub source: &'s str,
}

impl Words<'_> {
    /// A formula.
    pub fn formula(&self, value: &Value) -> String {
        let text = self.source.get(value.whole_span()).unwrap_or_default();
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// A place or a direction: the name of a point, or two formulae.
    pub fn pair(&self, [x, y]: &[Value; 2]) -> String {
        // Both coordinates of a named point stand at its name.
        if x.whole_span() == y.whole_span() {
            self.formula(x)
        } else {
            format!("({}, {})", self.formula(x), self.formula(y))
        }
    }

    /// Where a body is and what it carries.
    pub fn body(&self, body: &Body) -> String {
        let place = body.com.as_ref().map(|com| format!("centre of mass `{}`", self.pair(com)));
        let formula =
            |what: &str, value: &Option<Value>| value.as_ref().map(|v| format!("{what} `{}`", self.formula(v)));
        let facts =
            [formula("mass", &body.mass), place, formula("angle", &body.angle), formula("inertia", &body.inertia)];
        facts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// What a load does.
    pub fn load(&self, load: &LoadKind) -> String {
        match load {
            LoadKind::Force { force, at } => format!("force `{}` at `{}`", self.pair(force), self.pair(at)),
            LoadKind::Torque { torque, angle } => {
                format!("torque `{}` along the angle `{}`", self.formula(torque), self.formula(angle))
            }
            LoadKind::Gravity(field) => format!("gravity `{}`", self.pair(field)),
            LoadKind::Spring { along, stiffness, rest, damping, potential, force, friction } => {
                let mut parts = Vec::new();
                if let Some(stiffness) = stiffness {
                    let rest =
                        rest.as_ref().map_or_else(String::new, |rest| format!(", slack at `{}`", self.formula(rest)));
                    parts.push(format!("spring `{}`{rest}", self.formula(stiffness)));
                }
                let said = [("damper", damping), ("potential", potential), ("force", force)];
                let said = said
                    .into_iter()
                    .filter_map(|(what, value)| Some(format!("{what} `{}`", self.formula(value.as_ref()?))));
                parts.extend(said);
                parts.extend(friction.as_ref().map(|(size, slip)| {
                    format!("friction `{}` beyond the speed `{}`", self.formula(size), self.formula(slip))
                }));
                let place = self.formula(along);
                // Between two points their names stand side by side.
                let between = place
                    .split_once(',')
                    .filter(|_| place.starts_with(|c: char| c.is_alphabetic()) && !place.contains('('));
                match between {
                    Some(_) => format!("{} between `{}`", parts.join(", "), place.replace(['"', '\''], "")),
                    None => format!("{} along `{place}`", parts.join(", ")),
                }
            }
        }
    }
}
