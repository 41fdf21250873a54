//! Runs the wiper in the rain and on a dry windscreen.

use qrm_sim::integrate::MethodSettings;
use qrm_sim::run::Simulation;
use wiper::MODELS;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wiper = &MODELS[0];
    let mut simulation = Simulation::new(wiper, &|_| None, MethodSettings::default(), None)?;
    print!("{:>6}", "t [s]");
    for output in wiper.description.outputs {
        print!("{:>14}", format!("{} [{}]", output.name, output.unit));
    }
    println!();
    for tenth in 0..=40 {
        if tenth == 20 {
            println!("the rain is over");
            simulation.replace(&|name| (name == "friction").then_some(3.0))?;
        }
        let t = simulation.advance(0.1 * f64::from(tenth))?.t;
        print!("{t:6.1}");
        for value in simulation.outputs() {
            print!("{value:14.6}");
        }
        println!();
    }
    Ok(())
}
