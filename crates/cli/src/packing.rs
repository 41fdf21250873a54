//! Encodes the simulator of pages, and scenes for it, as text.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use qrm_core::DerivedScene;
use qrm_scene::scene::Scene;

use crate::error::Error;

/// The simulator, compressed by gzip, in base 91.
pub(crate) fn module() -> String {
    base91(qrm_page::MODULE)
}

/// A scene, compressed by gzip, in base 91.
pub(crate) fn packed(derived: DerivedScene, scene: Scene) -> Result<String, Error> {
    compressed(&qrm_page::packed(derived, scene))
}

/// Bytes, compressed by gzip, in base 91.
pub(crate) fn compressed(bytes: &[u8]) -> Result<String, Error> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    let bytes = written.map_err(|e| Error::run(format!("a part of the page cannot be compressed: {e}")))?;
    Ok(base91(&bytes))
}

/// The digits of base 91: the printable ASCII characters, except those that JSON or a script element would escape.
fn digits() -> Vec<char> {
    (b'!'..=b'~').map(char::from).filter(|sign| !"\"<\\".contains(*sign)).collect()
}

/// Encodes bytes as text in base 91: two digits for 13 or 14 bits, the lowest first. The overhead is 23 %, that of
/// base 64 is 33 %. See basE91 of J. Henke, which has other digits.
fn base91(bytes: &[u8]) -> String {
    let digits = digits();
    let mut text = String::with_capacity(bytes.len() / 4 * 5 + 5);
    let (mut waiting, mut count) = (0_usize, 0);
    for byte in bytes {
        waiting |= usize::from(*byte) << count;
        count += 8;
        if count > 13 {
            // Two digits have more than 13 bits: numbers up to 88 take another one.
            let bits = if waiting % (1 << 13) > 88 { 13 } else { 14 };
            let number = waiting % (1 << bits);
            waiting >>= bits;
            count -= bits;
            text.extend([digits[number % 91], digits[number / 91]]);
        }
    }
    if count > 0 {
        text.push(digits[waiting % 91]);
        if count > 7 || waiting > 90 {
            text.push(digits[waiting / 91]);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse, as the page computes it.
    fn decoded(text: &str) -> Vec<u8> {
        let digits = digits();
        let value = |sign: char| digits.iter().position(|digit| *digit == sign).expect("a digit");
        let (mut bytes, mut waiting, mut count) = (Vec::new(), 0_usize, 0);
        for pair in text.chars().collect::<Vec<char>>().chunks(2) {
            let number = value(pair[0]) + pair.get(1).map_or(0, |sign| 91 * value(*sign));
            waiting |= number << count;
            count += match pair.len() {
                1 => 8,
                _ if number % (1 << 13) > 88 => 13,
                _ => 14,
            };
            while count > 7 {
                bytes.push(waiting.to_le_bytes()[0]);
                waiting >>= 8;
                count -= 8;
            }
        }
        bytes
    }

    #[test]
    fn digits_are_those_of_the_bytes() {
        let signs = base91(qrm_page::MODULE);
        assert!(signs.chars().all(|sign| sign.is_ascii_graphic() && !"\"<\\".contains(sign)));
        assert!(signs.len() < qrm_page::MODULE.len() * 124 / 100);
        assert_eq!(decoded(&signs), qrm_page::MODULE);
        for length in 0..40 {
            for byte in [0, 1, 88, 91, 127, 255] {
                let bytes = vec![byte; length];
                assert_eq!(decoded(&base91(&bytes)), bytes, "{length} of {byte}");
            }
        }
    }
}
