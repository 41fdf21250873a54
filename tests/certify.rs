//! Enclosures of motions against exact values.

use std::time::Instant;

use qrm_sim::analysis::{EnclosureEnd, enclose};

#[test]
fn look() {
    for (name, end) in [
        ("pendulum", EnclosureEnd::Time(10.0)),
        ("double-pendulum", EnclosureEnd::Time(1.0)),
        ("four-bar", EnclosureEnd::Time(20.0)),
        ("quick-return", EnclosureEnd::Time(0.5)),
        ("quick-return", EnclosureEnd::Turn { coordinate: 0, before: 10.0 }),
    ] {
        let model = qrm_model::MODELS.iter().find(|model| model.description.name == name).expect("a scene");
        let begun = Instant::now();
        let found = enclose(model, &|_| None, end, &|| false);
        println!("{name} {end:?} {:?}", begun.elapsed());
        let found = match found { Ok(found) => found, Err(e) => { println!("{:?}", e.reason); match e.reached { Some(r) => *r, None => continue } } };
        println!("steps {} t {:?} {:e}", found.steps, found.t, found.t.width());
        for x in found.q.iter().chain(&found.qd).chain(&found.outputs) {
            println!("  {:.17} {:.17}  {:.2e}", x.lo(), x.hi(), x.width());
        }
    }
}
