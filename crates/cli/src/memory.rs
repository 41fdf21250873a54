//! The memory of the machine.

use std::fs;

/// Up to so many bytes, whether they are free is not worth asking.
const FEW: usize = 1 << 26;

/// Whether so many bytes of memory are free: an allocation alone does not tell, as systems promise more than they have.
pub(crate) fn has_room(bytes: usize) -> bool {
    if bytes <= FEW {
        return true;
    }
    match available() {
        Some(available) => bytes <= available,
        None => Vec::<u8>::new().try_reserve_exact(bytes).is_ok(),
    }
}

/// The bytes that are free, where the system tells it as Linux does.
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
