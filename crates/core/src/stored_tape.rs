//! The functions of a mechanism as bytes in a program, decoded on first use.

#[cfg(feature = "std")]
use std::{boxed::Box, sync::OnceLock};

#[cfg(feature = "std")]
use crate::named_tape::NamedTape;
#[cfg(feature = "std")]
use crate::tape::Tape;

/// The functions of a mechanism, both with names for printers and in the order in which evaluators run them.
#[derive(Debug)]
pub struct StoredTape {
    #[cfg_attr(not(feature = "std"), allow(dead_code))]
    bytes: &'static [u8],
    #[cfg(feature = "std")]
    named: OnceLock<NamedTape>,
    /// Places the tape. Programs that receive placed tapes only, such as pages, do not link this code.
    #[cfg(feature = "std")]
    place: fn(&StoredTape) -> Tape,
    #[cfg(feature = "std")]
    placed: OnceLock<&'static Tape>,
}

impl StoredTape {
    /// Wraps the [bytes](NamedTape::to_bytes) that the generator wrote.
    #[cfg(feature = "std")]
    pub const fn new(bytes: &'static [u8]) -> Self {
        Self { bytes, named: OnceLock::new(), place: Self::placed, placed: OnceLock::new() }
    }

    /// Wraps the bytes that the generator wrote. Programs without a standard library do not decode them.
    #[cfg(not(feature = "std"))]
    pub const fn new(bytes: &'static [u8]) -> Self {
        Self { bytes }
    }
}

#[cfg(feature = "std")]
impl StoredTape {
    /// The tape with names.
    ///
    /// # Panics
    /// If the bytes are not a tape: the generator and this crate have different versions.
    pub fn named(&self) -> &NamedTape {
        let read = || NamedTape::from_bytes(self.bytes).unwrap_or_else(|| panic!("the tape of another version"));
        self.named.get_or_init(read)
    }

    fn placed(&self) -> Tape {
        self.named().placed()
    }

    /// Wraps a tape that is already placed. It has no names.
    pub fn from_placed(tape: Tape) -> Self {
        let stored = Self { bytes: &[], named: OnceLock::new(), place: |_| Tape::default(), placed: OnceLock::new() };
        let _ = stored.placed.set(Box::leak(Box::new(tape)));
        stored
    }

    /// The tape for evaluators. It lives as long as the program.
    pub fn tape(&self) -> &'static Tape {
        self.placed.get_or_init(|| Box::leak(Box::new((self.place)(self))))
    }
}

#[cfg(feature = "std")]
impl From<NamedTape> for StoredTape {
    fn from(named: NamedTape) -> Self {
        let stored = Self::new(&[]);
        let _ = stored.named.set(named);
        stored
    }
}
