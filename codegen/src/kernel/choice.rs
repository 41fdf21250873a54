//! The choice among the forms of a kernel.

use super::Kernel;
use crate::lower::Lowering;
use crate::term::Equations;
use qrm_scene::scene::{EliminationForm, MANY_COORDINATES, Scene};

/// The kernel of a scene: of the form that was asked for, or of the one with the fewest operations.
pub(crate) struct Choice {
    pub(crate) kernel: Kernel,
    /// The forms that were counted, with their operations before pairs are shared.
    pub(crate) forms: Vec<(EliminationForm, usize)>,
}

/// The equations of a scene do not allow a form of its kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`elimination = \"{}\"` is not possible here", .0.name())]
pub struct ImpossibleForm(pub EliminationForm);

impl Choice {
    /// Creates the kernel in all forms that may be the cheapest. Afterwards `lowering` has the names of the last form.
    ///
    /// # Errors
    /// The form was asked for, and is not possible.
    pub(crate) fn new(
        scene: &Scene,
        equations: &Equations,
        lowering: &mut Lowering,
        asked: Option<EliminationForm>,
    ) -> Result<Self, ImpossibleForm> {
        let mut kernels = Vec::new();
        for form in forms_of(scene, asked) {
            // Names have other values in a kernel, and in each form.
            *lowering = Lowering::from_kernel(std::mem::take(&mut lowering.graph));
            kernels.extend(Kernel::new(scene, equations, lowering, form));
        }
        let count = |kernel: &Kernel| kernel.operations(&lowering.graph);
        let forms = kernels.iter().map(|kernel| (kernel.form, count(kernel))).collect();
        let has_range_space = kernels.iter().any(|kernel| kernel.form == EliminationForm::RangeSpace);
        let cost = |kernel: &Kernel| {
            // The range space is valid wherever the mass matrix is regular.
            let is_limited = has_range_space && !kernel.is_valid_everywhere;
            (is_limited, count(kernel), kernel.form)
        };
        let kernel = match asked {
            Some(form) => kernels.into_iter().find(|kernel| kernel.form == form).ok_or(ImpossibleForm(form))?,
            None => kernels.into_iter().min_by_key(cost).expect("the null space is possible without the sparse form"),
        };
        Ok(Self { kernel, forms })
    }
}

/// The forms of a kernel that are counted.
fn forms_of(scene: &Scene, asked: Option<EliminationForm>) -> impl Iterator<Item = EliminationForm> {
    let has_range_space = !scene.constraints.is_empty()
        && (scene.coordinates.len() > MANY_COORDINATES || asked == Some(EliminationForm::RangeSpace));
    let range_space = has_range_space.then_some(EliminationForm::RangeSpace);
    [EliminationForm::Sparse, EliminationForm::NullSpace].into_iter().chain(range_space)
}
