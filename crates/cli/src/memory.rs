//! The memory of the machine.

use std::fs;

use crate::error::Error;

/// The number of bytes up to which memory is not checked.
const FEW: usize = 1 << 26;

/// Whether this number of bytes is free: a successful allocation does not show it, since systems promise more memory
/// than they have.
pub(crate) fn has_room(bytes: usize) -> bool {
    if bytes <= FEW {
        return true;
    }
    match available() {
        Some(available) => bytes <= available,
        None => Vec::<u8>::new().try_reserve_exact(bytes).is_ok(),
    }
}

/// Refuses what takes more bytes than are free: `what` says what it is, and `help` how to ask for less.
pub(crate) fn require_room(bytes: usize, what: &str, help: &str) -> Result<(), Error> {
    if has_room(bytes) {
        return Ok(());
    }
    Err(Error::usage(format!("{what} need {:.0} GB of memory", bytes as f64 / 1e9)).help(help))
}

/// The number of free bytes, if the system reports it as Linux does.
fn available() -> Option<usize> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let entry = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: usize = entry.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::has_room;

    #[test]
    fn there_is_room_for_little_alone() {
        assert!(has_room(1) && !has_room(1 << 50));
    }
}
