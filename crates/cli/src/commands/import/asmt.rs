//! Assemblies of the Ondsel solver: parts with markers, joints between markers, and motions of joints.

mod joints;
mod motion;
mod parts;
mod tree;

use super::independent_coordinates::has_possible_velocities;
use super::linkage::ImportedLinkage;
use super::names::Names;
use super::plane::Plane;
use super::source::Source;
use crate::error::Error;
use parts::Parts;
use tree::{Node, Tree};

/// Whether a text begins as an assembly.
pub(super) fn recognizes(text: &str) -> bool {
    let first = text.lines().next().unwrap_or_default();
    first.trim() == "OndselSolver" || first.starts_with("freeCAD: 3D CAD with Motion Simulation")
}

/// Reads an assembly.
pub(super) fn read(source: &Source) -> Result<ImportedLinkage, Error> {
    let tree = Tree::read(&source.text);
    check_indentation(source)?;
    let Some(assembly) = tree.roots().find(|node| node.text() == "Assembly") else {
        return Err(
            source.whole("it has no `Assembly`", "export the assembly again, as a file .asmt of the Ondsel solver")
        );
    };
    let mut linkage = ImportedLinkage::new("an assembly of the Ondsel solver");
    let mut names = Names::new();
    let items = joints::items(&assembly);
    if !parts::frame(source, &assembly)?.is_world() {
        linkage.left_out.push("the pose of the assembly: the scene is in its frame".to_owned());
    }
    let mut parts = Parts::read(source, &assembly)?;
    check_end(source, &tree, &assembly)?;
    let plane = joints::plane(source, &parts, &items)?;
    parts.place(&plane, &mut linkage, &mut names);
    joints::add(source, &parts, &plane, &items, &mut linkage, &mut names)?;
    linkage.connect_free_links(&mut names);
    if !has_possible_velocities(&linkage) {
        linkage.left_out.push("velocities of parts that contradict the joints".to_owned());
    }
    let run = simulation(source, &assembly, &mut linkage)?;
    motion::add(&assembly, &parts, &plane, run, &mut linkage, &mut names);
    if let Some(row) = assembly.child("ConstantGravity").and_then(|node| node.first()) {
        linkage.add_gravity(row.vector(source)?, &plane);
    }
    linkage.add_joint_forces(&mut names);
    remarks(&tree, &assembly, &plane, &mut linkage);
    Ok(linkage)
}

/// Refuses a file that is indented by blanks.
fn check_indentation(source: &Source) -> Result<(), Error> {
    let text = &source.text;
    let blank = text.match_indices("\n ").map(|(at, _)| at + 1).next();
    match blank.filter(|_| !text.contains("\n\t")) {
        Some(at) => {
            let end = text[at..].find(|c| c != ' ').map_or(text.len(), |count| at + count);
            let help = "indent each level by a tab, as the Ondsel solver writes it";
            Err(source.error("this line is indented by blanks", at..end, "indentation is by tabs", help))
        }
        None => Ok(()),
    }
}

/// Refuses a file that ends inside a section.
fn check_end(source: &Source, tree: &Tree, assembly: &Node) -> Result<(), Error> {
    let sections = ["ConstraintSets", "ConstantGravity", "SimulationParameters"];
    let has_value = |node: &Node, name: &str| node.child(name).is_some_and(|node| node.first().is_some());
    let run = assembly.child("SimulationParameters");
    let missing = sections.into_iter().find(|name| !has_value(assembly, name)).or_else(|| {
        let settings = ["tstart", "tend", "hout"];
        settings.into_iter().find(|name| !run.is_some_and(|run| has_value(&run, name)))
    });
    let Some(missing) = missing else { return Ok(()) };
    let title = format!("the assembly ends before its `{missing}`");
    let span = tree.last().map_or(0..1, |node| node.span());
    Err(source.error(title, span, "the last line", "export the assembly again, and copy the whole file"))
}

