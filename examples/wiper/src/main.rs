//! Runs the wiper in the rain and on a dry windscreen.

use qrm_sim::motion::Method;
use qrm_sim::simulation::Simulation;
use wiper::wiper::{DESCRIPTION, Parameters, Wiper};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut simulation = Simulation::new(Wiper::default(), Method::default(), None)?;
    print!("{:>6}", "t [s]");
    for output in DESCRIPTION.outputs {
        print!("{:>14}", format!("{} [{}]", output.name, output.unit));
    }
    println!();
    for tenth in 0..=40 {
        if tenth == 20 {
            println!("the rain is over");
            let dry = Parameters { friction: 3.0, ..*simulation.mechanism().parameters() };
            simulation.replace(Wiper::new(dry))?;
        }
        let t = simulation.advance(0.1 * f64::from(tenth))?.t;
        let mut outputs = [0.0; DESCRIPTION.outputs.len()];
        simulation.outputs(&mut outputs);
        print!("{t:6.1}");
        for value in outputs {
            print!("{value:14.6}");
        }
        println!();
    }
    Ok(())
}
