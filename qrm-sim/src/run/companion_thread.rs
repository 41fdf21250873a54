//! The companion of a run, in its own thread if the run has more than a block of rows.
#![cfg_attr(not(feature = "threads"), allow(unused_imports, dead_code, unreachable_code))]

use std::panic;
#[cfg(feature = "threads")]
use std::sync::LazyLock;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, Scope, ScopedJoinHandle};

use qrm_core::{Mechanism, RowRequest};

use super::companion::{Companion, ESTIMATES_EXTREMES, RowBlock};
use super::extremes::{Extremes, FoundExtreme, sign};
use crate::integrate::Integrator;

/// The number of values that are buffered before the companion processes them: 0.2 ms of work, while
/// a thread starts in 0.05 ms.
const BLOCK: usize = 4096;
/// The number of blocks in transit between the threads.
const BLOCKS: usize = 4;
/// The number of rows held back for the next block: extremes between them may not be known yet.
const WAITING: usize = 5;

/// The scope in which threads are started.
#[cfg(feature = "threads")]
pub(super) type ThreadScope<'scope, 'env> = &'scope Scope<'scope, 'env>;
/// No scope: there are no threads.
#[cfg(not(feature = "threads"))]
pub(super) type ThreadScope<'scope, 'env> = (std::convert::Infallible, &'scope &'env ());

/// Calls `run` with a scope for threads, if the machine has several cores.
#[cfg(feature = "threads")]
pub(super) fn with_threads<'env, R>(
    is_parallel: bool,
    run: impl for<'scope> FnOnce(Option<ThreadScope<'scope, 'env>>) -> R,
) -> R {
    static HAS_CORES: LazyLock<bool> =
        LazyLock::new(|| thread::available_parallelism().is_ok_and(|count| count.get() > 1));
    if is_parallel && *HAS_CORES { thread::scope(|scope| run(Some(scope))) } else { run(None) }
}
#[cfg(not(feature = "threads"))]
pub(super) fn with_threads<'env, R>(
    _: bool,
    run: impl for<'scope> FnOnce(Option<ThreadScope<'scope, 'env>>) -> R,
) -> R {
    run(None)
}

/// A block of rows buffered for the companion.
#[derive(Default)]
struct RowBuffer {
    rows: Vec<f64>,
    first: u64,
    steps: Vec<[f64; 2]>,
    extremes: Vec<FoundExtreme>,
}

/// A companion that follows a run block by block.
pub(crate) struct Follower<'scope, 'env> {
    scope: Option<ThreadScope<'scope, 'env>>,
    mechanism: &'scope dyn Mechanism,
    request: RowRequest,
    /// The number of values of a row.
    width: usize,
    block: RowBuffer,
    /// A buffer for the next block.
    spare: RowBuffer,
    /// The extremes known so far.
    known: Vec<Extremes>,
    /// The companion, if it runs in the thread of the run.
    inline_companion: Option<Companion>,
    thread: Option<CompanionThread<'scope, 'env>>,
}

