//! Encodes the simulator of pages, and scenes for it, as text.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use qrm_core::DerivedScene;
use qrm_scene::scene::Scene;

use crate::error::Error;

/// The simulator, compressed by gzip, in base 85.
pub(crate) fn module() -> String {
    base85(qrm_page::MODULE)
}

/// A scene, compressed by gzip, in base 85.
pub(crate) fn packed(derived: DerivedScene, scene: Scene) -> Result<String, Error> {
    compressed(&qrm_page::packed(derived, scene))
}

/// Bytes, compressed by gzip, in base 85.
pub(crate) fn compressed(bytes: &[u8]) -> Result<String, Error> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    let bytes = written.map_err(|e| Error::run(format!("a part of the page cannot be compressed: {e}")))?;
    Ok(base85(&bytes))
}

/// Encodes bytes as text: five digits for four bytes, an overhead of a quarter, while base 64 has a third.
///
/// The digits are the first printable ASCII characters, except space and those that HTML or JSON would escape.
fn base85(bytes: &[u8]) -> String {
    let digits: Vec<char> = (b'!'..=b'~').map(char::from).filter(|sign| !"\"&'<>\\`".contains(*sign)).collect();
    let mut text = String::with_capacity(bytes.len() / 4 * 5 + 5);
    for four in bytes.chunks(4) {
        let byte = |place: usize| u32::from(four.get(place).copied().unwrap_or(0)) << (24 - 8 * place);
        let word: u32 = (0..4).map(byte).sum();
        let digit = |power: u32| digits[(word / 85_u32.pow(power) % 85) as usize];
        text.extend((0..5).rev().map(digit).take(four.len() + 1));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_bytes_are_five_digits() {
        // The digits of 0, of 2^32 - 1 and of 255 * 2^24, most significant first.
        assert_eq!(base85(&[0, 0, 0, 0]), "!!!!!");
        assert_eq!(base85(&[255; 4]).len(), 5);
        assert_eq!(base85(&[0, 0, 0, 85]), "!!!#!");
        assert_eq!(base85(b"12345").len(), 7);
        assert_eq!(base85(&[]), "");
    }
}
