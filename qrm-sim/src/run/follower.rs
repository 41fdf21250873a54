//! The companion of a run, in a thread of its own where the run is long.

use std::panic;
use std::sync::LazyLock;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, Scope, ScopedJoinHandle};

use qrm_core::{Mechanism, RowRequest};

use super::companion::Companion;
use crate::integrate::Integrator;

/// The companion follows once there are so many numbers in rows.
const BLOCK: usize = 4096;
/// The number of blocks on their way between the threads.
const BLOCKS: usize = 4;

/// Whether threads run at the same time.
static HAS_OTHER_PROCESSOR: LazyLock<bool> = LazyLock::new(|| {
    !cfg!(target_arch = "wasm32") && thread::available_parallelism().is_ok_and(|count| count.get() > 1)
});

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
pub(crate) struct Follower<'scope> {
    mechanism: &'scope dyn Mechanism,
    request: RowRequest,
    block: RowBlock,
    /// The companion in the thread of the run, unless it has a thread of its own.
    beside: Option<Companion>,
    thread: Option<CompanionThread<'scope>>,
}

/// A companion in a thread.
struct CompanionThread<'scope> {
    sender: SyncSender<RowBlock>,
    /// Blocks that the companion has followed.
    followed: Receiver<RowBlock>,
    thread: ScopedJoinHandle<'scope, Companion>,
}

impl<'scope> Follower<'scope> {
    /// Begins with a run, if it has a companion.
    pub(crate) fn new(mechanism: &'scope dyn Mechanism, request: RowRequest, companion: Option<Companion>) -> Self {
        Self { mechanism, request, block: RowBlock::default(), beside: companion, thread: None }
    }

    /// Follows rows of a run, the last of its integrator, of which the first has the number `first`.
    pub(crate) fn follow<'env>(
        &mut self,
        scope: &'scope Scope<'scope, 'env>,
        run: &Integrator,
        (rows, first): (&[f64], u64),
    ) {
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
        // A run of one block is over before a thread would have begun.
        if block.first > 0
            && *HAS_OTHER_PROCESSOR
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

impl<'scope> CompanionThread<'scope> {
    fn spawn<'env>(
        scope: &'scope Scope<'scope, 'env>,
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
        Self { sender, followed, thread }
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
