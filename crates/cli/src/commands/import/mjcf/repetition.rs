//! Equality constraints that repeat joints: they hold the joint, or are left out.

use super::super::linkage::{Constraint, ImportedLinkage, Joint, Kind};
use super::super::names::Names;
use super::links::Links;

/// Replaces a new pin or weld that repeats equations of joints. Returns whether it does.
pub(super) fn repeats(
    links: &Links,
    new: &Joint,
    title: &str,
    linkage: &mut ImportedLinkage,
    names: &mut Names,
) -> bool {
    let is_weld = matches!(new.kind, Kind::Weld { .. });
    let [a, b] = [new.ends[0], new.ends[1]];
    let [place, other] = [a, b].map(|end| linkage.place(end));
    let size = place.iter().chain(&linkage.links[a.link].place).fold(1e-3, |most: f64, value| most.max(value.abs()));
    let is_same = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-5 * size;
    if !is_same(place, other) {
        return false;
    }
    let earlier = linkage.joints.iter().skip(links.joints.len()).find(|own| {
        let is_pair = own.ends.len() == 2 && own.ends.iter().all(|end| [a.link, b.link].contains(&end.link));
        let is_enough = matches!(own.kind, Kind::Weld { .. })
            || own.kind == Kind::Pin && !is_weld && is_same(linkage.place(own.ends[0]), place);
        is_pair && is_enough
    });
    if let Some(earlier) = earlier {
        linkage.left_out.push(format!("the equality `{title}`, which repeats `{}`", earlier.name));
        return true;
    }
    let between = links.between(linkage, a.link, b.link);
    if between.is_empty() || between.len() > 1 + usize::from(is_weld) {
        return false;
    }
    for own in between {
        let joint = &links.joints[own];
        let shown = joint.title(linkage).to_owned();
        let is_on_axis = !joint.is_slide && is_same(linkage.place(linkage.joints[joint.number].ends[0]), place);
        if is_on_axis && !is_weld {
            linkage.left_out.push(format!("the equality `{title}`, which repeats joint `{shown}`"));
            continue;
        }
        linkage.left_out.push(format!("of the equality `{title}` what repeats joint `{shown}`, which does not move"));
        let (unit, residual) = (if joint.is_slide { "m" } else { "rad" }, joint.displacement(linkage));
        let name = names.unique(title, "equality");
        let gradient = vec![(joint.number, joint.axis_sign)];
        linkage.constraints.push(Constraint { name, residual, unit, gradient });
    }
    true
}

impl Links {
    /// The joints of the tree between two links.
    fn between(&self, linkage: &ImportedLinkage, a: usize, b: usize) -> Vec<usize> {
        let [a, b] = [a, b].map(|link| self.above(linkage, link));
        let only = |own: &[usize], other: &[usize]| -> Vec<usize> {
            own.iter().copied().filter(|joint| !other.contains(joint)).collect()
        };
        [only(&a, &b), only(&b, &a)].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::imported;

    /// Two bars in a chain with an equality.
    fn scene(equality: &str) -> Result<String, String> {
        let geom = "<geom type=\"box\" size=\".1 .01 .01\" pos=\".1 0 0\"/>";
        imported(&format!(
            "<mujoco><worldbody><body name=\"a\"><joint name=\"j\" axis=\"0 0 1\"/>{geom}\
             <body name=\"b\" pos=\".2 0 0\"><joint name=\"k\" axis=\"0 0 1\"/>{geom}</body></body></worldbody>\
             <equality>{equality}</equality></mujoco>"
        ))
    }

    #[test]
    fn welds_across_a_hinge_hold_it() {
        for equality in [
            "<weld name=\"w\" body1=\"a\" body2=\"b\"/>",
            "<connect name=\"w\" body1=\"b\" body2=\"a\" anchor=\".1 0 0\"/>",
        ] {
            let scene = scene(equality).expect("a scene");
            assert!(scene.contains("w = { residual = 'phi_b - phi_a', unit = \"rad\" }"), "{scene}");
            assert!(scene.contains("# - of the equality `w` what repeats joint `k`"), "{scene}");
        }
    }

    #[test]
    fn equalities_that_repeat_others_are_left_out() {
        let on_axis = scene("<connect name=\"c\" body1=\"b\" body2=\"a\" anchor=\"0 0 0\"/>").expect("a scene");
        assert!(on_axis.contains("# - the equality `c`, which repeats joint `k`"), "{on_axis}");
        let connect = |name: &str| format!("<connect name=\"{name}\" body1=\"b\" anchor=\"0 0 0\"/>");
        let twice = scene(&(connect("c") + &connect("d"))).expect("a scene");
        assert!(twice.contains("# - the equality `d`, which repeats `c`"), "{twice}");
    }

    #[test]
    fn models_that_cannot_move_name_their_joints() {
        let connect = "<connect name=\"c\" body1=\"a\" anchor=\".1 0 0\"/>";
        let weld = "<weld name=\"w\" body1=\"a\" body2=\"b\"/>";
        let error = scene(&[connect, weld].concat()).expect_err("no scene");
        assert!(error.contains("this model cannot move") && error.contains("`j`, `k`, `c`, `w`"), "{error}");
    }
}
