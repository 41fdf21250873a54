//! A GPU with CUDA.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use cudarc::driver::{CudaContext, CudaFunction, sys};
use cudarc::nvrtc::{self, CompileError};
use qrm_core::lane_layout::BatchLayout;
use qrm_core::{Batch, BatchRequest, Model};
use qrm_language::{Code, lane_steps};
use qrm_scene::scene::Scene;
use qrm_sim::batch::Device;

use super::Gpu;
use super::lane_steps::{Buffers, CudaLaneSteps, PooledBuffers, of_driver};
use crate::error::{Error, Message};
use crate::setup::Setup;

/// The number of lanes of all cores together: about twice the threads of a large GPU where each uses 255 registers.
const LANES: usize = 65536;
/// The smallest and the largest number of lanes of a batch.
const LANES_OF_BATCH: [usize; 2] = [1024, 16384];

/// A GPU, and the compiled steps of one scene.
pub(super) struct CudaGpu {
    context: Arc<CudaContext>,
    name: String,
    lanes: usize,
    model: &'static Model,
    scene: Arc<Scene>,
    path: String,
    kernels: Mutex<Vec<Kernel>>,
    /// Buffers that no batch uses.
    free: Arc<Mutex<Vec<Buffers>>>,
    /// The first error.
    failure: Arc<OnceLock<String>>,
}

/// Compiled steps.
struct Kernel {
    request: BatchRequest,
    residual: f64,
    function: CudaFunction,
}

impl CudaGpu {
    /// Opens the first GPU.
    pub(super) fn open(setup: &Setup, (designs, threads): (usize, usize)) -> Result<Self, Error> {
        // SAFETY: loading the libraries runs their initialisers, which need nothing.
        #[expect(unsafe_code, reason = "libraries of the driver")]
        let [driver, compiler] = unsafe { [sys::is_culib_present(), nvrtc::sys::is_culib_present()] };
        if !driver {
            return Err(no_gpu("no CUDA driver is installed (`libcuda`)"));
        }
        if !compiler {
            return Err(no_gpu(
                "the run-time compiler of CUDA 11 or 12 is not installed (`libnvrtc`, a part of its toolkit)",
            ));
        }
        let context = CudaContext::new(0).map_err(|error| no_gpu(&of_driver(error)))?;
        let name = context.name().map_err(|error| no_gpu(&of_driver(error)))?;
        Ok(Self {
            context,
            name,
            lanes: lanes(designs, threads),
            model: setup.model,
            scene: Arc::clone(&setup.scene),
            path: setup.path.clone(),
            kernels: Mutex::default(),
            free: Arc::default(),
            failure: Arc::default(),
        })
    }

    /// The compiled steps for these requests. An error is that of all later calls.
    fn kernel(&self, request: BatchRequest, residual: f64) -> Result<CudaFunction, String> {
        let mut kernels = self.kernels.lock().unwrap_or_else(PoisonError::into_inner);
        // Other threads waited while one failed.
        if let Some(reason) = self.failure.get() {
            return Err(reason.clone());
        }
        if let Some(kernel) = kernels.iter().find(|kernel| kernel.request == request && kernel.residual == residual) {
            return Ok(kernel.function.clone());
        }
        let function = self.compile(request, residual).inspect_err(|reason| {
            let _ = self.failure.set(reason.clone());
        })?;
        kernels.push(Kernel { request, residual, function: function.clone() });
        Ok(function)
    }

    /// Writes the steps, and compiles them.
    fn compile(&self, request: BatchRequest, residual: f64) -> Result<CudaFunction, String> {
        let (description, tape) = (self.model.description, self.model.named_tape());
        let code = Code { path: &self.path, scene: &self.scene, source: description.source, tape };
        let layout = BatchLayout::new(description, &request);
        let parameters: Vec<&str> = description.parameters.iter().map(|parameter| parameter.name).collect();
        let text = lane_steps(&code, (&layout, &request), residual, &parameters)
            .map_err(|error| format!("the scene cannot be written in CUDA: {error}"))?;
        let options = nvrtc::CompileOptions { options: vec!["--std=c++17".to_owned()], ..Default::default() };
        let compiled = nvrtc::compile_ptx_with_opts(text, options).map_err(|error| match error {
            CompileError::CompileError { log, .. } => format!("the steps do not compile: {}", log.to_string_lossy()),
            other => format!("the run-time compiler says: {other}"),
        })?;
        self.context.load_module(compiled).and_then(|module| module.load_function("advance")).map_err(of_driver)
    }

    fn try_batch(&self, request: BatchRequest, residual: f64) -> Result<Batch, String> {
        let description = self.model.description;
        let places = BatchLayout::new(description, &request).places();
        let steps = CudaLaneSteps {
            kernel: self.kernel(request, residual)?,
            places,
            buffers: PooledBuffers { buffers: Some(self.buffers(places)?), free: Arc::clone(&self.free) },
            failure: Arc::clone(&self.failure),
        };
        Ok(Batch::new(Box::new(steps), description, request, residual))
    }

    /// Buffers for lanes with this number of places.
    fn buffers(&self, places: usize) -> Result<Buffers, String> {
        let length = places * self.lanes;
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let known =
            free.iter().position(|buffers| buffers.numbers.len() == length).map(|place| free.swap_remove(place));
        drop(free);
        match known {
            Some(buffers) => Ok(buffers),
            None => Buffers::new(&self.context, length).map_err(of_driver),
        }
    }
}

impl Device for CudaGpu {
    fn batch(&self, request: BatchRequest, residual: f64) -> Option<Batch> {
        self.try_batch(request, residual).map_err(|reason| self.failure.set(reason)).ok()
    }
}

impl Gpu for CudaGpu {
    fn name(&self) -> &str {
        &self.name
    }

    fn lanes(&self) -> usize {
        self.lanes
    }

    fn failure(&self) -> Option<Message> {
        let reason = self.failure.get()?;
        let text = format!("the GPU failed, and the cores ran the remaining designs: {reason}");
        Some(Message::new(text).help("their last digits are those of a sweep without `--device gpu`"))
    }
}

fn no_gpu(reason: &str) -> Error {
    Error::usage(format!("there is no GPU with CUDA: {reason}")).help("leave out `--device gpu`")
}

/// The number of lanes of a batch: each thread has at least two batches of designs to make, where there are enough.
fn lanes(designs: usize, threads: usize) -> usize {
    let [least, most] = LANES_OF_BATCH;
    designs.div_ceil(2 * threads).clamp(1, (LANES / threads).clamp(least, most))
}
