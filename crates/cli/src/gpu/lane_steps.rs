//! Steps in the lanes of a GPU.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use cudarc::driver::{CudaContext, CudaFunction, CudaSlice, CudaStream, DriverError, LaunchConfig, PushKernelArg};
use qrm_core::LaneSteps;

/// The number of threads of a block. Small blocks leave few registers unused, whatever number a thread takes.
const BLOCK_SIZE: u32 = 64;

/// The steps of a batch of lanes. Each lane is a thread.
pub(super) struct CudaLaneSteps {
    /// The function `advance` for this number of places.
    pub(super) kernel: CudaFunction,
    /// The number of places of a lane.
    pub(super) places: usize,
    pub(super) buffers: PooledBuffers,
    pub(super) failure: Arc<OnceLock<String>>,
}

/// The numbers of a batch, lane by lane, on the host and on the device.
pub(super) struct Buffers {
    pub(super) numbers: Vec<f64>,
    on_device: CudaSlice<f64>,
    stream: Arc<CudaStream>,
}

/// Buffers that another batch uses after this one.
pub(super) struct PooledBuffers {
    /// `None` only while they are being dropped.
    pub(super) buffers: Option<Buffers>,
    pub(super) free: Arc<Mutex<Vec<Buffers>>>,
}

impl Buffers {
    pub(super) fn new(context: &Arc<CudaContext>, length: usize) -> Result<Self, DriverError> {
        let stream = context.new_stream()?;
        Ok(Self { numbers: vec![0.0; length], on_device: stream.alloc_zeros(length)?, stream })
    }

    fn advance(&mut self, kernel: &CudaFunction, places: usize) -> Result<(), DriverError> {
        let Self { numbers, on_device, stream } = self;
        let lanes = (numbers.len() / places) as i32;
        let blocks = lanes.unsigned_abs().div_ceil(BLOCK_SIZE);
        let config = LaunchConfig { grid_dim: (blocks, 1, 1), block_dim: (BLOCK_SIZE, 1, 1), shared_mem_bytes: 0 };
        stream.memcpy_htod(numbers, on_device)?;
        let mut call = stream.launch_builder(kernel);
        call.arg(&mut *on_device).arg(&lanes);
        // SAFETY: the arguments are those of `advance(double *, int)`, compiled for this number of places. A thread
        // reads and writes the numbers of its own lane, which are in the buffer. No other stream uses the buffer, and
        // the host waits for this stream below.
        #[expect(unsafe_code, reason = "compiled for the GPU")]
        unsafe {
            call.launch(config)?;
        }
        stream.memcpy_dtoh(on_device, numbers)?;
        stream.synchronize()
    }
}

impl CudaLaneSteps {
    fn numbers(&self) -> &[f64] {
        self.buffers.buffers.as_ref().map_or(&[], |buffers| &buffers.numbers)
    }
}

impl LaneSteps for CudaLaneSteps {
    fn lanes(&self) -> usize {
        self.numbers().len() / self.places
    }

    fn are_independent(&self) -> bool {
        true
    }

    fn read(&self, place: usize, lane: usize, numbers: &mut [f64]) {
        let own = &self.numbers()[lane * self.places..][..self.places];
        numbers.iter_mut().zip(&own[place..]).for_each(|(number, own)| *number = *own);
    }

    fn write(&mut self, place: usize, lane: usize, numbers: &[f64]) {
        let Some(buffers) = &mut self.buffers.buffers else { return };
        let own = &mut buffers.numbers[lane * self.places..][..self.places];
        own[place..].iter_mut().zip(numbers).for_each(|(own, number)| *own = *number);
    }

    fn advance(&mut self) -> bool {
        let (Some(buffers), None) = (&mut self.buffers.buffers, self.failure.get()) else { return false };
        let advanced = buffers.advance(&self.kernel, self.places);
        advanced.map_err(|error| self.failure.set(of_driver(error))).is_ok()
    }
}

/// The text of an error of the driver.
pub(super) fn of_driver(error: DriverError) -> String {
    format!("the CUDA driver says: {error}")
}

impl Drop for PooledBuffers {
    fn drop(&mut self) {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        free.extend(self.buffers.take());
    }
}
