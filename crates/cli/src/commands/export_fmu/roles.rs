//! The role of each parameter for an importer.

use qrm_scene::expression::Node;
use qrm_scene::resolve::motion_values;
use qrm_scene::scene::Quantity;

use crate::error::Error;
use crate::setup::Setup;

/// The role of a parameter for an importer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// An input that can be connected.
    Input,
    /// A value that can be set at any time.
    Tunable,
    /// A value that can be set before the start.
    Fixed,
    /// A value that follows from other parameters.
    Computed {
        /// Whether at least one of those can be set at any time.
        is_tunable: bool,
    },
}

/// The parameters of a description with their roles.
pub(super) struct Roles {
    pub(super) roles: Vec<(&'static str, Role)>,
    /// Masses and moments of inertia.
    masses: Vec<&'static str>,
}

impl Roles {
    /// Creates the parameters with these roles; `masses` are those that are masses.
    pub(super) fn new(roles: Vec<(&'static str, Role)>, masses: Vec<&'static str>) -> Self {
        Self { roles, masses }
    }

    /// Whether the parameter with this index is a mass or an inertia.
    pub(super) fn is_mass(&self, place: usize) -> bool {
        self.masses.contains(&self.roles[place].0)
    }

    /// Masses and moments of inertia.
    pub(super) fn masses(&self) -> Vec<&'static str> {
        self.masses.clone()
    }

    /// The parameters that follow from others.
    pub(super) fn computed(&self) -> Vec<&'static str> {
        let computed = self.roles.iter().filter(|(_, role)| matches!(role, Role::Computed { .. }));
        computed.map(|(name, _)| *name).collect()
    }

    pub(super) fn inputs(&self) -> Vec<&'static str> {
        self.which(Role::Input)
    }

    pub(super) fn tunable(&self) -> Vec<&'static str> {
        self.which(Role::Tunable)
    }

    pub(super) fn fixed(&self) -> Vec<&'static str> {
        self.which(Role::Fixed)
    }

    fn which(&self, role: Role) -> Vec<&'static str> {
        self.roles.iter().filter(|(_, r)| *r == role).map(|(name, _)| *name).collect()
    }
}

/// Determines the roles: lengths that shape the loops are fixed when the motion begins, and so are parameters that only
/// the start depends on; masses, springs and loads can change at any time.
pub(super) fn roles(setup: &Setup, inputs: &[String]) -> Result<Roles, Error> {
    let scene = &setup.scene;
    let shaping = scene.parameters_of(scene.constraints.iter().map(|c| &c.residual));
    let moving = scene.parameters_of(motion_values(scene));
    let role = |name: &'static str| {
        let Some(i) = scene.parameters.iter().position(|p| p.name == name) else { return Role::Fixed };
        let is_tunable = |i: &usize| !shaping.contains(i) && moving.contains(i);
        let others = scene.parameters_of([&scene.parameters[i].formula]);
        if !others.is_empty() && !setup.set.contains_key(name) {
            return Role::Computed { is_tunable: others.iter().any(is_tunable) };
        }
        if is_tunable(&i) { Role::Tunable } else { Role::Fixed }
    };
    let parameters = setup.description.parameters;
    let is_mass = |name: &str| {
        let values = scene.bodies.iter().flat_map(|body| [&body.mass, &body.inertia]).flatten();
        values.into_iter().any(|value| match value.nodes() {
            [Node::Name(Quantity::Parameter(i))] => scene.parameters[*i].name == name,
            _ => false,
        })
    };
    let mut roles = Roles::new(
        parameters.iter().map(|p| (p.name, role(p.name))).collect(),
        parameters.iter().map(|p| p.name).filter(|name| is_mass(name)).collect(),
    );
    for input in inputs {
        let found = roles.roles.iter_mut().find(|(name, _)| name == input);
        match found {
            Some((_, role @ Role::Tunable)) => *role = Role::Input,
            Some((_, Role::Input)) => {}
            found => return Err(no_input(setup, input, found.map(|(_, role)| *role))),
        }
    }
    Ok(roles)
}

fn no_input(setup: &Setup, input: &str, role: Option<Role>) -> Error {
    let name = setup.description.name;
    let (why, help) = match role {
        None => (
            format!("scene `{name}` has no parameter `{input}`"),
            format!(
                "`qrm list` shows the parameters of \
             `{name}`"
            ),
        ),
        Some(Role::Computed { .. }) => (
            format!("parameter `{input}` follows from others"),
            "connect one of those, or give it a value with \
             --set"
                .to_owned(),
        ),
        Some(_) => (
            format!("parameter `{input}` is settled when the motion begins"),
            "masses, springs and loads can be inputs; lengths that shape the loops, and what the start alone depends \
             on, cannot"
                .to_owned(),
        ),
    };
    Error::usage(format!("`--input {input}`: {why}")).help(help)
}
