//! Springs, dampers and actuators.

use crate::motion::ForceElementPart;

use super::canvas::Canvas;
use super::palette::{GROUND, INK, PIN};
use super::stage::{Point, frame_along};

/// Half the width of a spring or a cylinder, and the distance between parallel ones.
const HALF: f32 = 6.5;
const LANE: f32 = 19.0;
/// The length of the straight piece at each end.
const LEAD: f32 = 9.0;
const LINE: f32 = 1.6;

/// Draws the parts between two positions whose distance has the given range.
pub(super) fn draw(canvas: &mut Canvas, parts: &[ForceElementPart], ends: [Point; 2], range: [f32; 2]) {
    let Some((length, at)) = frame_along(ends[0], ends[1]) else { return };
    let lead = LEAD.min(0.14 * length);
    let (from, to) = (lead, length - lead);
    canvas.line(&[at(0.0, 0.0), at(from, 0.0)], LINE, INK);
    canvas.line(&[at(to, 0.0), at(length, 0.0)], LINE, INK);
    let outermost = 0.5 * LANE * (parts.len().max(1) - 1) as f32;
    for end in [from, to] {
        canvas.line(&[at(end, -outermost), at(end, outermost)], LINE, INK);
    }
    for (place, part) in parts.iter().enumerate() {
        let aside = LANE * place as f32 - outermost;
        let at = |along: f32, own: f32| at(along, aside + own);
        if *part == ForceElementPart::Spring {
            let straight = 0.06 * (to - from);
            // The number of turns that looks best at the mean length.
            let count = 2 * ((range[0] + range[1]) / (4.6 * HALF)).round().clamp(4.0, 16.0) as u32;
            let step = (to - from - 2.0 * straight) / count as f32;
            let peak =
                |i: u32| at(from + straight + step * (i as f32 + 0.5), if i.is_multiple_of(2) { HALF } else { -HALF });
            let ends = [[at(from, 0.0), at(from + straight, 0.0)], [at(to - straight, 0.0), at(to, 0.0)]];
            let line: Vec<Point> = ends[0].into_iter().chain((0..count).map(peak)).chain(ends[1]).collect();
            canvas.line(&line, LINE, INK);
            continue;
        }
        let [start, end, piston] = cylinder(from, to, length, range);
        let tube = [at(end, -HALF), at(start, -HALF), at(start, HALF), at(end, HALF)];
        let rod = [at(piston, 0.0), at(to, 0.0)];
        canvas.polygon(&tube, PIN, 255);
        canvas.line(&[at(from, 0.0), at(start, 0.0)], LINE, INK);
        if *part == ForceElementPart::Damper {
            canvas.line(&tube, LINE, INK);
            canvas.line(&rod, LINE, INK);
            canvas.line(&[at(piston, 1.8 - HALF), at(piston, HALF - 1.8)], 3.0, INK);
        } else {
            canvas.outline(&tube, LINE, INK);
            canvas.line(&rod, 5.0, INK);
            canvas.line(&rod, 5.0 - 2.0 * LINE, PIN);
            canvas.line(&[at(piston, 1.0 - HALF), at(piston, HALF - 1.0)], 4.5, GROUND);
        }
    }
    for end in ends {
        canvas.disc(end, 3.0, INK);
    }
}

/// The ends of a cylinder, and its piston. The stroke is shown to scale if it fits.
fn cylinder(from: f32, to: f32, length: f32, [low, high]: [f32; 2]) -> [f32; 3] {
    let stroke = high - low;
    let least = low.max(0.3 * high);
    let body = (stroke + 2.0 * HALF).max(0.42 * least).min(0.6 * least).min(0.7 * (to - from));
    let start = from + 0.12 * (to - from).min(least);
    let moved = if stroke > 0.0 { (length - 0.5 * (low + high)) * (0.7 * body / stroke).min(1.0) } else { 0.0 };
    [start, start + body, start + 0.5 * body + moved]
}
