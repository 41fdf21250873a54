//! The designs of a sweep, and their execution on all cores.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use qrm_core::ParameterOverrides;
use qrm_scene::evaluate::{constant, parameter_values};
use qrm_scene::scene::{Scene, Value};
use qrm_scene::time_scales::{parameters_of_time_scales, time_scales};
use qrm_sim::batch::{DesignResult, Device, LaneCount, SweepRequest, sweep, sweep_on};
use qrm_sim::columns::Column;
use qrm_sim::integrate::{DOP853, MethodSettings, StepBounds};
use qrm_sim::run::End;

use super::axes::Axes;
use super::rows::{self, Field, Row};
use crate::error::{Error, Message};
use crate::format::counted;
use crate::gpu::{self, Gpu, Processor};
use crate::options::MethodOptions;
use crate::progress::interrupted;
use crate::regular_forms::DesignSpace;
use crate::resolution;
use crate::setup::Setup;

/// Designs of a scene, each with its own values of the varied parameters.
pub(crate) struct Designs {
    pub(crate) setup: Setup,
    pub(crate) axes: Axes,
    /// Whether the extremes of the outputs are recorded.
    pub(crate) has_extremes: bool,
    /// Whether the error of each design is estimated.
    pub(crate) estimate_error: bool,
    /// The number of designs that a core runs simultaneously.
    pub(crate) lanes: LaneCount,
    /// The GPU, if one runs them.
    pub(crate) gpu: Option<Box<dyn Gpu>>,
    /// The number of designs that left the GPU for runs of their own.
    pub(crate) alone: AtomicU64,
    /// The parts of the designs that are the same for all.
    pub(crate) common: Common,
}

/// The parts of designs that do not depend on the varied parameters.
pub(crate) struct Common {
    /// The bounds of the steps of all designs; `None` if they depend on the varied parameters.
    step_bounds: Option<StepBounds>,
    /// Whether masses and inertias depend on the varied parameters.
    varies_inertia: bool,
}

/// A design and its result.
pub(super) struct Design {
    /// The values of the varied parameters.
    values: Vec<f64>,
    /// The result of the design, or the reason why it cannot run.
    pub(super) result: Result<DesignResult, String>,
}

/// The number of designs per work item of a core, without a GPU.
const BLOCK: usize = 256;

/// The number of blocks per thread that may wait for the rows before them.
const BLOCKS_AHEAD: usize = 4;

/// The interval between two checks for interrupts.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// The requested method, or the default of lanes.
pub(crate) fn by_lanes(how: &MethodOptions) -> MethodOptions {
    MethodOptions { method: how.method.or(Some(DOP853)), ..how.clone() }
}

/// The allowed numbers of cores.
pub const THREADS: RangeInclusive<i64> = 1..=4096;

/// The requested number of cores, or that of the machine.
pub(crate) fn threads(asked: Option<u32>) -> usize {
    match asked {
        Some(threads) => threads as usize,
        None => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
    }
}

impl Designs {
    /// Creates the designs, with extremes and error estimates, in all lanes.
    pub(crate) fn new(setup: Setup, axes: Axes) -> Result<Self, Error> {
        if setup.requested_step.is_some() && setup.settings.method.is_adaptive() {
            return Err(Error::usage("`--step` needs a method of fixed steps, as a sweep writes no rows")
                .help("add `--method rk4`, or choose `--tolerance` instead"));
        }
        if let Some(name) = axes.names().find(|name| setup.set.contains_key(*name)) {
            return Err(Error::usage(format!("`{name}` is both set and varied"))
                .help(format!("omit `--set {name}` or `--vary {name}`")));
        }
        let setup = setup.with_regular_forms(&DesignSpace {
            count: axes.count(),
            value: &|design, name| axes.value(&axes.values(design), name),
            range: &|name| axes.range(name),
        })?;
        let common = Common::new(&setup, &axes);
        Ok(Self {
            setup,
            axes,
            has_extremes: true,
            estimate_error: true,
            lanes: LaneCount::Most,
            gpu: None,
            alone: AtomicU64::new(0),
            common,
        })
    }

    /// Lets a processor run this number of designs on this number of threads.
    pub(crate) fn on(self, processor: Processor, size: (usize, usize)) -> Result<Self, Error> {
        let gpu = match processor {
            Processor::Cpu => None,
            Processor::Gpu => Some(gpu::find(&self.setup, size)?),
        };
        Ok(Self { gpu, ..self })
    }

