//! The names, units and descriptions of a mechanism's numbers.

/// Names, units and descriptions of a mechanism's numbers.
#[derive(Clone, Copy, Debug)]
pub struct Description {
    /// The scene's name.
    pub name: &'static str,
    /// The description of the scene.
    pub doc: &'static str,
    /// The text the mechanism was generated from.
    pub source: &'static str,
    /// The derivation of the equations of motion: Markdown with LaTeX.
    pub derivation: &'static str,
    /// Generalized coordinates, in the order of q.
    pub coordinates: &'static [QuantityDescription],
    /// Constraints, in the order of the multipliers.
    pub constraints: &'static [QuantityDescription],
    /// Outputs.
    pub outputs: &'static [QuantityDescription],
    /// Parameters that can be set.
    pub parameters: &'static [ParameterDescription],
    /// Parameters that are exactly zero in the scene: the generated code omits them.
    pub left_out: &'static [&'static str],
    /// Whether a load has a corner or a jump: steps across it have a low order.
    pub has_corners: bool,
    /// The joints and loads whose friction depends on a joint force, in words.
    pub friction: &'static [&'static str],
    /// The stop condition as written; empty if there is none.
    pub until: &'static str,
}

impl Description {
    /// Whether a coordinate is an angle: its unit is `rad`.
    #[must_use]
    pub fn is_angle(&self, coordinate: usize) -> bool {
        self.coordinates[coordinate].unit == "rad"
    }

    /// Whether the code was generated from this text. Crates that compile a copy of generated code can check this at
    /// compile time.
    ///
    /// ```ignore
    /// const _: () = assert!(wiper::DESCRIPTION.is_of(include_str!("../wiper.toml")), "generate the code again");
    /// ```
    #[must_use]
    pub const fn is_of(&self, source: &str) -> bool {
        let (ours, theirs) = (self.source.as_bytes(), source.as_bytes());
        if ours.len() != theirs.len() {
            return false;
        }
        let mut i = 0;
        while i < ours.len() && ours[i] == theirs[i] {
            i += 1;
        }
        i == ours.len()
    }
}

/// A named number.
#[derive(Clone, Copy, Debug)]
pub struct QuantityDescription {
    /// The name of the quantity.
    pub name: &'static str,
    /// The unit of the quantity.
    pub unit: &'static str,
    /// The description of the quantity.
    pub doc: &'static str,
}

/// A parameter.
#[derive(Clone, Copy, Debug)]
pub struct ParameterDescription {
    /// The name of the parameter.
    pub name: &'static str,
    /// The unit of the parameter.
    pub unit: &'static str,
    /// The description of the parameter.
    pub doc: &'static str,
    /// The value of the parameter, as the scene writes it.
    pub formula: &'static str,
}
