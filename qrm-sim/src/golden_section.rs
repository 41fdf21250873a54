//! The search of a largest value by golden sections.

/// The place between two at which a value is largest, its value there, and what came with it; the first place that is
/// tried whose value is enough.
///
/// # Errors
/// A value could not be computed.
pub(crate) fn largest_between<T, E>(
    [mut a, mut b]: [f64; 2],
    resolution: f64,
    is_enough: impl Fn(f64) -> bool,
    mut at: impl FnMut(f64) -> Result<(f64, T), E>,
) -> Result<(f64, f64, T), E> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
    let (mut at_c, mut at_d) = (at(c)?, at(d)?);
    while (b - a).abs() > resolution {
        if is_enough(at_c.0) {
            return Ok((c, at_c.0, at_c.1));
        }
        if is_enough(at_d.0) {
            return Ok((d, at_d.0, at_d.1));
        }
        if at_c.0 > at_d.0 {
            (b, d, at_d) = (d, c, at_c);
            c = b - golden * (b - a);
            at_c = at(c)?;
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + golden * (b - a);
            at_d = at(d)?;
        }
    }
    Ok(if at_c.0 > at_d.0 { (c, at_c.0, at_c.1) } else { (d, at_d.0, at_d.1) })
}