    /// The GPU that ran designs, and the number of those that left it; `noun` is the word for a design.
    pub(crate) fn on_gpu(&self, noun: &str) -> Option<String> {
        let alone = match self.alone.load(Ordering::Relaxed) {
            0 => String::new(),
            count => format!("; {} left it for the cores", counted(count, noun)),
        };
        Some(format!("on {}{alone}", self.gpu.as_ref()?.name()))
    }

    /// A warning that the GPU failed.
    pub(crate) fn gpu_failure(&self) -> Option<Message> {
        self.gpu.as_ref()?.failure()
    }

    /// The number of designs.
    pub(crate) fn count(&self) -> usize {
        self.axes.count()
    }

    /// The columns of their rows.
    pub(crate) fn columns(&self) -> Vec<Column<Field>> {
        rows::columns(&self.setup, &self.axes, self.has_extremes)
    }

    /// Runs a range of designs. `convert` processes the rows of a block on the thread that computed them, and `take`
    /// receives the results on this thread, in the order of the designs. Returns the first design that was not taken.
    pub(crate) fn run<T: Send>(
        &self,
        (begin, end): (usize, usize),
        threads: usize,
        convert: impl Fn(Vec<Row>) -> T + Sync,
        mut take: impl FnMut(T) -> Result<(), Error>,
    ) -> Result<usize, Error> {
        let (next, progress) = (AtomicUsize::new(begin), (Mutex::new(begin), Condvar::new()));
        let block = self.gpu.as_ref().map_or(BLOCK, |gpu| gpu.lanes());
        let mut taken = Ok(begin);
        std::thread::scope(|scope| {
            let (sender, receiver) = mpsc::channel();
            for _ in 0..threads {
                let (sender, next, progress, convert) = (sender.clone(), &next, &progress, &convert);
                scope.spawn(move || {
                    loop {
                        let from = next.fetch_add(block, Ordering::Relaxed);
                        let to = end.min(from.saturating_add(block));
                        // A slow block does not let the others fill the memory.
                        wait_until(progress, from.saturating_sub(BLOCKS_AHEAD * threads * block));
                        if from >= to || sender.send((from, to, convert(self.rows(from, to)))).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(sender);
            // Blocks arrive in any order, and are taken in the order of the designs.
            let mut waiting = BTreeMap::new();
            loop {
                match receiver.recv_timeout(POLL_INTERVAL) {
                    Ok((from, to, block)) => waiting.insert(from, (to, block)),
                    Err(RecvTimeoutError::Timeout) => None,
                    Err(RecvTimeoutError::Disconnected) => break,
                };
                while let Ok(at) = taken
                    && let Some((to, block)) = waiting.remove(&at)
                {
                    taken = take(block).map(|()| to);
                }
                if taken.is_err() || interrupted() {
                    next.store(end, Ordering::Relaxed);
                    advance(&progress, usize::MAX);
                } else if let Ok(at) = taken {
                    advance(&progress, at);
                }
            }
        });
        taken
    }

    /// The rows of some designs.
    fn rows(&self, begin: usize, end: usize) -> Vec<Row> {
        let columns = self.columns();
        let numbers: Vec<usize> = (begin..end).collect();
        let row = |(number, design): (&usize, Design)| match &design.result {
            Err(reason) => rows::refused(&columns, *number, &design.values, reason),
            Ok(result) => {
                if self.gpu.is_some() && self.lanes == LaneCount::Most && result.is_alone && result.status.is_ok() {
                    self.alone.fetch_add(1, Ordering::Relaxed);
                }
                let passed_over = self.passed_over(&design.values, result.end_time);
                rows::row(&columns, &self.setup, *number, &design.values, result, passed_over)
            }
        };
        numbers.iter().zip(self.results(&numbers, self.setup.settings, self.lanes, None)).map(row).collect()
    }

    /// Runs some designs by their numbers, up to a time if one is given.
    pub(super) fn results(
        &self,
        numbers: &[usize],
        settings: MethodSettings,
        lanes: LaneCount,
        end_time: Option<f64>,
    ) -> Vec<Design> {
        let values: Vec<Vec<f64>> = numbers.iter().map(|number| self.axes.values(*number)).collect();
        let replacing: Vec<_> = values.iter().map(|values| self.replace(values)).collect();
        let replacements: Vec<ParameterOverrides> =
            replacing.iter().map(|replace| replace as ParameterOverrides).collect();
        let scene = &self.setup.scene;
        let refused: Vec<Option<String>> = match self.common.varies_inertia {
            true => values.iter().map(|values| refusal(scene, &self.parameters(values))).collect(),
            // The scene itself was checked.
            false => vec![None; numbers.len()],
        };
        let kept: Vec<usize> = (0..numbers.len()).filter(|i| refused[*i].is_none()).collect();
        let designs: Vec<ParameterOverrides> = kept.iter().map(|i| replacements[*i]).collect();
        let step_bounds = |design: usize| match &self.common.step_bounds {
            Some(bounds) => *bounds,
            None => self.setup.step_bounds(&self.parameters(&values[kept[design]])),
        };
        let request = SweepRequest {
            settings,
            step_bounds: Some(&step_bounds),
            step: self.setup.requested_step,
            end: end_time.map(End::Time).or(self.setup.end()),
            extremes: self.has_extremes,
            estimate_error: self.estimate_error,
        };
        let by_gpu = self.gpu.as_ref().filter(|_| lanes == LaneCount::Most).and_then(|gpu| {
            let device: &dyn Device = &**gpu;
            let results = sweep_on(device, self.setup.model, &designs, &request);
            // Designs that left a GPU that failed would be runs of their own.
            gpu.failure().is_none().then_some(results)
        });
        let results = by_gpu.unwrap_or_else(|| sweep(self.setup.model, &designs, &request, lanes));
        let mut results = results.into_iter();
        // They borrow the values, which the results take.
        drop(replacing);
        let design = |(values, refused): (Vec<f64>, Option<String>)| {
            let result = refused.map_or_else(|| results.next().ok_or_else(String::new), Err);
            Design { values, result }
        };
        values.into_iter().zip(refused).map(design).collect()
    }

    /// The values of all parameters of a design, from those that are varied.
    fn parameters(&self, values: &[f64]) -> Vec<f64> {
        parameter_values(&self.setup.scene, self.replace(values))
    }

    /// The values of parameters that are varied or given on the command line.
    fn replace(&self, values: &[f64]) -> impl Fn(&str) -> Option<f64> {
        let own = self.setup.replace();
        move |name| self.axes.value(values, name).or_else(|| own(name))
    }

    /// The reason why the steps of a design miss a change of a load with time.
    fn passed_over(&self, values: &[f64], end_time: f64) -> Option<String> {
        if self.setup.settings.method.is_adaptive() {
            return None;
        }
        let (scene, parameters) = (&self.setup.scene, &self.parameters(values));
        let step = self.setup.requested_step.unwrap_or_else(|| constant(&scene.run.step, parameters));
        resolution::passed_over(&time_scales(scene, parameters), step, end_time)
    }
}

/// The first design that was not taken.
type TakenDesigns = (Mutex<usize>, Condvar);

/// Waits until the designs before this one were taken.
fn wait_until((taken, changed): &TakenDesigns, design: usize) {
    let guard = taken.lock().unwrap_or_else(PoisonError::into_inner);
    drop(changed.wait_while(guard, |taken| *taken < design));
}

/// Lets threads wait for later designs.
fn advance((taken, changed): &TakenDesigns, to: usize) {
    let mut taken = taken.lock().unwrap_or_else(PoisonError::into_inner);
    if *taken < to {
        *taken = to;
        changed.notify_all();
    }
}

impl Common {
    fn new(setup: &Setup, axes: &Axes) -> Self {
        let scene = &setup.scene;
        let is_varied = |i: &usize| axes.names().any(|name| scene.parameters[*i].name == name);
        let of_scales = parameters_of_time_scales(scene);
        let of_inertia = scene.parameters_of(inertias(scene).map(|(.., value)| value));
        Self {
            step_bounds: (!of_scales.iter().any(is_varied)).then(|| setup.step_bounds(&setup.parameters())),
            varies_inertia: of_inertia.iter().any(is_varied),
        }
    }
}

/// The reason why a design cannot run.
fn refusal(scene: &Scene, parameters: &[f64]) -> Option<String> {
    let mut values = inertias(scene).map(|(name, what, value)| (name, what, constant(value, parameters)));
    let (name, what, value) = values.find(|(_, _, value)| !(*value >= 0.0 && value.is_finite()))?;
    let wrong = if value < 0.0 { "a negative" } else { "no finite" };
    Some(format!("body `{name}` has {wrong} {what}: {value}"))
}

/// The masses and inertias of a scene. Each has the name of its body, and the word `mass` or `inertia`.
fn inertias(scene: &Scene) -> impl Iterator<Item = (&str, &'static str, &Value)> {
    scene.bodies.iter().flat_map(|body| {
        let parts = [("mass", &body.mass), ("inertia", &body.inertia)];
        parts.into_iter().filter_map(|(what, value)| Some((body.name.as_str(), what, value.as_ref()?)))
    })
}
