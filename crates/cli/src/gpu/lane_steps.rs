//! Steps in the lanes of a GPU.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use cudarc::driver::{CudaContext, CudaFunction, CudaSlice, CudaStream, DriverError, LaunchConfig, PushKernelArg};
use qrm_core::LaneSteps;
use qrm_core::lane_layout::QUALITY;

/// The number of threads of a block. Each thread takes as many registers as there are; larger blocks wait for each other.
const THREADS: u32 = 64;

/// The steps of a batch of lanes, each of which is a thread.
pub(super) struct CudaLaneSteps {
    pub(super) kernel: CudaFunction,
    /// The number of places of a lane.
    pub(super) places: usize,
    pub(super) lanes: usize,
    /// Present until the steps are dropped.
    pub(super) buffers: Option<Buffers>,
    pub(super) free: Arc<Mutex<Vec<Buffers>>>,
    pub(super) failure: Arc<OnceLock<String>>,
}

/// The numbers of a batch, lane by lane, on both sides.
pub(super) struct Buffers {
    pub(super) numbers: Vec<f64>,
    on_device: CudaSlice<f64>,
    stream: Arc<CudaStream>,
}

impl Buffers {
    pub(super) fn new(context: &Arc<CudaContext>, length: usize) -> Result<Self, DriverError> {
        let stream = context.new_stream()?;
        Ok(Self { numbers: vec![0.0; length], on_device: stream.alloc_zeros(length)?, stream })
    }

    fn advance(&mut self, kernel: &CudaFunction, lanes: usize) -> Result<(), DriverError> {
        let Self { numbers, on_device, stream } = self;
        let count = i32::try_from(lanes).unwrap_or(i32::MAX);
        let blocks = count.unsigned_abs().div_ceil(THREADS);
        let size = LaunchConfig { grid_dim: (blocks, 1, 1), block_dim: (THREADS, 1, 1), shared_mem_bytes: 0 };
        stream.memcpy_htod(numbers, on_device)?;
        let mut call = stream.launch_builder(kernel);
        call.arg(&mut *on_device).arg(&count);
        // SAFETY: the arguments are those of `advance(double *, int)`, whose threads keep to their own lanes.
        #[expect(unsafe_code, reason = "compiled for the GPU")]
        unsafe {
            call.launch(size)?;
        }
        stream.memcpy_dtoh(on_device, numbers)?;
        stream.synchronize()
    }
}

impl CudaLaneSteps {
    fn numbers(&self) -> &[f64] {
        self.buffers.as_ref().map_or(&[], |buffers| &buffers.numbers)
    }
}

impl LaneSteps for CudaLaneSteps {
    fn lanes(&self) -> usize {
        self.lanes
    }

    fn are_independent(&self) -> bool {
        true
    }

    fn read(&self, place: usize, lane: usize, numbers: &mut [f64]) {
        let own = &self.numbers()[lane * self.places..][..self.places];
        numbers.iter_mut().zip(&own[place..]).for_each(|(number, own)| *number = *own);
    }

    fn write(&mut self, place: usize, lane: usize, numbers: &[f64]) {
        let Some(buffers) = &mut self.buffers else { return };
        let own = &mut buffers.numbers[lane * self.places..][..self.places];
        own[place..].iter_mut().zip(numbers).for_each(|(own, number)| *own = *number);
    }

    /// Where the GPU fails, no lane is reliable: all designs leave for runs of their own.
    fn advance(&mut self) {
        let Some(buffers) = &mut self.buffers else { return };
        let advanced = match self.failure.get() {
            Some(_) => false,
            None => buffers
                .advance(&self.kernel, self.lanes)
                .map_err(|error| self.failure.set(format!("the driver says: {error}")))
                .is_ok(),
        };
        if !advanced {
            buffers.numbers.chunks_mut(self.places).for_each(|lane| lane[QUALITY] = f64::NAN);
        }
    }
}

impl Drop for CudaLaneSteps {
    fn drop(&mut self) {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        free.extend(self.buffers.take());
    }
}
