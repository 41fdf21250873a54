//! A kernel under construction.

use std::collections::HashMap;

use super::block::Block;
use crate::graph::{Id, Signed};
use crate::lower::Lowering;
use qrm_scene::scene::Scene;

/// A named value.
#[derive(Clone, Debug)]
pub struct Local {
    /// The name of the value.
    pub name: String,
    /// The value.
    pub value: Signed,
    /// The input that represents the value in later operations.
    pub input: Signed,
    /// The block to which the value belongs.
    pub block: Block,
}

/// A kernel under construction.
pub(super) struct Builder<'s> {
    pub(super) scene: &'s Scene,
    pub(super) lowering: &'s mut Lowering,
    pub(super) locals: Vec<Local>,
    /// The index of the local with a given value.
    pub(super) by_value: HashMap<Id, usize>,
    /// The value that a local's input represents.
    pub(super) definitions: HashMap<Id, Id>,
    /// The number of the next local.
    pub(super) next: usize,
    /// Whether later operations use values directly instead of inputs.
    pub(super) is_inline: bool,
}

impl<'s> Builder<'s> {
    pub(super) fn new(scene: &'s Scene, lowering: &'s mut Lowering, next: usize, is_inline: bool) -> Self {
        let (by_value, definitions) = (HashMap::new(), HashMap::new());
        Self { scene, lowering, locals: Vec::new(), by_value, definitions, next, is_inline }
    }
}
