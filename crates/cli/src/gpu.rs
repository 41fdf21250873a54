//! Designs in the lanes of a GPU, in programs with the feature `gpu`.

#[cfg(feature = "gpu")]
mod cuda;
#[cfg(feature = "gpu")]
mod lane_steps;

use clap::ValueEnum;
use qrm_sim::batch::Device;

use crate::error::{Error, Message};
use crate::setup::Setup;

/// The processor that runs the designs of a sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Processor {
    /// The cores of this machine
    #[default]
    Cpu,
    /// A GPU with CUDA; the cores take designs that need a closer look
    Gpu,
}

impl Processor {
    /// The processor of this name.
    pub fn named(name: &str) -> Result<Self, Error> {
        <Self as ValueEnum>::from_str(name, false)
            .map_err(|_| Error::usage(format!("there is no device `{name}`")).help("choose `cpu` or `gpu`"))
    }
}

/// A GPU that runs the designs of a scene.
pub(crate) trait Gpu: Device {
    /// The name of the GPU.
    fn name(&self) -> &str;

    /// The number of lanes of a batch.
    fn lanes(&self) -> usize;

    /// A warning that the GPU failed, so that the cores ran the remaining designs.
    fn failure(&self) -> Option<Message>;
}

/// Finds a GPU for designs of a scene. `size` is their number, and the number of threads that share the GPU.
pub(crate) fn find(setup: &Setup, size: (usize, usize)) -> Result<Box<dyn Gpu>, Error> {
    if !setup.settings.method.has_lanes() {
        let name = setup.settings.method.name;
        return Err(Error::usage(format!("a GPU makes no steps of the method `{name}`"))
            .help("leave out `--method`, or `--device gpu`"));
    }
    open(setup, size)
}

#[cfg(feature = "gpu")]
fn open(setup: &Setup, size: (usize, usize)) -> Result<Box<dyn Gpu>, Error> {
    Ok(Box::new(cuda::CudaGpu::open(setup, size)?))
}

#[cfg(not(feature = "gpu"))]
fn open(_: &Setup, _: (usize, usize)) -> Result<Box<dyn Gpu>, Error> {
    Err(Error::usage("this program was built without GPUs")
        .help("build it with the feature `gpu` (`cargo install --path . --features gpu`)"))
}
