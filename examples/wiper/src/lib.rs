//! The equations of motion of a windscreen wiper, generated from `wiper.toml`.

include!(concat!(env!("OUT_DIR"), "/scenes.rs"));