/// A companion in its own thread.
struct CompanionThread<'scope, 'env> {
    /// Makes this type uninhabited where there are no threads, so that its code is not compiled.
    _scope: ThreadScope<'scope, 'env>,
    sender: SyncSender<RowBuffer>,
    /// Blocks that the companion has processed.
    followed: Receiver<RowBuffer>,
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
        Self {
            scope,
            mechanism,
            request,
            width: companion.as_ref().map_or(0, Companion::width),
            block: RowBuffer::default(),
            spare: RowBuffer::default(),
            known: Vec::new(),
            inline_companion: companion,
            thread: None,
        }
    }

    /// Follows the latest rows of a run's integrator; the first of them has the number `first`. `extremes` are those
    /// known after these rows.
    pub(crate) fn follow(&mut self, run: &Integrator, (rows, first): (&[f64], u64), extremes: &[Extremes]) {
        if self.inline_companion.is_none() && self.thread.is_none() {
            return;
        }
        let block = &mut self.block;
        if block.rows.is_empty() {
            block.first = first;
        }
        block.rows.extend_from_slice(rows);
        block.steps.extend_from_slice(run.steps());
        if ESTIMATES_EXTREMES {
            self.take_extremes(extremes);
        }
        if self.block.rows.len() < BLOCK.max((WAITING + 1) * self.width) {
            return;
        }
        if let Some(scope) = self.scope
            && let Some(companion) = self.inline_companion.take()
        {
            self.thread = Some(CompanionThread::spawn(scope, self.mechanism, self.request, companion));
        }
        self.follow_block(WAITING);
    }

    /// Adds new extremes.
    fn take_extremes(&mut self, extremes: &[Extremes]) {
        let is_first = self.known.is_empty();
        for (column, new) in extremes.iter().enumerate() {
            let known = self.known.get(column);
            for (end, (value, t)) in [new.minimum, new.maximum].into_iter().enumerate() {
                let is_new = known.is_none_or(|known| [known.minimum, known.maximum][end] != (value, t));
                if is_new && value.is_finite() && !(is_first && t == self.block.rows[0]) {
                    self.block.extremes.push(FoundExtreme { column, end, value, t, behind: None });
                }
                let rival = new.rivals[end].filter(|(value, _)| value.is_finite());
                if let Some((rival, at)) = rival
                    && known.is_none_or(|known| known.rivals[end] != Some((rival, at)))
                {
                    let behind = Some(sign(end) * (value - rival));
                    let of_block = &mut self.block.extremes;
                    of_block.retain(|known| (known.column, known.end) != (column, end) || known.behind.is_none());
                    of_block.push(FoundExtreme { column, end, value: rival, t: at, behind });
                }
            }
        }
        self.known.clear();
        self.known.extend_from_slice(extremes);
    }

    /// Sends the buffered rows to the companion, except the last `waiting` ones.
    fn follow_block(&mut self, waiting: usize) {
        let mut later = match &self.thread {
            Some(thread) => thread.empty(),
            None => std::mem::take(&mut self.spare),
        };
        if ESTIMATES_EXTREMES && waiting > 0 {
            self.block.move_last(waiting * self.width, self.width, &mut later);
        }
        let mut block = std::mem::replace(&mut self.block, later);
        if let Some(companion) = &mut self.inline_companion {
            block.follow(companion, self.mechanism, &self.request);
            block.clear();
            self.spare = block;
        } else if let Some(thread) = &self.thread {
            thread.send(block);
        }
    }

    /// Returns the companion at the end of the run.
    pub(crate) fn finish(mut self) -> Option<Companion> {
        self.follow_block(0);
        let Some(CompanionThread { sender, thread, .. }) = self.thread else { return self.inline_companion };
        drop(sender);
        Some(thread.join().unwrap_or_else(|panic| panic::resume_unwind(panic)))
    }
}

impl RowBuffer {
    fn follow(&self, companion: &mut Companion, mechanism: &dyn Mechanism, request: &RowRequest) {
        let Self { rows, first, steps, extremes } = self;
        companion.follow(mechanism, request, RowBlock { rows, first: *first, steps, extremes });
    }

    /// Moves the last values to the next block, together with the extremes after the remaining ones.
    fn move_last(&mut self, count: usize, width: usize, to: &mut Self) {
        let left = self.rows.len() - count;
        to.first = self.first + (left / width) as u64;
        to.rows.extend(self.rows.drain(left..));
        let end = self.rows[left - width];
        to.extremes.extend(self.extremes.iter().filter(|extreme| extreme.t > end));
        self.extremes.retain(|extreme| extreme.t <= end);
    }

    fn clear(&mut self) {
        self.rows.clear();
        self.steps.clear();
        self.extremes.clear();
    }
}

impl<'scope, 'env> CompanionThread<'scope, 'env> {
    #[cfg(not(feature = "threads"))]
    fn spawn(scope: ThreadScope<'scope, 'env>, _: &'scope dyn Mechanism, _: RowRequest, _: Companion) -> Self {
        match scope.0 {}
    }

    #[cfg(feature = "threads")]
    fn spawn(
        scope: ThreadScope<'scope, 'env>,
        mechanism: &'scope dyn Mechanism,
        request: RowRequest,
        mut companion: Companion,
    ) -> Self {
        let (sender, receiver) = sync_channel::<RowBuffer>(BLOCKS);
        let (used, followed) = sync_channel(BLOCKS);
        for _ in 0..BLOCKS {
            // Sending succeeds: there is room, and the receiver exists.
            let _ = used.send(RowBuffer::default());
        }
        let thread = scope.spawn(move || {
            for block in receiver {
                block.follow(&mut companion, mechanism, &request);
                // A finished run accepts no more blocks.
                let _ = used.send(block);
            }
            companion
        });
        Self { _scope: scope, sender, followed, thread }
    }

    /// Waits for an empty block.
    fn empty(&self) -> RowBuffer {
        // If the thread has panicked, joining it reports that.
        let mut block = self.followed.recv().unwrap_or_default();
        block.clear();
        block
    }

    /// Sends a block.
    fn send(&self, block: RowBuffer) {
        let _ = self.sender.send(block);
    }
}
