//! The companion of a run, in a thread of its own where the run is long.

use std::panic;
#[cfg(not(target_arch = "wasm32"))]
use std::sync::LazyLock;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, Scope, ScopedJoinHandle};

use qrm_core::{Mechanism, RowRequest};

use super::companion::Companion;
use crate::integrate::Integrator;

/// The number of values that are buffered before the companion processes them.
const BLOCK: usize = 8192;
/// Shorter runs are over before a thread would be of use.
const LONG: usize = 8 * BLOCK;
/// The number of blocks on their way between the threads.
const BLOCKS: usize = 4;

/// Where threads are begun.
#[cfg(not(target_arch = "wasm32"))]
pub(super) type ThreadScope<'scope, 'env> = &'scope Scope<'scope, 'env>;
/// Pages are to be small, and have no threads.
#[cfg(target_arch = "wasm32")]
pub(super) type ThreadScope<'scope, 'env> = (std::convert::Infallible, &'scope &'env ());

/// Calls `run` with a scope for threads, on machines with several cores.
#[cfg(not(target_arch = "wasm32"))]
pub(super) fn with_threads<'env, R>(
    is_parallel: bool,
    run: impl for<'scope> FnOnce(Option<ThreadScope<'scope, 'env>>) -> R,
) -> R {
    static HAS_CORES: LazyLock<bool> =
        LazyLock::new(|| thread::available_parallelism().is_ok_and(|count| count.get() > 1));
    if is_parallel && *HAS_CORES { thread::scope(|scope| run(Some(scope))) } else { run(None) }
}
#[cfg(target_arch = "wasm32")]
pub(super) fn with_threads<'env, R>(
    _: bool,
    run: impl for<'scope> FnOnce(Option<ThreadScope<'scope, 'env>>) -> R,
) -> R {
    run(None)
}

/// Rows of a run that its companion is to follow.
#[derive(Default)]
struct RowBlock {
    rows: Vec<f64>,
    /// The number of the first row.
    first: u64,
    /// Begin and end of the steps that a method chose.
    steps: Vec<[f64; 2]>,
}

/// A companion that follows a run block by block.
pub(crate) struct Follower<'scope, 'env> {
    scope: Option<ThreadScope<'scope, 'env>>,
    mechanism: &'scope dyn Mechanism,
    request: RowRequest,
    block: RowBlock,
    /// The number of values so far.
    count: usize,
    /// The companion in the thread of the run, unless it has a thread of its own.
    beside: Option<Companion>,
    thread: Option<CompanionThread<'scope, 'env>>,
}

/// A companion in a thread.
struct CompanionThread<'scope, 'env> {
    /// Makes this type impossible where there are no threads, so that its code is not compiled.
    _scope: ThreadScope<'scope, 'env>,
    sender: SyncSender<RowBlock>,
    /// Blocks that the companion has followed.
    followed: Receiver<RowBlock>,
    thread: ScopedJoinHandle<'scope, Companion>,
}

impl<'scope, 'env> Follower<'scope, 'env> {
    /// Begins with a run, if it has a companion.
    pub(crate) fn new(
        scope: Option<ThreadScope<'scope, 'env>>,
        mechanism: &'scope dyn Mechanism,
        request: RowRequest,
        companion: Option<Companion>,
    ) -> Self {
        Self { scope, mechanism, request, block: RowBlock::default(), count: 0, beside: companion, thread: None }
    }

    /// Follows rows of a run, the last of its integrator, of which the first has the number `first`.
    pub(crate) fn follow(&mut self, run: &Integrator, (rows, first): (&[f64], u64)) {
        if self.beside.is_none() && self.thread.is_none() {
            return;
        }
        let block = &mut self.block;
        if block.rows.is_empty() {
            block.first = first;
        }
        block.rows.extend_from_slice(rows);
        block.steps.extend_from_slice(run.steps());
        if block.rows.len() < BLOCK {
            return;
        }
        self.count += block.rows.len();
        if self.count > LONG
            && let Some(scope) = self.scope
            && let Some(companion) = self.beside.take()
        {
            self.thread = Some(CompanionThread::spawn(scope, self.mechanism, self.request, companion));
        }
        self.follow_block();
    }

    /// Follows the rows that have come together.
    fn follow_block(&mut self) {
        if let Some(companion) = &mut self.beside {
            self.block.follow(companion, self.mechanism, &self.request);
            self.block.clear();
        } else if let Some(thread) = &self.thread {
            self.block = thread.exchange(std::mem::take(&mut self.block));
        }
    }

    /// The companion at the end of the run.
    pub(crate) fn finish(mut self) -> Option<Companion> {
        self.follow_block();
        let Some(CompanionThread { sender, thread, .. }) = self.thread else { return self.beside };
        drop(sender);
        Some(thread.join().unwrap_or_else(|panic| panic::resume_unwind(panic)))
    }
}

impl RowBlock {
    fn follow(&self, companion: &mut Companion, mechanism: &dyn Mechanism, request: &RowRequest) {
        companion.follow(mechanism, &self.steps, request, &self.rows, self.first);
    }

    fn clear(&mut self) {
        self.rows.clear();
        self.steps.clear();
    }
}

impl<'scope, 'env> CompanionThread<'scope, 'env> {
    #[cfg(target_arch = "wasm32")]
    fn spawn(scope: ThreadScope<'scope, 'env>, _: &'scope dyn Mechanism, _: RowRequest, _: Companion) -> Self {
        match scope.0 {}
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn spawn(
        scope: ThreadScope<'scope, 'env>,
        mechanism: &'scope dyn Mechanism,
        request: RowRequest,
        mut companion: Companion,
    ) -> Self {
        let (sender, receiver) = sync_channel::<RowBlock>(BLOCKS);
        let (used, followed) = sync_channel(BLOCKS);
        for _ in 0..BLOCKS {
            // There is room, and the receiver is there.
            let _ = used.send(RowBlock::default());
        }
        let thread = scope.spawn(move || {
            for block in receiver {
                block.follow(&mut companion, mechanism, &request);
                // A run that is over takes no more blocks.
                let _ = used.send(block);
            }
            companion
        });
        Self { _scope: scope, sender, followed, thread }
    }

    /// Hands a block over, and takes an empty one as soon as there is one.
    fn exchange(&self, block: RowBlock) -> RowBlock {
        // Where the thread has panicked, joining it tells.
        let _ = self.sender.send(block);
        let mut empty = self.followed.recv().unwrap_or_default();
        empty.clear();
        empty
    }
}
