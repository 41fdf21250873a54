//! A kernel under construction.

use std::collections::HashMap;

use super::block::Block;
use crate::graph::{Id, Signed};
use crate::lower::Lowering;
use qrm_scene::scene::Scene;

/// A value with a name.
#[derive(Clone, Debug)]
pub struct Local {
    /// The name of the value.
    pub name: String,
    /// How it is computed.
    pub value: Signed,
    /// The input that stands for the value in later operations.
    pub input: Signed,
    /// The part of the computation that the value belongs to.
    pub block: Block,
}

/// A kernel under construction.
pub(super) struct Builder<'s> {
    pub(super) scene: &'s Scene,
    pub(super) lowering: &'s mut Lowering,
    pub(super) locals: Vec<Local>,
    /// The place of the local that is computed as a value.
    pub(super) by_value: HashMap<Id, usize>,
    /// The value that a local's input stands for.
    pub(super) definitions: HashMap<Id, Id>,
    /// The number of the next local.
    pub(super) next: usize,
    /// Whether values stand for themselves in later operations.
    pub(super) is_inline: bool,
}

impl<'s> Builder<'s> {
    pub(super) fn new(scene: &'s Scene, lowering: &'s mut Lowering, next: usize, is_inline: bool) -> Self {
        let (by_value, definitions) = (HashMap::new(), HashMap::new());
        Self { scene, lowering, locals: Vec::new(), by_value, definitions, next, is_inline }
    }
}