/// Reads the step and the end of the simulation, and returns its start.
fn simulation(source: &Source, assembly: &Node, linkage: &mut ImportedLinkage) -> Result<f64, Error> {
    let Some(settings) = assembly.child("SimulationParameters") else { return Ok(0.0) };
    let value =
        |name: &str| settings.child(name).and_then(|node| node.first()).map(|node| node.number(source)).transpose();
    let [start, end, output] =
        [value("tstart")?.unwrap_or(0.0), value("tend")?.unwrap_or(0.0), value("hout")?.unwrap_or(0.0)];
    if end > start {
        linkage.end_time = end - start;
    }
    // The rows of the file are among those of the run, which has at least 1000 steps.
    let output = if output > 0.0 && output <= linkage.end_time { output } else { linkage.end_time };
    let parts = (1000.0 * output / linkage.end_time).ceil().max(1.0);
    linkage.step = output / parts;
    Ok(start)
}

/// Adds a remark, and notes what the importer does not read.
fn remarks(tree: &Tree, assembly: &Node, plane: &Plane, linkage: &mut ImportedLinkage) {
    linkage.remarks.push(format!("The axes of the plane, in the assembly: {}.", plane.axes_text()));
    for (section, what) in
        [("ForceTorques", "force or torque"), ("Limits", "limit"), ("KinematicIJs", "measured quantity")]
    {
        let nodes = [assembly.child(section), assembly.child("ConstraintSets").and_then(|sets| sets.child(section))];
        for item in nodes.into_iter().flatten().flat_map(|node| node.children()) {
            linkage.left_out.push(format!("the {what} `{}` ({})", item.name(), item.text()));
        }
    }
    let sets = assembly.child("ConstraintSets").and_then(|sets| sets.child("GeneralConstraintSets"));
    for item in sets.into_iter().flat_map(|node| node.children()) {
        linkage.left_out.push(format!("the constraint `{}` ({})", item.name(), item.text()));
    }
    if tree.roots().any(|node| node.text().starts_with("TimeSeries")) {
        linkage.left_out.push("the results that the file holds".to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::super::imported;

    const FOUR_BAR: &str = include_str!("../../../../../tests/import/four-bar.asmt");
    const SLIDER_CRANK: &str = include_str!("../../../../../tests/import/slider-crank.asmt");

    #[test]
    fn a_four_bar_is_that_of_its_parts() {
        let shown = "\
[links]
ground  = { points = { O = [0, 0], D = [2, 0] } }
crank   = { points = { O = [0.1, 0.1], A = [0.9, 0.1] }, mass = 0.2, com = [0.5, 0.1], inertia = 0.017333333333333 }
coupler = { points = { A = [0.1, 0.1], B = [1.9, 0.1] }, mass = 0.4, com = [1, 0.1], inertia = 0.13466666666667, \
angle = 0.80636087982073 }
rocker  = { points = { B = [0.1, 0.1], D = [1.4, 0.1] }, mass = 0.3, com = [0.75, 0.1], inertia = 0.05725, \
angle = -1.6060600451779 }
[joints]
O = { revolute = [\"crank\", \"ground\"], drive = '2*pi*t' }
A = { revolute = [\"crank\", \"coupler\"] }
B = { revolute = [\"coupler\", \"rocker\"] }
D = { revolute = [\"rocker\", \"ground\"] }
[loads]
gravity = { gravity = [0, -9.81] }
";
        let scene = imported(FOUR_BAR).expect("a scene");
        assert!(scene.contains(shown), "{scene}");
        assert_eq!(imported(&FOUR_BAR.replace('\n', "\r\n")).expect("a scene"), scene);
    }

    #[test]
    fn parts_that_lie_across_the_plane_slide_in_it() {
        let scene = imported(SLIDER_CRANK).expect("a scene");
        let piston = "Piston = { points = { B = [0, 0], Guide = [0, 1] }, mass = 7, com = [0, 0.5], inertia = 1.1 }";
        let guide =
            "Guide = { prismatic = [\"Piston\", \"ground.Guide_line\"], direction = 1.5707963267948966, start = -1 }";
        assert!(scene.contains(piston) && scene.contains(guide), "{scene}");
    }

    #[test]
    fn markers_that_are_turned_or_reversed_turn_the_motion() {
        let marker = |rows: &str| {
            let begin = SLIDER_CRANK.find("\t\t\t\t\tName\n\t\t\t\t\t\tO\n").expect("the marker on the ground");
            let at = begin + SLIDER_CRANK[begin..].find("RotationMatrix\n").expect("its axes");
            let end = at + SLIDER_CRANK[at..].find("\tParts").expect("its end");
            let text = format!("{}RotationMatrix\n{rows}{}", &SLIDER_CRANK[..at], &SLIDER_CRANK[end..]);
            let scene = imported(&text).expect("a scene");
            let line = scene.lines().find(|line| line.starts_with("O ")).expect("the pin").to_owned();
            line[line.find("drive").expect("a drive")..].to_owned()
        };
        assert_eq!(
            marker("\t\t\t\t\t\t0\t-1\t0\n\t\t\t\t\t\t1\t0\t0\n\t\t\t\t\t\t0\t0\t1\n"),
            "drive = '2*pi*t + 1.5707963267948966' }"
        );
        assert_eq!(marker("\t\t\t\t\t\t1\t0\t0\n\t\t\t\t\t\t0\t-1\t0\n\t\t\t\t\t\t0\t0\t-1\n"), "drive = '-2*pi*t' }");
    }

    #[test]
    fn translations_are_along_the_axis_of_the_first_marker() {
        let driven = |formula: &str| {
            let text =
                SLIDER_CRANK.replace("RotationalMotion", "TranslationalMotion").replace("RotationZ", "TranslationZ");
            let text = text.replace("MotionJoint\n\t\t\t\t\t/Assembly1/O", "MotionJoint\n\t\t\t\t\t/Assembly1/Guide");
            text.replace("2.0d*pi*time", formula)
        };
        let drive = |text: &str| {
            let scene = imported(text).expect("a scene");
            let line = scene.lines().find(|line| line.starts_with("Guide ")).expect("the slider").to_owned();
            line[line.find("drive").expect("a drive")..].to_owned()
        };
        // The marker on the ground is 1 m in front of that of the piston, or behind it where its axis is reversed.
        assert_eq!(drive(&driven("1 + 0.1*time")), "drive = '-(1 + 0.1*t)' }");
        let reversed = driven("-1 - 0.1*time");
        let begin = reversed.find("0\t0\t1\n\t\t\t\t\t\t\tRotationMatrix\n").expect("the marker of the piston");
        let (front, back) = reversed.split_at(begin);
        let back = back.replacen("0\t1\t0\n\t\t\t\t\t\t\t\t0\t0\t1", "0\t-1\t0\n\t\t\t\t\t\t\t\t0\t0\t-1", 1);
        assert_eq!(drive(&format!("{front}{back}")), "drive = '-1 - 0.1*t' }");
    }

    #[test]
    fn points_on_lines_without_rotation_are_sliders() {
        let held = SLIDER_CRANK.replace("CylindricalJoint", "PointInLineJoint");
        let joint = "\t\t\tNoRotationJoint\n\t\t\t\tName\n\t\t\t\t\tHeld\n\t\t\t\tMarkerI\n\
                     \t\t\t\t\t/Assembly1/Piston/Guide\n\
                     \t\t\t\tMarkerJ\n\t\t\t\t\t/Assembly1/Guide\n\t\tMotions";
        let scene = imported(&held.replace("\t\tMotions", joint)).expect("a scene");
        assert!(scene.contains("prismatic = [") && !scene.contains("Held"), "{scene}");
        // Without the joint that holds it, the piston may turn.
        let free = imported(&held).expect("a scene");
        assert!(free.contains("pin_in_slot = [") && free.contains("rate = 0"), "{free}");
    }

    #[test]
    fn parts_without_joints_move_freely_or_are_fixed() {
        let part = |mass: &str| {
            format!(
                "\t\tPart\n\t\t\tName\n\t\t\t\tblock\n\t\t\tPosition3D\n\t\t\t\t5\t6\t0\n\
                 \t\t\tVelocity3D\n\t\t\t\t3\t4\t1\n\t\t\tOmega3D\n\t\t\t\t0\t0\t2\n\t\t\tPrincipalMassMarker\n\
                 \t\t\t\tMass\n\t\t\t\t\t{mass}\n\t\t\t\tMomentOfInertias\n\t\t\t\t\t0\t0\t{mass}\n\tConstraintSets"
            )
        };
        let scene = |mass: &str| imported(&FOUR_BAR.replace("\tConstraintSets", &part(mass))).expect("a scene");
        let free = scene("2");
        assert!(free.contains("block_turn = { revolute = [\"block\", \"block_y\"] }"), "{free}");
        assert!(free.contains("inertia = 2, angle = 0, rate = 2 }"), "{free}");
        assert!(free.contains("start = 0, rate = 3 }") && free.contains("start = 0, rate = 4 }"), "{free}");
        assert!(free.contains("# - the velocity of part `block` out of the plane"), "{free}");
        let fixed = scene("0");
        assert!(fixed.contains("block = { weld = [\"block\", \"ground\"] }"), "{fixed}");
        assert!(fixed.contains("# - the motion of `block`, which has no mass"), "{fixed}");
    }

    #[test]
    fn velocities_that_contradict_the_joints_are_listed() {
        let crank = |rates: &str| {
            let begin = FOUR_BAR.find("\t\t\t\tcrank\n").expect("the crank") + "\t\t\t\tcrank\n".len();
            let (front, back) = FOUR_BAR.split_at(begin);
            imported(&format!("{front}{rates}{back}")).expect("a scene")
        };
        let note = "# - velocities of parts that contradict the joints";
        assert!(crank("\t\t\tVelocity3D\n\t\t\t\t0\t1\t0\n").contains(note));
        assert!(!crank("\t\t\tVelocity3D\n\t\t\t\t0\t0\t0\n").contains(note));
    }

    #[test]
    fn what_is_left_out_is_listed() {
        let text = FOUR_BAR.replace("2.0d*pi*time", "integral(time, 0)") + "TimeSeries\nNumber\tInput\t1\n";
        let scene = imported(&text).expect("a scene");
        assert!(scene.contains("# - the motion `Turn`, whose formula is `integral(time, 0)`"), "{scene}");
        assert!(scene.contains("# - the results that the file holds"), "{scene}");
    }

    #[test]
    fn errors_name_their_line() {
        let error = |from: &str, to: &str| imported(&FOUR_BAR.replacen(from, to, 1)).expect_err("no scene");
        for (from, to, said) in [
            ("RevoluteJoint", "UniversalJoint", "is a `UniversalJoint`"),
            ("/FourBar/crank/A", "/FourBar/crank/X", "is not a marker of the assembly"),
            ("0.2\n", "1e400\n", "should have one finite number"),
            ("1\t0\t0\n", "1\t1\t0\n", "this matrix is not a rotation"),
            ("1\t0\t0\n", "-1\t0\t0\n", "this matrix is not a rotation"),
            ("0.2\n", "-0.2\n", "the mass of part `crank` is negative"),
            ("Assembly\n", "Drawing\n", "it has no `Assembly`"),
            ("Parts\n", "Things\n", "the assembly has no parts"),
        ] {
            assert!(error(from, to).contains(said), "{}", error(from, to));
        }
    }

    #[test]
    fn files_that_are_not_whole_are_refused() {
        for (end, said) in [
            ("\t\tMotions\n", "the assembly ends before its `ConstantGravity`"),
            ("\tConstraintSets\n", "the assembly ends before its `ConstraintSets`"),
            ("\t\thout\n", "the assembly ends before its `hout`"),
        ] {
            let error = imported(&FOUR_BAR[..FOUR_BAR.find(end).expect("a line")]).expect_err("no scene");
            assert!(error.contains(said), "{error}");
        }
        let error = imported(&FOUR_BAR.replace('\t', "    ")).expect_err("no scene");
        assert!(error.contains("indentation is by tabs") && error.contains("model:3:1"), "{error}");
    }
}
